//! Weights of the surfels around several points, as pairs of point and surfel.
//!
//! Of the surfels in a point's list few reach it, and of those few have weight. The pairs of all points that have come so
//! far stand in line, so that each step has eight of them at a time, needs no branches, and finds in the cache what it was
//! asked for a step before.
#![allow(unsafe_code)]
use std::arch::x86_64::*;

use super::super::lanes::stored;
use super::super::prefetch;
use super::batch::Batch;
use super::bounds::Point;
use super::eight;
use super::poses::Poses;
use crate::shared::lists::Surfels;

/// Pairs in a line before they go on.
const FULL: usize = 256;

/// Room in a line: the last ones to come may be eight, in eight words more.
const ROOM: usize = FULL + 16;

/// Pairs of surfel and point, in the order of the points and, for each, of its list, and the weight of each.
struct Line {
    surfels: [u32; ROOM],
    points: [u32; ROOM],
    weights: [f32; ROOM],
    count: usize,
}

/// For each mask of eight lanes, those that are set, in order, a byte each.
static SET: [u64; 256] = {
    let mut all = [0; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut lane, mut count) = (0, 0);
        while lane < 8 {
            if mask & (1 << lane) != 0 {
                all[mask] |= lane << (8 * count);
                count += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    all
};

/// The eight elements from `start` on.
#[inline(always)]
fn from<T>(line: &[T; ROOM], start: usize) -> &[T; 8] {
    match line[start..].first_chunk() {
        Some(eight) => eight,
        None => unreachable!("eight elements of {ROOM} from {start} on"),
    }
}

impl Line {
    #[inline(always)]
    fn new() -> Self {
        Self {
            surfels: [0; ROOM],
            points: [0; ROOM],
            weights: [0.0; ROOM],
            count: 0,
        }
    }

    /// Appends those pairs of eight that a mask names.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
    fn append(&mut self, mask: u32, surfels: __m256i, points: __m256i, weights: __m256) {
        let set = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(SET[mask as usize & 0xff] as i64));
        let room = self.count..self.count + 8;
        let to = (
            &mut self.surfels[room.clone()],
            &mut self.points[room.clone()],
            &mut self.weights[room],
        );
        // SAFETY: the stores write the eight words of each slice and need no alignment.
        unsafe {
            let surfels = _mm256_permutevar8x32_epi32(surfels, set);
            _mm256_storeu_si256(to.0.as_mut_ptr().cast(), surfels);
            let points = _mm256_permutevar8x32_epi32(points, set);
            _mm256_storeu_si256(to.1.as_mut_ptr().cast(), points);
            let weights = _mm256_permutevar8x32_ps(weights, set);
            _mm256_storeu_ps(to.2.as_mut_ptr(), weights);
        }
        self.count += (mask & 0xff).count_ones() as usize;
    }
}

/// Calls `each` with point, surfel and weight of all pairs that have any before the depth functions, in order. `soon`
/// hears of each such surfel a little before.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
pub fn for_pairs(
    batch: &Batch<'_>,
    s: &Surfels<'_>,
    soon: impl Fn(usize),
    mut each: impl FnMut(usize, usize, f32),
) {
    let mut near = Line::new();
    let mut weighty = Line::new();
    for (at, list) in (0..).zip(&batch.lists) {
        let here = _mm256_set1_epi32(at);
        // SAFETY: this function is compiled for AVX2.
        let point = unsafe { Point::new(list.place, 1) };
        for start in (0..list.ids.len()).step_by(8) {
            let (bounds, there) = eight(&list.bounds[start..]);
            // SAFETY: as above.
            let mask = unsafe { point.may_reach(bounds) } & there;
            let (ids, _) = eight(&list.ids[start..]);
            near.append(mask, ids, here, _mm256_setzero_ps());
            if near.count >= FULL {
                weigh(&mut near, &mut weighty, batch, s, &soon);
                finish(&mut weighty, batch, s, &mut each);
            }
        }
    }
    weigh(&mut near, &mut weighty, batch, s, &soon);
    finish(&mut weighty, batch, s, &mut each);
}

/// Weights before the depth functions: moves pairs with any from one line to the other, which is empty.
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
fn weigh(
    near: &mut Line,
    weighty: &mut Line,
    batch: &Batch<'_>,
    s: &Surfels<'_>,
    soon: &impl Fn(usize),
) {
    for &id in &near.surfels[..near.count] {
        prefetch(s.poses, id as usize);
    }
    for start in (0..near.count).step_by(8) {
        let (surfels, points) = (from(&near.surfels, start), from(&near.points, start));
        // SAFETY: this function is compiled for AVX2; the loads read eight words each and need no alignment.
        unsafe {
            let poses = Poses::load(s.poses, surfels);
            let places = Poses::load(&batch.points, points);
            let falloff = poses.falloff(&poses.to(&places.position));
            let weight = _mm256_mul_ps(falloff, poses.alignment(&places.normal));
            let some = _mm256_cmp_ps::<_CMP_GT_OQ>(weight, _mm256_setzero_ps());
            // What stands behind the last pair was one before, or is surfel 0.
            let there = (1 << (near.count - start).min(8)) - 1;
            weighty.append(
                _mm256_movemask_ps(some) as u32 & there,
                _mm256_loadu_si256(surfels.as_ptr().cast()),
                _mm256_loadu_si256(points.as_ptr().cast()),
                weight,
            );
        }
    }
    near.count = 0;
    for &id in &weighty.surfels[..weighty.count] {
        prefetch(s.depths, id as usize);
        soon(id as usize);
    }
}

/// Weights with the depth functions, for `each` to take; empties the line.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
fn finish(
    weighty: &mut Line,
    batch: &Batch<'_>,
    s: &Surfels<'_>,
    each: &mut impl FnMut(usize, usize, f32),
) {
    for start in (0..weighty.count).step_by(8) {
        let (surfels, points) = (from(&weighty.surfels, start), from(&weighty.points, start));
        let mut weights = *from(&weighty.weights, start);
        if !s.depths.is_empty() {
            // SAFETY: this function is compiled for AVX2; the load reads eight floats and needs no alignment.
            weights = unsafe {
                let poses = Poses::load(s.poses, surfels);
                let places = Poses::load(&batch.points, points);
                let share = poses.visibility(s.depths, surfels, &places.position);
                stored(_mm256_mul_ps(_mm256_loadu_ps(weights.as_ptr()), share))
            };
        }
        for lane in 0..(weighty.count - start).min(8) {
            each(points[lane] as usize, surfels[lane] as usize, weights[lane]);
        }
    }
    weighty.count = 0;
}
