//! Wide rays have the scalar ones' bits.
use super::super::Avx2;
use super::generate_rays;
use crate::data::{Frame, Path, Ray, SurfelBirth, SurfelIrradiance, SurfelPose};
use crate::shared::guide::Guides;
use crate::shared::hash::{hash2, unit};
use crate::shared::lengths;
use crate::stages::generate_rays::{Surfels, generate_each};
use bytemuck::Zeroable;
use glam::{UVec2, Vec3};
use std::ops::Range;

const SURFELS: u32 = 3000;

fn random(i: u32, k: u32) -> f32 {
    unit(hash2(i, k)) * 2.0 - 1.0
}

fn direction(i: u32, k: u32) -> Vec3 {
    let v = Vec3::new(random(i, k), random(i, k + 1), random(i, k + 2));
    v.try_normalize().unwrap_or(Vec3::Z)
}

/// Some face along the axes, where the basis changes its sign, some lie far away.
fn pose(i: u32) -> SurfelPose {
    SurfelPose {
        position: direction(i, 0) * [1e-20, 1.0, 1e20][i as usize % 3],
        radius: random(i, 3).abs(),
        normal: match i % 10 {
            0 => Vec3::NEG_Z,
            1 => Vec3::X,
            2 => -direction(i, 4),
            _ => direction(i, 4),
        },
        mark: hash2(i, 7),
    }
}

type Made = Vec<(usize, Ray, Path)>;

/// Most surfels have a few rays, some none, and some many.
fn both(frame: &Frame, range: Range<usize>) -> [Made; 2] {
    let ids = || 0..SURFELS;
    let poses: Vec<_> = ids().map(pose).collect();
    let births = ids().map(|i| SurfelBirth {
        lengths: lengths::pack(random(i, 8).abs() * 1e-4, 1.0),
        ..SurfelBirth::zeroed()
    });
    let irradiance = ids().map(|i| SurfelIrradiance {
        drawn: match i % 5 {
            0 => 0,
            1 => u32::MAX - 1,
            _ => hash2(i, 9),
        },
        ..SurfelIrradiance::zeroed()
    });
    let (mut spans, mut next) = (vec![], 17);
    for i in ids() {
        let rays = [0, 1, 2, 3, 4, 7, 64][hash2(i, 10) as usize % 7];
        spans.push(UVec2::new(next, rays));
        next += rays;
    }
    let (births, irradiance) = (births.collect::<Vec<_>>(), irradiance.collect::<Vec<_>>());
    let surfels = Surfels {
        frame,
        poses: &poses,
        births: &births,
        irradiance: &irradiance,
        spans: &spans,
        emitters: &[],
        guides: Guides::default(),
    };
    let (mut each, mut wide) = (vec![], vec![]);
    generate_each(&surfels, range.clone(), |i, ray, path| {
        each.push((i, ray, path))
    });
    generate_rays(&surfels, range, |i, ray, path| wide.push((i, ray, path)));
    [each, wide]
}

#[test]
fn wide_rays_are_the_scalar_ones() {
    if Avx2::detect().is_none() {
        eprintln!("not run: this processor has no AVX2");
        return;
    }
    for (number, seed) in [(0, 0), (1, 7), (u32::MAX, u32::MAX)] {
        let frame = Frame {
            number,
            seed,
            ..Frame::zeroed()
        };
        let all = SURFELS as usize;
        for range in [0..all, 5..5, 64..128, 1..2, all - 3..all] {
            let [each, wide] = both(&frame, range.clone());
            assert_eq!(each.len(), wide.len(), "{range:?}");
            for ((i, ray, path), (j, wide_ray, wide_path)) in each.iter().zip(&wide) {
                assert_eq!(i, j, "{range:?}");
                assert_eq!(
                    (bytemuck::bytes_of(ray), bytemuck::bytes_of(path)),
                    (bytemuck::bytes_of(wide_ray), bytemuck::bytes_of(wide_path)),
                    "{i}: {ray:?} {path:?}, wide {wide_ray:?} {wide_path:?}"
                );
            }
        }
    }
}
