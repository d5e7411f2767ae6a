//! Weights of the surfels around several points, as pairs of point and surfel.
//!
//! Of the surfels in a point's list few reach it, and of those few have weight. The pairs of all points that have come so
//! far stand in line, so that each step has eight of them at a time, needs no branches, and finds in the cache what it was
//! asked for a step before.
#![allow(unsafe_code)]
use std::arch::x86_64::*;
use std::mem::MaybeUninit;

use super::super::lanes::{loaded, stored};
use super::super::prefetch;
use super::super::x86::Avx512;
use super::batch::Batch;
use super::bounds::{may_reach, may_reach_times};
use super::candidates::{Candidates, set_lanes};
use super::poses::Poses;
use super::{above_zero, eight, wider};
use crate::shared::lists::{List, Surfels};
use bytemuck::Pod;

/// Pairs in a line before they go on.
pub const FULL: usize = 256;

/// Room in a line: the last ones to come may be sixteen, in sixteen words more.
pub const ROOM: usize = FULL + 32;

/// Pairs of surfel and point, in the order of the points and, for each, of its list, and the weight of each. What has not
/// been written is not read: clearing the whole line for every sixteen points would take longer than what is done with it.
pub struct Line {
    surfels: [MaybeUninit<u32>; ROOM],
    points: [MaybeUninit<u32>; ROOM],
    weights: [MaybeUninit<f32>; ROOM],
    count: usize,
    /// Places in the line of pairs whose weights still lack the depth functions.
    hiding: [MaybeUninit<u32>; ROOM],
    hiding_count: usize,
}

/// Eight pairs of a line.
pub struct Eight {
    /// Surfel of each.
    pub surfels: [u32; 8],
    /// Point of each.
    pub points: [u32; 8],
    /// Weight of each.
    pub weights: [f32; 8],
    /// How many of them there are; the others are of surfel and point 0.
    pub count: usize,
}

impl Line {
    #[inline(always)]
    pub fn new() -> Self {
        Self {
            surfels: [const { MaybeUninit::uninit() }; ROOM],
            points: [const { MaybeUninit::uninit() }; ROOM],
            weights: [const { MaybeUninit::uninit() }; ROOM],
            count: 0,
            hiding: [const { MaybeUninit::uninit() }; ROOM],
            hiding_count: 0,
        }
    }

    /// Calls `each` with all pairs, eight at a time, and empties the line.
    #[inline(always)]
    pub fn take(&mut self, mut each: impl FnMut(Eight)) {
        /// # Safety
        /// The line has eight elements from there on, all of which have been written.
        unsafe fn from<T: Pod>(line: &[MaybeUninit<T>; ROOM], start: usize) -> [T; 8] {
            // SAFETY: as the caller says.
            unsafe { line.as_ptr().add(start).cast::<[T; 8]>().read_unaligned() }
        }
        let end = self.count;
        assert!(end + 8 <= ROOM, "{end} pairs in a line of {ROOM}");
        self.surfels[end..end + 8].fill(MaybeUninit::new(0));
        self.points[end..end + 8].fill(MaybeUninit::new(0));
        self.weights[end..end + 8].fill(MaybeUninit::new(0.0));
        for start in (0..end).step_by(8) {
            // SAFETY: eight elements from there on end within the eight behind the last pair, which were written here; those
            // before were by `append`.
            let (surfels, points, weights) = unsafe {
                (
                    from(&self.surfels, start),
                    from(&self.points, start),
                    from(&self.weights, start),
                )
            };
            each(Eight {
                surfels,
                points,
                weights,
                count: (end - start).min(8),
            });
        }
        self.count = 0;
    }

    /// The surfels.
    #[inline(always)]
    pub fn surfels(&self) -> impl Iterator<Item = usize> {
        // SAFETY: `append` has written what is below the count.
        let written = |surfel: &MaybeUninit<u32>| unsafe { surfel.assume_init() } as usize;
        self.surfels[..self.count].iter().map(written)
    }

    /// Appends those pairs of eight that a mask names.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn append(&mut self, mask: u32, surfels: __m256i, points: __m256i, weights: __m256) {
        let set = set_lanes(mask);
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
            _mm256_storeu_ps(to.2.as_mut_ptr().cast(), weights);
        }
        self.count += (mask & 0xff).count_ones() as usize;
    }

    /// Notes those places from one on, of eight, that a mask names.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn note_hiding(&mut self, mask: u32, first: usize) {
        let set = set_lanes(mask);
        let places = _mm256_add_epi32(set, _mm256_set1_epi32(first as i32));
        let to = &mut self.hiding[self.hiding_count..self.hiding_count + 8];
        // SAFETY: the store writes the eight words of the slice and needs no alignment.
        unsafe { _mm256_storeu_si256(to.as_mut_ptr().cast(), places) };
        self.hiding_count += (mask & 0xff).count_ones() as usize;
    }

    /// Places whose weights still lack the depth functions.
    #[inline(always)]
    fn hiding(&self) -> &[u32] {
        // SAFETY: `note_hiding` has written what is below the count.
        unsafe { self.hiding[..self.hiding_count].assume_init_ref() }
    }

    /// Multiplies the weights that lack them by the depth functions' shares.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn hide(&mut self, batch: &Batch<'_>, s: &Surfels<'_>) {
        for start in (0..self.hiding_count).step_by(8) {
            let of = &self.hiding()[start..self.hiding_count.min(start + 8)];
            let count = of.len();
            let places: [usize; 8] =
                std::array::from_fn(|i| of[if i < count { i } else { 0 }] as usize);
            // SAFETY: the places are those of pairs that `append` has written; this function is compiled for AVX2.
            unsafe {
                let surfels = places.map(|place| self.surfels[place].assume_init());
                let points = places.map(|place| self.points[place].assume_init());
                let weights = places.map(|place| self.weights[place].assume_init());
                let poses = Poses::load(s.poses, &surfels);
                let at = Poses::load(&batch.points, &points);
                let share = poses.visibility(s.depths, &surfels, &at.position);
                let weights = stored(_mm256_mul_ps(loaded(&weights), share));
                for (&place, weight) in places.iter().zip(weights).take(count) {
                    self.weights[place] = MaybeUninit::new(weight);
                }
            }
        }
        self.hiding_count = 0;
    }
}

/// Calls `each` with point, surfel and weight of all pairs that have any before the depth functions, in order. `soon`
/// hears of each such surfel a little before.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn for_pairs(
    batch: &Batch<'_>,
    s: &Surfels<'_>,
    avx512: Option<Avx512>,
    soon: impl Fn(usize),
    mut each: impl FnMut(usize, usize, f32),
) {
    let mut near = Candidates::new();
    let mut weighty = Line::new();
    let mut from = Some((0, 0));
    while let Some(at) = from {
        from = match avx512 {
            // SAFETY: there is a proof that the processor has the features.
            Some(Avx512 { .. }) => unsafe { wider::collect(&mut near, &batch.lists, at) },
            None => collect::<1>(&mut near, &batch.lists, at),
        };
        weigh(&mut near, &mut weighty, batch, s, &soon);
        finish(&mut weighty, batch, s, &mut each);
    }
}

/// Appends the surfels that may reach their points with so many times their radii, from an entry of one of the lists on, until the line
/// is full; then gives the entry after the last one.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn collect<const REACH: u32>(
    near: &mut Candidates,
    lists: &[List<'_>],
    (first, mut start): (usize, usize),
) -> Option<(usize, usize)> {
    let mut line = near.filling();
    for (at, list) in lists.iter().enumerate().skip(first) {
        let here = _mm256_set1_epi32(at as i32);
        let place = _mm256_set1_epi32(list.place as i32);
        debug_assert_eq!(list.bounds.len(), list.ids.len());
        let (bounds, last_bounds) = list.bounds[start..].as_chunks::<8>();
        let (ids, last_ids) = list.ids[start..].as_chunks::<8>();
        for (bounds, ids) in bounds.iter().zip(ids) {
            // SAFETY: the loads read eight words each and need no alignment; this function is compiled for AVX2.
            unsafe {
                let mask = reaching::<REACH>(_mm256_loadu_si256(bounds.as_ptr().cast()), place);
                line.append(mask, _mm256_loadu_si256(ids.as_ptr().cast()), here);
            }
            start += 8;
            if line.is_full() {
                return Some((at, start));
            }
        }
        if !last_ids.is_empty() {
            let (bounds, there) = eight(last_bounds);
            // SAFETY: this function is compiled for AVX2.
            let mask = unsafe { reaching::<REACH>(bounds, place) } & there;
            line.append(mask, eight(last_ids).0, here);
            if line.is_full() {
                return Some((at + 1, 0));
            }
        }
        start = 0;
    }
    None
}

/// [`may_reach`], or with a multiple of the radius.
///
/// # Safety
/// As [`may_reach`].
#[inline(always)]
unsafe fn reaching<const REACH: u32>(bounds: __m256i, place: __m256i) -> u32 {
    // SAFETY: as the caller says.
    unsafe {
        match REACH {
            1 => may_reach(bounds, place),
            reach => may_reach_times(bounds, place, reach),
        }
    }
}

/// Weights before the depth functions: those of the candidates that have any go into a line, which is empty.
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn weigh(
    near: &mut Candidates,
    weighty: &mut Line,
    batch: &Batch<'_>,
    s: &Surfels<'_>,
    soon: &impl Fn(usize),
) {
    for id in near.surfels() {
        prefetch(s.poses, id);
    }
    near.take(
        #[inline(always)]
        |surfels, points, count| {
            // SAFETY: this function is compiled for AVX2; the loads read eight words each and need no alignment.
            unsafe {
                let poses = Poses::load(s.poses, &surfels);
                let places = Poses::load(&batch.points, &points);
                let falloff = poses.falloff(&poses.to(&places.position));
                let weight = _mm256_mul_ps(falloff, poses.alignment(&places.normal));
                let mask = above_zero(weight, count);
                if !s.depths.is_empty() {
                    weighty.note_hiding(_pext_u32(poses.hiding(), mask), weighty.count);
                }
                weighty.append(
                    mask,
                    _mm256_loadu_si256(surfels.as_ptr().cast()),
                    _mm256_loadu_si256(points.as_ptr().cast()),
                    weight,
                );
            }
        },
    );
    for id in weighty.surfels() {
        soon(id);
    }
    for &place in weighty.hiding() {
        // SAFETY: it is the place of a pair that `append` has written.
        let surfel = unsafe { weighty.surfels[place as usize].assume_init() } as usize;
        prefetch(s.depths.texels(), s.depths.first(surfel));
    }
}

/// Weights with the depth functions, for `each` to take; empties the line.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn finish(
    weighty: &mut Line,
    batch: &Batch<'_>,
    s: &Surfels<'_>,
    each: &mut impl FnMut(usize, usize, f32),
) {
    weighty.hide(batch, s);
    weighty.take(
        #[inline(always)]
        |pairs| {
            let pair = pairs.points.iter().zip(&pairs.surfels).zip(pairs.weights);
            for ((&point, &surfel), weight) in pair.take(pairs.count) {
                each(point as usize, surfel as usize, weight);
            }
        },
    );
}
