//! Wide samples have the scalar ones' bits.
use super::super::Avx2;
use super::sample_lights;
use crate::data::{Frame, Light, LightSample, NONE, Ray, SurfacePoint};
use crate::shared::hash::{hash2, unit};
use crate::stages::sample_lights::sample_each;
use bytemuck::Zeroable;
use glam::Vec3;
use std::ops::Range;

const POINTS: u32 = 3000;

fn random(i: u32, k: u32) -> f32 {
    unit(hash2(i, k)) * 2.0 - 1.0
}

fn vector(i: u32, k: u32) -> Vec3 {
    Vec3::new(random(i, k), random(i, k + 1), random(i, k + 2))
}

/// Every seventh point is none, some are at a light, some are far away; normals are any bits.
fn point(i: u32) -> SurfacePoint {
    SurfacePoint {
        position: match i % 29 {
            3 => light(i % 5).position,
            4 => vector(i, 0) * 1e20,
            5 => vector(i, 0) * 1e-30,
            6 => Vec3::splat(f32::NAN),
            7 => Vec3::new(f32::INFINITY, 0.0, 1.0),
            _ => vector(i, 0) * 10.0,
        },
        offset: random(i, 3).abs() * 1e-4,
        geometric_normal: hash2(i, 4),
        shading_normal: match i % 31 {
            0 => 0,
            1 => u32::MAX,
            _ => hash2(i, 5),
        },
        transform_id: if i % 7 == 2 { NONE } else { i },
        ..SurfacePoint::zeroed()
    }
}

/// Lights of each kind: some dark, in a channel or all, some with cones that are the same, or the wrong way round.
fn light(i: u32) -> Light {
    let inner = random(i, 20).abs();
    Light {
        position: vector(i, 21) * 5.0,
        kind: i % 3,
        intensity: match i % 13 {
            4 => Vec3::ZERO,
            5 => Vec3::new(0.0, 3.0, 0.0),
            6 => vector(i, 24),
            7 => Vec3::splat(1e38),
            8 => Vec3::new(f32::NAN, 1.0, -0.0),
            _ => vector(i, 24).abs() * 20.0,
        },
        cos_outer: match i % 4 {
            0 => inner,
            1 => inner + 0.1,
            _ => inner * 0.6,
        },
        direction: vector(i, 27).try_normalize().unwrap_or(Vec3::Z),
        cos_inner: inner,
    }
}

type Samples = Vec<(usize, Ray, LightSample)>;

fn both(frame: &Frame, lights: &[Light], range: Range<usize>) -> [Samples; 2] {
    let points: Vec<SurfacePoint> = (0..POINTS).map(point).collect();
    let (mut each, mut wide) = (vec![], vec![]);
    sample_each(frame, &points, lights, range.clone(), |i, ray, sample| {
        each.push((i, ray, sample));
    });
    sample_lights(frame, &points, lights, range, |i, ray, sample| {
        wide.push((i, ray, sample));
    });
    [each, wide]
}

fn same(what: &str, [each, wide]: &[Samples; 2]) {
    assert_eq!(each.len(), wide.len(), "{what}");
    for ((i, ray, sample), (j, wide_ray, wide_sample)) in each.iter().zip(wide) {
        assert_eq!(i, j, "{what}");
        assert_eq!(
            (bytemuck::bytes_of(ray), bytemuck::bytes_of(sample)),
            (
                bytemuck::bytes_of(wide_ray),
                bytemuck::bytes_of(wide_sample)
            ),
            "{what}, {i}: {ray:?} {sample:?}, wide {wide_ray:?} {wide_sample:?}"
        );
    }
}

#[test]
fn wide_samples_are_the_scalar_ones() {
    if Avx2::detect().is_none() {
        eprintln!("not run: this processor has no AVX2");
        return;
    }
    let all: Vec<Light> = (0..61).map(light).collect();
    // Lights, and how many of them each point asks.
    for (count, each) in [
        (0, 1),
        (1, 0),
        (1, 1),
        (2, 1),
        (3, 3),
        (4, 8),
        (7, 3),
        (61, 4),
        (61, 1),
        (61, 64),
    ] {
        for first in 0..3 {
            let lights = &all[first.min(61 - count)..][..count];
            let frame = Frame {
                number: 77,
                seed: first as u32,
                lights: count as u32,
                lights_per_point: each,
                ..Frame::zeroed()
            };
            let range = 0..(POINTS * each.max(1)) as usize;
            let found = both(&frame, lights, range);
            let lit = found[0].iter().filter(|s| s.1.t_max > 0.0).count();
            assert!(lit > 200 || count == 0 || count < 3, "{lit} are lit");
            same(&format!("{count} lights, {each} each"), &found);
        }
    }
}

/// Ranges that no eight fits, that begin between a point's lights, and empty ones.
#[test]
fn ranges_need_not_be_whole_eights() {
    if Avx2::detect().is_none() {
        eprintln!("not run: this processor has no AVX2");
        return;
    }
    let lights: Vec<Light> = (0..5).map(light).collect();
    for each in [1, 3, 5] {
        let frame = Frame {
            lights: 5,
            lights_per_point: each,
            ..Frame::zeroed()
        };
        for (start, count) in [(0, 0), (0, 1), (5, 7), (191, 64), (2990, 10), (64, 64)] {
            let what = format!("{each} each, {count} from {start}");
            same(&what, &both(&frame, &lights, start..start + count));
        }
    }
}
