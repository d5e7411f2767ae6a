//! The lookup of surfels around a point, eight surfels at a time: [`crate::shared::lookup`], operation for operation.
//!
//! Most surfels of a cell do not reach a point of it. Those that do, by their distance alone, are gathered up in the order
//! of the cell's list until there are eight; then come their weights and depth functions, and the sums, one after the
//! other, in that order.
#![allow(unsafe_code)]
mod batch;
mod bounds;
mod cells;
mod pairs;
pub mod poses;

use std::arch::x86_64::*;

use super::lanes::{Lanes3, all, stored};
use super::{Avx2, prefetch};
use crate::data::{Gathered, SurfelLight, SurfelPose};
use crate::shared::lookup::{self, AT_A_TIME, List, Place, Points, Surfels};
use batch::Batch;
use bounds::Point;
use glam::Vec3;
use pairs::for_pairs;
use poses::Poses;

/// The lookup with the best instructions of this processor. Make one per workgroup.
#[derive(Clone, Copy, Debug)]
pub struct Lookup(Option<Avx2>);

impl Default for Lookup {
    fn default() -> Self {
        Self::new()
    }
}

impl Lookup {
    /// With AVX2 where the processor has it.
    #[inline]
    pub fn new() -> Self {
        Lookup(Avx2::detect())
    }

    /// Same as [`lookup::coverage`].
    #[inline]
    pub fn coverage(self, place: &Place<'_>, s: &Surfels<'_>, seen: impl FnMut(usize)) -> f32 {
        match self.0 {
            // SAFETY: there is a proof that the processor has the features.
            Some(Avx2 { .. }) => unsafe { coverage(place, s, seen) },
            None => lookup::coverage(place, s, seen),
        }
    }

    /// Same as [`lookup::neighbours`].
    #[inline]
    pub fn neighbours(
        self,
        own: usize,
        list: List<'_>,
        reach: u32,
        s: &Surfels<'_>,
        wanted: impl Fn(usize) -> bool,
        each: impl FnMut(usize, f32),
    ) {
        match self.0 {
            // SAFETY: there is a proof that the processor has the features.
            Some(Avx2 { .. }) => unsafe { neighbours(own, list, reach, s, wanted, each) },
            None => lookup::neighbours(own, list, reach, s, wanted, each),
        }
    }

    /// Same as [`lookup::coverages`].
    #[inline]
    pub fn coverages(
        self,
        points: &Points<'_>,
        s: &Surfels<'_>,
        seen: impl FnMut(usize),
    ) -> [f32; AT_A_TIME] {
        match self.0 {
            // SAFETY: there is a proof that the processor has the features.
            Some(Avx2 { .. }) => unsafe { coverages(points, s, seen) },
            None => lookup::coverages(points, s, seen),
        }
    }

    /// Same as [`lookup::gathers`].
    #[inline]
    pub fn gathers(
        self,
        points: &Points<'_>,
        enough: f32,
        averaged: impl Fn(usize) -> bool,
        s: &Surfels<'_>,
        light: &[SurfelLight],
    ) -> [Gathered; AT_A_TIME] {
        match self.0 {
            // SAFETY: there is a proof that the processor has the features.
            Some(Avx2 { .. }) => unsafe { gathers(points, enough, averaged, s, light) },
            None => lookup::gathers(points, enough, averaged, s, light),
        }
    }
}

/// The first eight entries, and a mask of those that are there; zero stands for the others.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
fn eight(entries: &[u32]) -> (__m256i, u32) {
    // SAFETY: the loads read what the slice has of eight words, and need no alignment.
    unsafe {
        if entries.len() >= 8 {
            return (_mm256_loadu_si256(entries.as_ptr().cast()), 0xff);
        }
        let lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
        let there = _mm256_cmpgt_epi32(_mm256_set1_epi32(entries.len() as i32), lane);
        let loaded = _mm256_maskload_epi32(entries.as_ptr().cast(), there);
        (loaded, (1 << entries.len()) - 1)
    }
}

/// Calls `each` with the lanes of a mask, in order.
#[inline(always)]
fn lanes(mut mask: u32, mut each: impl FnMut(usize)) {
    while mask != 0 {
        each(mask.trailing_zeros() as usize & 7);
        mask &= mask - 1;
    }
}

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
    // SAFETY: the caller is compiled for AVX2.
    let point = unsafe { Point::new(list.place, reach) };
    for (ids, bounds) in list.ids.chunks(8).zip(list.bounds.chunks(8)) {
        // SAFETY: the caller is compiled for AVX2.
        let mask = unsafe {
            let (bounds, there) = eight(bounds);
            point.may_reach(bounds) & there
        };
        lanes(mask, |lane| {
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

/// What is left of weights after the depth functions, and the mask of those that were above zero before.
///
/// # Safety
/// As [`for_near`].
#[inline(always)]
unsafe fn weighed(
    s: &Surfels<'_>,
    ids: &[u32; 8],
    count: usize,
    poses: &Poses,
    weight: __m256,
    point: &Lanes3,
) -> (__m256, u32) {
    // SAFETY: the caller is compiled for AVX2.
    unsafe {
        let some = _mm256_cmp_ps::<_CMP_GT_OQ>(weight, _mm256_setzero_ps());
        let mask = _mm256_movemask_ps(some) as u32 & ((1 << count) - 1);
        if mask == 0 || s.depths.is_empty() {
            return (weight, mask);
        }
        let share = poses.visibility(s.depths, ids, point);
        (_mm256_mul_ps(weight, share), mask)
    }
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
        let (weight, mask) = weighed(s, ids, count, &poses, weight, point);
        (stored(weight), mask)
    }
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
fn coverage(place: &Place<'_>, s: &Surfels<'_>, mut seen: impl FnMut(usize)) -> f32 {
    let (point, normal) = (all(place.position), all(place.normal));
    let mut total = 0.0;
    let soon = |id| {
        prefetch(s.poses, id);
        prefetch(s.depths, id);
    };
    let eight_near = |ids: &[u32; 8], count| {
        // SAFETY: this function is compiled for AVX2.
        let (weight, mask) = unsafe { weights_at(s, ids, count, &point, &normal) };
        lanes(mask, |lane| {
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

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
fn neighbours(
    own: usize,
    list: List<'_>,
    reach: u32,
    s: &Surfels<'_>,
    wanted: impl Fn(usize) -> bool,
    mut each: impl FnMut(usize, f32),
) {
    let own_pose = &s.poses[own];
    let (point, normal) = (all(own_pose.position), all(own_pose.normal));
    let soon = |id| {
        prefetch(s.poses, id);
        prefetch(s.depths, id);
    };
    let eight_near = |ids: &[u32; 8], count| {
        // SAFETY: this function is compiled for AVX2.
        unsafe {
            let poses = Poses::load(s.poses, ids);
            let falloff = poses.reaching(reach as f32).falloff(&poses.to(&point));
            let weight = _mm256_mul_ps(falloff, poses.alignment(&normal));
            let (mut weight, mask) = weighed(s, ids, count, &poses, weight, &point);
            if mask != 0 && !s.depths.is_empty() {
                let share = Poses::repeated(own_pose).visibility(
                    s.depths,
                    &[own as u32; 8],
                    &poses.position,
                );
                weight = _mm256_mul_ps(weight, share);
            }
            let weight = stored(weight);
            lanes(mask, |lane| {
                let id = ids[lane] as usize;
                if wanted(id) {
                    each(id, weight[lane]);
                }
            });
        }
        true
    };
    // SAFETY: this function is compiled for AVX2.
    unsafe { for_near(list, reach, soon, eight_near) };
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
fn coverages(
    points: &Points<'_>,
    s: &Surfels<'_>,
    mut seen: impl FnMut(usize),
) -> [f32; AT_A_TIME] {
    let mut totals = [0.0; AT_A_TIME];
    let each = |at: usize, id, weight| {
        totals[at & (AT_A_TIME - 1)] += weight;
        if weight > 0.0 {
            seen(id);
        }
    };
    for_pairs(&Batch::new(points, s), s, |_| {}, each);
    totals
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
fn gathers(
    points: &Points<'_>,
    enough: f32,
    averaged: impl Fn(usize) -> bool,
    s: &Surfels<'_>,
    light: &[SurfelLight],
) -> [Gathered; AT_A_TIME] {
    let batch = Batch::new(points, s);
    let mut gathered = [Gathered::default(); AT_A_TIME];
    let each = |at: usize, id: usize, weight: f32| {
        let (light, g) = (&light[id], &mut gathered[at & (AT_A_TIME - 1)]);
        if light.trust != 0.0 && weight >= lookup::LEAST_WEIGHT && g.weight < enough {
            g.irradiance += light.irradiance * weight;
            g.weight += weight;
            g.confidence += weight * light.trust;
        }
    };
    for_pairs(&batch, s, |id| prefetch(light, id), each);
    let open: [bool; AT_A_TIME] = std::array::from_fn(|i| {
        let open = points[i].is_some() && gathered[i].weight < 1.0 && averaged(i);
        if open {
            for &id in batch.lists[i].ids.iter().take(lookup::AVERAGE_OF) {
                prefetch(s.poses, id as usize);
                prefetch(s.depths, id as usize);
                prefetch(light, id as usize);
            }
        }
        open
    });
    for (i, g) in gathered.iter_mut().enumerate() {
        if g.weight > 0.0 {
            g.confidence /= g.weight;
        }
        if g.weight >= 1.0 {
            g.irradiance /= g.weight;
            g.weight = 1.0;
        }
        if open[i] {
            g.average = average(&batch.points[i], batch.lists[i].ids, s, light);
        }
    }
    gathered
}

/// The average of a cell at a point, as [`lookup::gather`] finds it.
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
fn average(at: &SurfelPose, ids: &[u32], s: &Surfels<'_>, light: &[SurfelLight]) -> Vec3 {
    const _: () = assert!(lookup::AVERAGE_OF == 8);
    let count = ids.len().min(8);
    let Some(&first) = ids.first() else {
        return Vec3::ZERO;
    };
    let (point, normal) = (all(at.position), all(at.normal));
    let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
    let ids: [u32; 8] = std::array::from_fn(|i| ids.get(i).copied().unwrap_or(first));
    // SAFETY: this function is compiled for AVX2.
    let (weight, mask) = unsafe {
        let poses = Poses::load(s.poses, &ids);
        let weight = poses.alignment(&normal);
        let (weight, mask) = weighed(s, &ids, count, &poses, weight, &point);
        (stored(weight), mask)
    };
    lanes(mask, |lane| {
        let (light, weight) = (&light[ids[lane] as usize], weight[lane]);
        if light.trust != 0.0 && weight >= lookup::LEAST_WEIGHT {
            sum += light.irradiance * weight;
            weights += weight;
        }
    });
    sum / weights.max(lookup::AVERAGE_LEAST)
}
