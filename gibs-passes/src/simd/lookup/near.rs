//! The lookup around one point: of the surfels that may reach it, eight at a time, in the order of its list.
#![allow(unsafe_code)]
use std::arch::x86_64::*;

use super::super::lanes::{Lanes3, all, for_lanes, loaded, loaded_words, stored};
use super::super::prefetch;
use super::bounds::may_reach_times;
use super::pairs::{FULL, Line};
use super::poses::Poses;
use super::{above_zero, eight};
use crate::shared::lists::{List, Surfels};
use crate::shared::lookup::Place;

/// Calls `eight_near` with the surfels of a list that may reach its point with `reach` times their radii, eight at a time
/// and in order, as far as it says that it wants more, and with how many of them count. `found` hears of each a little
/// before.
///
/// # Safety
/// Inlined into functions for processors with AVX2 only.
#[inline(always)]
unsafe fn for_near(
    list: List<'_>,
    reach: u32,
    found: impl Fn(usize),
    mut eight_near: impl FnMut(&[u32; 8], usize) -> bool,
) {
    let mut waiting = [0; 16];
    let mut count = 0;
    for (ids, bounds) in list.ids.chunks(8).zip(list.bounds.chunks(8)) {
        // SAFETY: the caller is compiled for AVX2.
        let mask = unsafe {
            let (bounds, there) = eight(bounds);
            let place = _mm256_set1_epi32(list.place as i32);
            may_reach_times(bounds, place, reach) & there
        };
        for_lanes(mask, |lane| {
            let id = ids.get(lane).copied().unwrap_or(0);
            waiting[count & 15] = id;
            count += 1;
            found(id as usize);
        });
        if count >= 8 {
            let [first, second] = halves(&waiting);
            if !eight_near(&first, 8) {
                return;
            }
            waiting[..8].copy_from_slice(&second);
            count -= 8;
        }
    }
    if count > 0 {
        let [mut first, _] = halves(&waiting);
        let filler = first[0];
        first[count..].fill(filler);
        eight_near(&first, count);
    }
}

#[inline(always)]
fn halves(all: &[u32; 16]) -> [[u32; 8]; 2] {
    let half = |start: usize| std::array::from_fn(|i| all[start + i]);
    [half(0), half(8)]
}

/// Weights of eight surfels at a point, and the mask of those that were above zero before the depth functions.
///
/// # Safety
/// As [`for_near`].
#[inline(always)]
unsafe fn weights_at(
    s: &Surfels<'_>,
    ids: &[u32; 8],
    count: usize,
    point: &Lanes3,
    normal: &Lanes3,
) -> ([f32; 8], u32) {
    // SAFETY: the caller is compiled for AVX2.
    unsafe {
        let poses = Poses::load(s.poses, ids);
        let weight = _mm256_mul_ps(poses.falloff(&poses.to(point)), poses.alignment(normal));
        let mask = above_zero(weight, count);
        if mask & poses.hiding() == 0 || s.depths.is_empty() {
            return (stored(weight), mask);
        }
        let share = poses.visibility(s.depths, ids, point);
        // Of the open ones the mark's highest bit is set, which is what is looked at.
        let share = _mm256_blendv_ps(share, _mm256_set1_ps(1.0), poses.mark);
        (stored(_mm256_mul_ps(weight, share)), mask)
    }
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn coverage(place: &Place<'_>, s: &Surfels<'_>, mut seen: impl FnMut(usize)) -> f32 {
    let (point, normal) = (all(place.position), all(place.normal));
    let mut total = 0.0;
    let soon = |id| {
        prefetch(s.poses, id);
        prefetch(s.depths.texels(), s.depths.first(id));
    };
    let eight_near = |ids: &[u32; 8], count| {
        // SAFETY: this function is compiled for AVX2.
        let (weight, mask) = unsafe { weights_at(s, ids, count, &point, &normal) };
        for_lanes(mask, |lane| {
            total += weight[lane];
            if weight[lane] > 0.0 {
                seen(ids[lane] as usize);
            }
        });
        true
    };
    // SAFETY: this function is compiled for AVX2.
    unsafe { for_near(place.list, 1, soon, eight_near) };
    total
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn neighbours(
    own: usize,
    list: List<'_>,
    reach: u32,
    s: &Surfels<'_>,
    wanted: impl Fn(usize) -> bool,
    mut each: impl FnMut(usize, f32),
) {
    let own_pose = &s.poses[own];
    let (point, normal) = (all(own_pose.position), all(own_pose.normal));
    let mut weighty = Line::new();
    let soon = |id| prefetch(s.poses, id);
    let eight_near = |ids: &[u32; 8], count| {
        // SAFETY: this function is compiled for AVX2.
        unsafe {
            let poses = Poses::load(s.poses, ids);
            let nearness = poses.reaching(reach as f32).nearness(&poses.to(&point));
            let weight = _mm256_mul_ps(nearness, poses.alignment(&normal));
            let mut mask = above_zero(weight, count);
            for_lanes(mask, |lane| {
                let id = ids[lane] as usize;
                match wanted(id) {
                    true => prefetch(s.depths.texels(), s.depths.first(id)),
                    false => mask &= !(1 << lane),
                }
            });
            weighty.append(mask, loaded_words(ids), _mm256_setzero_si256(), weight);
            if weighty.count() >= FULL {
                finish_neighbours(&mut weighty, own, s, &mut each);
            }
        }
        true
    };
    // SAFETY: this function is compiled for AVX2.
    unsafe { for_near(list, reach, soon, eight_near) };
    finish_neighbours(&mut weighty, own, s, &mut each);
}

/// Weights of neighbours with both depth functions, for `each` to take; empties the line.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn finish_neighbours(
    weighty: &mut Line,
    own: usize,
    s: &Surfels<'_>,
    each: &mut impl FnMut(usize, f32),
) {
    let own_pose = &s.poses[own];
    weighty.take(
        #[inline(always)]
        |eight| {
            let mut weights = eight.weights;
            if !s.depths.is_empty() {
                // SAFETY: this function is compiled for AVX2.
                weights = unsafe {
                    let poses = Poses::load(s.poses, &eight.surfels);
                    let point = all(own_pose.position);
                    let share = poses.visibility(s.depths, &eight.surfels, &point);
                    let weight = _mm256_mul_ps(loaded(&weights), share);
                    let own_share = Poses::repeated(own_pose).visibility(
                        s.depths,
                        &[own as u32; 8],
                        &poses.position,
                    );
                    stored(_mm256_mul_ps(weight, own_share))
                };
            }
            for (&id, weight) in eight.surfels.iter().zip(weights).take(eight.count) {
                each(id as usize, weight);
            }
        },
    );
}
