//! Surfels are placed eight at a time with the bits that each has alone.
use super::super::Avx2;
use super::place;
use crate::data::{Camera, SurfelBirth, SurfelSettings, Transform};
use crate::shared::grid::GridLayout;
use crate::shared::hash::{hash2, unit};
use crate::shared::lengths;
use crate::stages::positional_update::{View, place_each};
use glam::{Vec3, Vec4};

fn random(i: u32, k: u32) -> f32 {
    unit(hash2(i, k)) * 2.0 - 1.0
}

fn vector(i: u32, k: u32) -> Vec3 {
    Vec3::new(random(i, k), random(i, k + 1), random(i, k + 2))
}

/// Turned, stretched and moved; the first one not at all.
fn transform(i: u32) -> Transform {
    let unit = [Vec4::X, Vec4::Y, Vec4::Z];
    if i == 0 {
        return Transform {
            to_world: unit,
            to_local: unit,
        };
    }
    let row = |k| vector(i, k).extend(random(i, k + 3) * 5.0);
    Transform {
        to_world: [row(0), row(4), row(8)],
        to_local: [row(12), row(16), row(20)],
    }
}

/// At the eye, near it and beyond the grid; with no clearance, some, and all there is.
fn birth(i: u32) -> SurfelBirth {
    let clearance = [0.0, 0.01, 0.3, f32::MAX][hash2(i, 30) as usize % 4];
    SurfelBirth {
        position: vector(i, 31) * [0.0, 1.0, 2000.0][hash2(i, 34) as usize % 3],
        normal: hash2(i, 35),
        plane: hash2(i, 36),
        lengths: lengths::pack(1e-4, clearance),
        ..SurfelBirth::default()
    }
}

#[test]
fn eight_surfels_are_placed_as_each_is() {
    if Avx2::detect().is_none() {
        eprintln!("not run: this processor has no AVX2");
        return;
    }
    let camera = Camera {
        pixel_angle: 0.003,
        ..Camera::default()
    };
    let settings = SurfelSettings {
        radius_pixels: 4.4,
        ..SurfelSettings::default()
    };
    let grid = GridLayout::new(16, 128.0).at(Vec3::splat(0.2), 1.0);
    let view = View {
        camera: &camera,
        grid: &grid,
        settings: &settings,
    };
    let transforms: Vec<_> = (0..5).map(transform).collect();
    for case in 0..3000u32 {
        let births = std::array::from_fn(|lane| birth(8 * case + lane as u32));
        let node = |lane: usize| match case % 3 {
            0 => 0,
            1 => case as usize % 5,
            _ => hash2(case, lane as u32) as usize % 5,
        };
        let of = std::array::from_fn(|lane| &transforms[node(lane)]);
        let (each, wide) = (place_each(&view, &births, &of), place(&view, &births, &of));
        assert_eq!(
            bytemuck::cast_slice::<_, u32>(&each),
            bytemuck::cast_slice::<_, u32>(&wide),
            "{each:?}, wide {wide:?}"
        );
        assert!(each.iter().all(|pose| pose.radius >= 0.0));
    }
}
