//! Wide selections are the scalar ones.
use super::super::Avx2;
use super::select_pixels;
use crate::data::{Camera, NONE, SurfacePoint};
use crate::shared::hash::{hash2, unit};
use crate::shared::octahedral;
use crate::stages::select_pixels::select_each;
use bytemuck::Zeroable;
use glam::Vec3;

fn random(i: u32, k: u32) -> f32 {
    unit(hash2(i, k)) * 2.0 - 1.0
}

fn vector(i: u32, k: u32) -> Vec3 {
    Vec3::new(random(i, k), random(i, k + 1), random(i, k + 2))
}

/// A wall, curved here and there, with steps, holes, other nodes and what is not a number.
fn point(i: u32, width: u32) -> SurfacePoint {
    let (x, y) = ((i % width) as f32, (i / width) as f32);
    let near = |k: u32, by: f32| octahedral::pack((Vec3::Z + vector(i, k) * by).normalize());
    let mut point = SurfacePoint {
        position: Vec3::new(x * 0.01, y * 0.01, 0.0),
        offset: 1e-6,
        geometric_normal: near(0, 0.0),
        shading_normal: near(0, 0.0),
        transform_id: 3,
        ..SurfacePoint::zeroed()
    };
    match hash2(i, 1) % 40 {
        0 => point.transform_id = NONE,
        1 => point.transform_id = 4,
        2 => point.position.z = random(i, 5) * 0.004,
        3..14 => point.shading_normal = near(6, 0.5),
        14..22 => point.geometric_normal = near(9, 0.2),
        22 => point.geometric_normal = hash2(i, 12),
        23 => point.shading_normal = hash2(i, 13),
        24 => point.position.x = f32::NAN,
        25 => point.position.y = f32::INFINITY,
        _ => {}
    }
    point
}

#[test]
fn wide_selections_are_the_scalar_ones() {
    if Avx2::detect().is_none() {
        eprintln!("not run: this processor has no AVX2");
        return;
    }
    for [width, height] in [
        [200, 101],
        [201, 100],
        [64, 64],
        [1, 90],
        [90, 1],
        [2, 2],
        [17, 33],
        [0, 0],
    ] {
        let camera = Camera {
            eye: Vec3::new(1.0, 1.0, 3.0),
            width,
            height,
            pixel_angle: 0.004,
            ..Camera::zeroed()
        };
        // Some points lie beyond the picture.
        let count = (width * height + 70) as usize;
        let points: Vec<SurfacePoint> = (0..count as u32).map(|i| point(i, width.max(1))).collect();
        for group in [64, 1, 7, 100_000] {
            let (mut each, mut wide) = (vec![2; count], vec![2; count]);
            for start in (0..count).step_by(group) {
                let range = start..count.min(start + group);
                select_each(&camera, &points, range.clone(), |i, selected| {
                    each[i] = u32::from(selected);
                });
                select_pixels(&camera, &points, range, |i, selected| {
                    assert_eq!(wide[i], 2, "{i} is set twice");
                    wide[i] = u32::from(selected);
                });
            }
            assert_eq!(each, wide, "{width} x {height} by {group}");
            let selected = each.iter().filter(|&&s| s == 1).count();
            assert!(
                width * height < 5000 || (selected > count * 2 / 5 && selected < count * 9 / 10),
                "{selected} of {count}"
            );
        }
    }
}
