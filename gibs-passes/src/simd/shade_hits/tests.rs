//! Wide radiance has the scalar one's bits.
use super::super::Avx2;
use super::shade_hits;
use crate::data::{Frame, Gathered, NONE, Path, Ray, SurfacePoint};
use crate::shared::hash::{hash2, unit};
use crate::shared::surface;
use crate::stages::shade_hits::{Hits, Shaded, shade_each};
use bytemuck::Zeroable;
use glam::{Vec3, Vec4};
use std::ops::Range;

const COUNT: u32 = 5000;

fn random(i: u32, k: u32) -> f32 {
    unit(hash2(i, k))
}

fn vector(i: u32, k: u32) -> Vec3 {
    Vec3::new(random(i, k), random(i, k + 1), random(i, k + 2))
}

fn direction(i: u32, k: u32) -> Vec3 {
    let v = vector(i, k) * 2.0 - 1.0;
    v.try_normalize().unwrap_or(Vec3::Z)
}

/// Every fifth ray missed; some surfaces shine, some of these may be drawn as emitters; every tenth is black.
fn point(i: u32) -> SurfacePoint {
    let flags = if i % 6 == 1 { surface::EMITTER } else { 0 };
    let albedo = vector(i, 4) * if i % 10 == 3 { 0.0 } else { 1.0 };
    let (albedo_rg, albedo_b_flags) = surface::pack_albedo(albedo, flags);
    SurfacePoint {
        position: direction(i, 0) * 3.0,
        geometric_normal: hash2(i, 3),
        albedo_rg,
        albedo_b_flags,
        emission: match i % 3 {
            1 => vector(i, 8) * 10.0,
            _ => Vec3::ZERO,
        },
        transform_id: if i % 5 == 2 { NONE } else { i },
        ..SurfacePoint::zeroed()
    }
}

/// Some were sent to emitters, of which some arrive; some have no density or no cosine.
fn path(i: u32) -> Path {
    Path {
        throughput: vector(i, 12),
        root: hash2(i, 15),
        seed: hash2(i, 16),
        surfel: hash2(i, 17),
        cosine: match i % 17 {
            4 => 0.0,
            5 => -0.5,
            _ => random(i, 18),
        },
        density: match i % 13 {
            3 => 0.0,
            4 => 1e-38,
            5..8 => -random(i, 19),
            _ => random(i, 19),
        },
    }
}

fn ray(i: u32) -> Ray {
    Ray {
        direction: direction(i, 20),
        t_max: [f32::MAX, 3.0, 2.0, 1.0][i as usize % 4],
        ..Ray::zeroed()
    }
}

/// All weights from none to one, some of it trusted.
fn gathered(i: u32) -> Gathered {
    let share = |k| [0.0, 1.0, random(i, k)][hash2(i, k + 1) as usize % 3];
    Gathered {
        irradiance: vector(i, 24) * 5.0,
        weight: share(27),
        average: vector(i, 29) * 5.0,
        confidence: share(32),
    }
}

#[test]
fn wide_radiance_is_the_scalar_one() {
    if Avx2::detect().is_none() {
        eprintln!("not run: this processor has no AVX2");
        return;
    }
    let ids = || 0..COUNT;
    let rays: Vec<_> = ids().map(ray).collect();
    let points: Vec<_> = ids().map(point).collect();
    let gathered: Vec<_> = ids().map(gathered).collect();
    let direct: Vec<_> = ids().map(|i| vector(i, 36).extend(0.0)).collect();
    let sky: Vec<Vec4> = (0..64).map(|i| vector(i, 40).extend(1.0)).collect();
    let frame = Frame {
        environment_side: 8,
        emitter_power: 7.0,
        ..Frame::zeroed()
    };
    for (direct, environment, ends) in [
        (&direct[..], &sky[..], false),
        (&direct, &sky, true),
        (&[], &[], false),
        (&direct, &[], true),
    ] {
        let hits = Hits {
            frame: &frame,
            rays: &rays,
            points: &points,
            direct,
            gathered: &gathered,
            environment,
            ends,
        };
        let bits = |(i, s): &(usize, Shaded)| {
            let goes_on = s.goes_on.map(|path| bytemuck::bytes_of(&path).to_vec());
            (*i, s.root, s.added.to_array().map(f32::to_bits), goes_on)
        };
        let all = COUNT as usize;
        let ranges: [Range<usize>; 5] = [0..all, 7..7, 64..128, 3..4, all - 11..all];
        for range in ranges {
            let (mut each, mut wide) = (vec![], vec![]);
            shade_each(
                &hits,
                range.clone(),
                |i| path(i as u32),
                |i, s| each.push((i, s)),
            );
            shade_hits(
                &hits,
                range.clone(),
                |i| path(i as u32),
                |i, s| wide.push((i, s)),
            );
            assert_eq!(each.len(), range.len());
            assert_eq!(wide.len(), range.len());
            for (each, wide) in each.iter().zip(&wide) {
                assert_eq!(bits(each), bits(wide), "{each:?}, wide {wide:?}");
            }
            let going = each.iter().filter(|(_, s)| s.goes_on.is_some()).count();
            assert!(
                range.len() < 100 || (going * 20 > range.len()) != ends,
                "{going} go on"
            );
        }
    }
}
