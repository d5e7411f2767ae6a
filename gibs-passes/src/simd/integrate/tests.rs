//! Wide integration has the scalar one's bits.
use super::super::Avx2;
use super::integrate;
use crate::data::{Frame, Neighbours, SurfelIrradiance, SurfelPose, SurfelSettings};
use crate::shared::estimator::MOST_SAMPLES;
use crate::shared::grid::GridLayout;
use crate::shared::hash::{hash2, unit};
use crate::shared::sharing::Said;
use crate::stages::integrate::{Integrated, Rays, integrate_each};
use bytemuck::bytes_of;
use glam::{UVec2, Vec2, Vec3, Vec4};
use std::ops::Range;

const COUNT: u32 = 4000;
const NUMBER: u32 = 1000;

fn random(i: u32, k: u32) -> f32 {
    unit(hash2(i, k))
}

fn vector(i: u32, k: u32) -> Vec3 {
    Vec3::new(random(i, k), random(i, k + 1), random(i, k + 2))
}

/// One of `choices`, at random.
fn one_of<T: Copy>(choices: &[T], i: u32, k: u32) -> T {
    choices[hash2(i, k) as usize % choices.len()]
}

/// Every fifth slot is free; the others are everywhere in the grid.
fn pose(i: u32) -> SurfelPose {
    SurfelPose {
        position: (vector(i, 0) - 0.5) * one_of(&[1.0, 10.0], i, 3),
        radius: if i % 5 == 2 { 0.0 } else { 0.1 },
        ..SurfelPose::default()
    }
}

/// None, few and many rays, at all ages: some that have forgotten, some that are quiet, some about to begin their sequence again.
fn state(i: u32) -> SurfelIrradiance {
    let samples = one_of(&[0, 1, 63, 64, 200, 5000, MOST_SAMPLES], i, 10);
    let level = one_of(&[0.0, 1e-6, 1.0, 300.0], i, 11);
    SurfelIrradiance {
        mean: vector(i, 12) * level,
        samples,
        short_mean: vector(i, 15) * level,
        since: NUMBER - one_of(&[0, 1, 15, 16, 31, 32, 127, 128, 900], i, 18),
        variance: random(i, 19) * level * level * one_of(&[1e-3, 1.0, 100.0], i, 20),
        short_noise: random(i, 21) * level * level,
        drawn: samples.max(one_of(&[0, MOST_SAMPLES - 2, 7000], i, 22)),
        pad: 0,
    }
}

/// Some were told nothing.
fn told(i: u32) -> Neighbours {
    let said = Said {
        mean: vector(i, 30) * 2.0,
        trust: one_of(&[0.0, 0.004, random(i, 33), 1.0], i, 34),
        rays: one_of(&[0.0, 0.5, 40.0, 1e6], i, 35),
        ray_variance: random(i, 36),
    };
    said.pack()
}

fn bits((i, new): &(usize, Integrated)) -> (usize, Vec<u8>, Vec<u8>, Vec<u8>, bool) {
    let state = new.irradiance.iter().flat_map(bytes_of).copied().collect();
    let [light, clamped] = [bytes_of(&new.light), bytes_of(&new.clamped)].map(<[u8]>::to_vec);
    (*i, state, light, clamped, new.asks)
}

#[test]
fn wide_integration_is_the_scalar_one() {
    if Avx2::detect().is_none() {
        eprintln!("not run: this processor has no AVX2");
        return;
    }
    let ids = || 0..COUNT;
    let poses: Vec<_> = ids().map(pose).collect();
    let rays_of = |i: u32| one_of(&[0, 1, 2, 4, 5, 130], i, 40);
    let mut first = 0;
    let spans: Vec<_> = ids()
        .map(|i| {
            let span = UVec2::new(first, rays_of(i));
            first += span.y;
            span
        })
        .collect();
    let radiance: Vec<_> = (0..first)
        .map(|ray| {
            let bright = one_of(&[0.0, 1e-9, 1.0, 50.0], ray, 41);
            (vector(ray, 42) * bright).extend(0.0)
        })
        .collect::<Vec<Vec4>>();
    let layout = GridLayout::new(8, 128.0);
    let grid = layout.at(Vec3::ZERO, 1.0);
    let forget: Vec<_> = (0..layout.cells())
        .map(|cell| {
            let share = one_of(&[0.0, 0.0, random(cell, 50), 1.0], cell, 51);
            Vec2::new(share, random(cell, 52))
        })
        .collect();
    let known = |i: usize| (state(i as u32), told(i as u32));
    let (mut learned, mut asking) = (0, 0);
    for number in [NUMBER, NUMBER + 5] {
        let frame = Frame {
            number,
            ..Frame::default()
        };
        let settings = SurfelSettings {
            faintest: 1e-8,
            ..SurfelSettings::default()
        };
        let rays = Rays {
            frame: &frame,
            grid: &grid,
            settings: &settings,
            poses: &poses,
            spans: &spans,
            radiance: &radiance,
            forget: &forget,
        };
        let all = COUNT as usize;
        let ranges: [Range<usize>; 5] = [0..all, 7..7, 64..128, 3..4, all - 11..all];
        for range in ranges {
            let (mut each, mut wide) = (vec![], vec![]);
            integrate_each(&rays, range.clone(), known, |i, new| each.push((i, new)));
            integrate(&rays, range.clone(), known, |i, new| wide.push((i, new)));
            assert_eq!(each.len(), wide.len());
            for (each, wide) in each.iter().zip(&wide) {
                assert_eq!(bits(each), bits(wide), "{each:?}, wide {wide:?}");
            }
            learned += each
                .iter()
                .filter(|(_, new)| new.irradiance.is_some())
                .count();
            asking += each.iter().filter(|(_, new)| !new.asks).count();
        }
    }
    assert!(
        learned > 3000 && asking > 600,
        "{learned} learned, {asking} do not ask"
    );
}
