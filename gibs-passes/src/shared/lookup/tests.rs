//! Tests of `shared/lookup.rs`; `simd/tests.rs` holds the wide lookups against these.
use super::*;
use crate::data::SurfelSettings;
use crate::shared::bounds;
use crate::shared::depth::{Depths, UNKNOWN};
use crate::shared::grid::{self, GridLayout};
use glam::UVec2;

/// What is gathered at the origin, with normal z, from surfels of these radii and lights there.
fn gathered(surfels: &[(f32, f32)]) -> Gathered {
    let poses = (0..).zip(surfels).map(|(mark, &(radius, _))| SurfelPose {
        position: Vec3::ZERO,
        radius,
        normal: Vec3::Z,
        mark,
    });
    let light: Vec<f32> = surfels.iter().map(|surfel| surfel.1).collect();
    from(&poses.collect::<Vec<_>>(), &light, None)
}

/// What is gathered at the origin, with normal z, from surfels with these lights, whose depth functions are open.
fn from(poses: &[SurfelPose], light: &[f32], beyond: Option<f32>) -> Gathered {
    let layout = GridLayout::new(4, 10.0);
    let grid = layout.at(Vec3::ONE, 4.0);
    let cell = grid::cell(Vec3::ZERO, &grid);
    let light: Vec<SurfelLight> = light
        .iter()
        .map(|&irradiance| SurfelLight {
            irradiance: Vec3::splat(irradiance),
            trust: 1.0,
        })
        .collect();
    let steps = bounds::steps_in(cell, &grid);
    let bounds = |pose: &SurfelPose| bounds::pack(pose.position - grid.centre, pose.radius, steps);
    let count = poses.len() as u32;
    let entries: Vec<u32> = (0..count).chain(poses.iter().map(bounds)).collect();
    let mut cells = vec![UVec2::ZERO; layout.cells() as usize];
    cells[cell as usize] = UVec2::new(0, count);
    let settings = SurfelSettings {
        lookup: 128,
        ..SurfelSettings::default()
    };
    let depths = vec![UNKNOWN; 16 * poses.len()];
    let s = Surfels {
        cells: &cells,
        entries: &entries,
        poses,
        depths: Depths::new(&depths, 4),
        grid: &grid,
        settings: &settings,
    };
    let place = Place {
        position: Vec3::ZERO,
        normal: Vec3::Z,
        list: s.around(Vec3::ZERO),
    };
    let beyond = beyond.map(Vec3::splat);
    gather(&place, f32::MAX, beyond, &s, &light)
}

/// A kernel spread over its disc: half the radius counts four times.
#[test]
fn surfels_count_by_their_kernels_over_their_areas() {
    let one = gathered(&[(0.8, 3.0)]);
    assert_eq!((one.irradiance.x, one.weight), (3.0, 1.0));
    let alike = gathered(&[(0.8, 3.0), (0.8, 5.0)]);
    assert!((alike.irradiance.x - 4.0).abs() < 1e-6);
    let unlike = gathered(&[(0.8, 3.0), (0.4, 5.0)]);
    assert!((unlike.irradiance.x - (3.0 + 4.0 * 5.0) / 5.0).abs() < 1e-5);
}

/// At every size that a scene can have, and light that is a power of two as bright.
#[test]
fn neither_size_nor_brightness_changes_the_mean() {
    let at = |size: f32, light: f32| {
        let g = gathered(&[(0.8 * size, 3.0 * light), (0.4 * size, 5.0 * light)]);
        g.irradiance.x / light
    };
    for exponent in [-40, -16, -4, 0] {
        let size = 2f32.powi(exponent);
        for light in [-40, 0, 40] {
            assert_eq!(
                at(size, 2f32.powi(light)),
                at(1.0, 1.0),
                "2^{exponent}, 2^{light}"
            );
        }
    }
}

/// A surfel covers a disc of its surface, though its light comes over a normal that leans away from it, and next to nothing
/// off it.
#[test]
fn a_surfel_covers_its_plane_whatever_its_normal() {
    for across in [Vec3::Z, Vec3::new(0.48, -0.6, 0.64)] {
        let along = across.any_orthonormal_vector();
        for lean in [0.0f32, 0.5, 1.0] {
            let pose = SurfelPose {
                position: Vec3::ZERO,
                radius: 0.5,
                normal: (across + lean * along).normalize(),
                mark: plane::pack(across),
            };
            for share in [0.1f32, 0.5, 0.9] {
                let d = 0.5 * share * along;
                // The plane's 16 bits turn it by up to 0.017 radians, and the square of that counts 15 times.
                let within = 1.0 - share * share;
                assert!(
                    (nearness(d, &pose) - within).abs() < 5e-3,
                    "{lean}, {share}"
                );
                let off = 0.5 * share * across;
                let beyond = (1.0 - 16.0 * share * share).max(0.0);
                assert!(
                    (nearness(off, &pose) - beyond).abs() < 5e-3,
                    "{lean}, {share}"
                );
            }
        }
    }
}

/// In a hole the cell's surfels stand in, though they lean away or are farther than their diameters, but for those that face
/// the other way.
#[test]
fn the_average_reaches_where_no_surfel_does() {
    let pose = |position, normal: Vec3| SurfelPose {
        position,
        radius: 0.2,
        normal: normal.normalize(),
        mark: 0,
    };
    let leaning = pose(Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 0.6, 0.8));
    let turned = pose(Vec3::new(-0.5, 0.5, 0.0), Vec3::new(0.0, 0.6, -0.8));
    let hole = from(&[leaning, turned], &[3.0, 5.0], Some(7.0));
    assert_eq!(hole.weight, 0.0);
    // The squared cosine is 0.64, more than what an average is made up from.
    assert!((hole.average.x - 3.0).abs() < 1e-5, "{}", hole.average);
    assert_eq!(from(&[leaning], &[3.0], None).average, Vec3::ZERO);
    // Cosine 0.4: 0.16 of the light, of which less than a quarter is not made up to a whole.
    let steep = pose(
        Vec3::new(1.0, 0.0, 0.0),
        Vec3::new(0.0, 0.84f32.sqrt(), 0.4),
    );
    let dim = from(&[steep], &[3.0], Some(0.0)).average.x;
    assert!((dim - 3.0 * 0.16 / AVERAGE_LEAST).abs() < 1e-4, "{dim}");
    // Where it is known what is beyond, that is made up with it.
    let filled = from(&[steep], &[3.0], Some(7.0)).average.x;
    let (cell, rest) = (0.16 / AVERAGE_LEAST, 1.0 - 0.16 / AVERAGE_LEAST);
    assert!(
        (filled - (3.0 * cell + 7.0 * rest)).abs() < 1e-4,
        "{filled}"
    );
    assert_eq!(from(&[], &[], Some(7.0)).average, Vec3::splat(7.0));
}
