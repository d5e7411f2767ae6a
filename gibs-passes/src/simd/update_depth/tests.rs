//! Wide depth functions have the scalar ones' bits.
use super::super::Avx2;
use super::update_depth;
use crate::data::{Hit, Ray, SurfelIrradiance, SurfelPose};
use crate::shared::depth::UNKNOWN;
use crate::shared::hash::{hash2, unit};
use crate::stages::update_depth::{Distances, update_each};
use bytemuck::Zeroable;
use glam::{UVec2, Vec3};
use std::cell::Cell;
use std::ops::Range;

const SURFELS: u32 = 2000;

fn random(i: u32, k: u32) -> f32 {
    unit(hash2(i, k)) * 2.0 - 1.0
}

fn direction(i: u32, k: u32) -> Vec3 {
    let v = Vec3::new(random(i, k), random(i, k + 1), random(i, k + 2));
    v.try_normalize().unwrap_or(Vec3::Z)
}

/// Every 19th surfel is a point, some face -z, where the basis changes its sign.
fn pose(i: u32) -> SurfelPose {
    SurfelPose {
        position: direction(i, 0),
        radius: if i.is_multiple_of(19) {
            0.0
        } else {
            0.3 + 0.2 * random(i, 3)
        },
        normal: match i % 10 {
            0 => Vec3::NEG_Z,
            1 => Vec3::X,
            _ => direction(i, 4),
        },
        mark: hash2(i, 9),
    }
}

/// Many lie below the surface; some go nowhere, some have a direction that is none.
fn ray(i: u32) -> Ray {
    Ray {
        direction: match i % 47 {
            0 => Vec3::ZERO,
            1 => Vec3::splat(f32::NAN),
            2 => Vec3::Z,
            3 => direction(i, 10) * 1e30,
            _ => direction(i, 10),
        },
        t_max: match i % 9 {
            0 => 0.0,
            1 => -1.0,
            2 => f32::NAN,
            _ => f32::MAX,
        },
        ..Ray::zeroed()
    }
}

fn hit(i: u32) -> Hit {
    Hit::miss(match i % 23 {
        0 => f32::INFINITY,
        1 => 0.0,
        2 => -1.0,
        3 => f32::NAN,
        4 => f32::MAX,
        _ => random(i, 14).abs(),
    })
}

fn texel(i: u32) -> u32 {
    match hash2(i, 15) {
        bits if bits & 3 == 0 => UNKNOWN,
        // A guess.
        bits if bits & 3 == 1 => bits >> 16,
        bits => bits,
    }
}

type Cells<'a> = &'a [Cell<u32>];

#[test]
fn wide_depth_functions_are_the_scalar_ones() {
    if Avx2::detect().is_none() {
        eprintln!("not run: this processor has no AVX2");
        return;
    }
    let poses: Vec<SurfelPose> = (0..SURFELS).map(pose).collect();
    let irradiance: Vec<SurfelIrradiance> = (0..SURFELS)
        .map(|i| SurfelIrradiance {
            drawn: match i % 5 {
                0 => 0,
                1 => hash2(i, 16) / 2,
                _ => hash2(i, 17) % 300,
            },
            ..SurfelIrradiance::zeroed()
        })
        .collect();
    // Up to 15 rays each, none for many, and for a few more than a batch.
    let (mut spans, mut count) = (vec![], 0);
    for i in 0..SURFELS {
        let bits = hash2(i, 18);
        let rays = match bits % 50 {
            0 => 200,
            1..20 => 0,
            _ => bits >> 28,
        };
        spans.push(UVec2::new(count, rays));
        count += rays;
    }
    let rays: Vec<Ray> = (0..count).map(ray).collect();
    let hits: Vec<Hit> = (0..count).map(hit).collect();
    let sorted: Vec<u32> = (0..count).map(|i| count - 1 - i).collect();
    for (places, side) in [(&[][..], 4), (&sorted, 4), (&[], 2), (&sorted, 7), (&[], 8)] {
        let distances = Distances {
            poses: &poses,
            irradiance: &irradiance,
            spans: &spans,
            rays: &rays,
            hits: &hits,
            places,
            least: 0.03,
            side,
        };
        for group in [64, 1, SURFELS as usize] {
            let ranges = || {
                let all = SURFELS as usize;
                (0..all)
                    .step_by(group)
                    .map(move |start| start..all.min(start + group))
            };
            let run = |update: &dyn Fn(Range<usize>, Cells<'_>)| {
                let mut depths: Vec<u32> = (0..SURFELS * side * side).map(texel).collect();
                let cells = Cell::from_mut(&mut depths[..]).as_slice_of_cells();
                ranges().for_each(|range| update(range, cells));
                depths
            };
            let each = run(&|range, cells| {
                let (get, set) = (|i: usize| cells[i].get(), |i: usize, d| cells[i].set(d));
                update_each(&distances, range, get, set);
            });
            let wide = run(&|range, cells| {
                let (get, set) = (|i: usize| cells[i].get(), |i: usize, d| cells[i].set(d));
                update_depth(&distances, range, get, set);
            });
            for (i, (each, wide)) in each.iter().zip(&wide).enumerate() {
                assert_eq!(each, wide, "side {side}, texel {i}");
            }
        }
    }
}
