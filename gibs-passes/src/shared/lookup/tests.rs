//! Tests of `shared/lookup.rs`; `simd/tests.rs` holds the wide lookups against these.
use super::*;
use crate::data::SurfelSettings;
use crate::shared::bounds;
use crate::shared::grid::{self, GridLayout};
use glam::UVec2;

/// What is gathered at the origin, with normal z, from surfels of these radii and lights there.
fn gathered(surfels: &[(f32, f32)]) -> Gathered {
    let layout = GridLayout::new(4, 10.0);
    let grid = layout.at(Vec3::ONE, 4.0);
    let cell = grid::cell(Vec3::ZERO, &grid);
    let poses: Vec<SurfelPose> = (0..)
        .zip(surfels)
        .map(|(identity, &(radius, _))| SurfelPose {
            position: Vec3::ZERO,
            radius,
            normal: Vec3::Z,
            identity,
        })
        .collect();
    let light: Vec<SurfelLight> = surfels
        .iter()
        .map(|&(_, irradiance)| SurfelLight {
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
    let s = Surfels {
        cells: &cells,
        entries: &entries,
        poses: &poses,
        depths: &[],
        grid: &grid,
        settings: &settings,
    };
    let place = Place {
        position: Vec3::ZERO,
        normal: Vec3::Z,
        list: s.around(Vec3::ZERO),
    };
    gather(&place, f32::MAX, false, &s, &light)
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
