//! Wide segments have the scalar ones' bits.
use super::super::Avx2;
use super::continue_paths;
use crate::data::{Path, Ray, SurfacePoint};
use crate::shared::hash::{hash2, unit};
use crate::stages::continue_paths::{Paths, continue_each};
use bytemuck::Zeroable;
use glam::Vec3;

const COUNT: u32 = 4000;

fn vector(i: u32, k: u32) -> Vec3 {
    Vec3::from_array([0, 1, 2].map(|axis| unit(hash2(i, k + axis)) * 2.0 - 1.0))
}

/// Normals are any bits.
fn point(i: u32) -> SurfacePoint {
    SurfacePoint {
        position: vector(i, 0) * [1e-20, 1.0, 1e20][i as usize % 3],
        offset: unit(hash2(i, 3)) * 1e-4,
        geometric_normal: hash2(i, 4),
        shading_normal: match i % 31 {
            0 => 0,
            1 => u32::MAX,
            _ => hash2(i, 5),
        },
        ..SurfacePoint::zeroed()
    }
}

fn path(i: u32) -> Path {
    Path {
        throughput: vector(i, 6),
        root: hash2(i, 9),
        seed: hash2(i, 10),
        surfel: hash2(i, 12),
        ..Path::zeroed()
    }
}

#[test]
fn wide_segments_are_the_scalar_ones() {
    if Avx2::detect().is_none() {
        eprintln!("not run: this processor has no AVX2");
        return;
    }
    let ids = || 0..COUNT;
    let points: Vec<_> = ids().map(point).collect();
    let all_paths: Vec<_> = ids().map(path).collect();
    // None, some, and all of them.
    for every in [u32::MAX, 7, 2, 1] {
        let going = |i: u32| u32::from(hash2(i, 11).is_multiple_of(every));
        let words = || ids().step_by(32);
        let goes_on: Vec<_> = words()
            .map(|first| (0..32).fold(0, |word, bit| word | going(first + bit) << bit))
            .collect();
        let before: Vec<_> = words()
            .map(|first| (0..first).map(going).sum::<u32>())
            .collect();
        let paths = Paths {
            points: &points,
            paths: &all_paths,
            goes_on: &goes_on,
            before: &before,
            emitters: &[],
        };
        let all = COUNT as usize;
        for range in [0..all, 9..9, 64..128, 3..4, all - 75..all] {
            let (mut each, mut wide) = (vec![], vec![]);
            let bits = |ray: &Ray, path: &Path| {
                [bytemuck::bytes_of(ray), bytemuck::bytes_of(path)].concat()
            };
            continue_each(&paths, range.clone(), |i, ray, path| {
                each.push((i, bits(&ray, &path)));
            });
            continue_paths(&paths, range.clone(), |i, ray, path| {
                wide.push((i, bits(&ray, &path)));
            });
            assert_eq!(each, wide, "{range:?} of every {every}");
            assert!(every != 1 || each.len() == range.len());
            let places = range.clone().filter(|&i| going(i as u32) != 0);
            let places = places.map(|i| (0..i as u32).map(going).sum::<u32>() as usize);
            assert!(each.iter().map(|(place, _)| *place).eq(places));
        }
    }
}
