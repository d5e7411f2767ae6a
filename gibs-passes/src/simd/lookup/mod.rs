//! The lookup of surfels around points, eight surfels at a time, bounds in lists sixteen where there is AVX-512: [`crate::shared::lookup`], operation for operation. Also the cells
//! that list eight surfels.
#![allow(unsafe_code)]
mod batch;
mod bounds;
mod candidates;
pub mod cells;
mod near;
mod pairs;
pub mod poses;
mod spans;
mod wider;

use std::arch::x86_64::*;

use super::lanes::{all, for_lanes, stored};
use super::x86::Avx512;
use super::{Avx2, prefetch};
use crate::data::{Gathered, SurfelLight, SurfelPose};
use crate::shared::lists::Surfels;
use crate::shared::lookup::{self, AT_A_TIME, Owns, Points};
use batch::Batch;
use glam::{Vec3, Vec4};
use near::neighbours;
#[cfg(test)]
pub use pairs::FULL;
use pairs::for_pairs;
use poses::Poses;
pub use spans::overlapped_by;

/// The lookup with the best instructions of this processor. Make one per workgroup.
#[derive(Clone, Copy, Debug)]
pub struct Lookup(Option<Avx2>, Option<Avx512>);

impl Default for Lookup {
    fn default() -> Self {
        Self::new()
    }
}

impl Lookup {
    /// With AVX2 and AVX-512 where the processor has them.
    #[inline]
    pub fn new() -> Self {
        Lookup(Avx2::detect(), Avx512::detect())
    }

    /// With AVX2 at most.
    #[cfg(test)]
    pub fn eight_wide() -> Self {
        Lookup(Avx2::detect(), None)
    }

    /// Same as [`lookup::crowds`].
    #[inline]
    pub fn crowds(self, owns: &Owns<'_>, s: &Surfels<'_>) -> [f32; AT_A_TIME] {
        match self.0 {
            // SAFETY: there is a proof that the processor has the features.
            Some(Avx2 { .. }) => unsafe { crowds(owns, s, self.1) },
            None => lookup::crowds(owns, s),
        }
    }

    /// Same as [`lookup::neighbours`]; `soon` hears of each neighbour a little before `wanted` and `each`.
    #[inline]
    pub fn neighbours<const REACH: u32>(
        self,
        owns: &Owns<'_>,
        s: &Surfels<'_>,
        soon: impl Fn(usize),
        wanted: impl Fn(usize) -> bool,
        each: impl FnMut(usize, usize, f32),
    ) {
        match self.0 {
            // SAFETY: there is a proof that the processor has the features.
            Some(Avx2 { .. }) => unsafe { neighbours::<REACH>(owns, s, soon, wanted, each) },
            None => lookup::neighbours::<REACH>(owns, s, wanted, each),
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
            Some(Avx2 { .. }) => unsafe { coverages(points, s, self.1, seen) },
            None => lookup::coverages(points, s, seen),
        }
    }

    /// Same as [`lookup::gathers`].
    #[inline]
    pub fn gathers(
        self,
        points: &Points<'_>,
        enough: f32,
        beyond: impl Fn(usize) -> Option<Vec3>,
        s: &Surfels<'_>,
        light: &[SurfelLight],
    ) -> [Gathered; AT_A_TIME] {
        match self.0 {
            // SAFETY: there is a proof that the processor has the features.
            Some(Avx2 { .. }) => unsafe { gathers(points, enough, beyond, s, light, self.1) },
            None => lookup::gathers(points, enough, beyond, s, light),
        }
    }
}

/// The first eight entries, and a mask of those that are there; zero stands for the others.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
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

/// The mask of weights above zero, of so many.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn above_zero(weight: __m256, count: usize) -> u32 {
    let some = _mm256_cmp_ps::<_CMP_GT_OQ>(weight, _mm256_setzero_ps());
    _mm256_movemask_ps(some) as u32 & ((1 << count) - 1)
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn coverages(
    points: &Points<'_>,
    s: &Surfels<'_>,
    avx512: Option<Avx512>,
    mut seen: impl FnMut(usize),
) -> [f32; AT_A_TIME] {
    let mut totals = [0.0; AT_A_TIME];
    let each = |at: usize, id, weight| {
        totals[at & (AT_A_TIME - 1)] += weight;
        if weight > 0.0 {
            seen(id);
        }
    };
    let mut batch = Batch::new();
    batch.find(points, s);
    for_pairs(&batch, s, avx512, |_| {}, each);
    totals
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn crowds(owns: &Owns<'_>, s: &Surfels<'_>, avx512: Option<Avx512>) -> [f32; AT_A_TIME] {
    let (mut totals, mut by_itself) = ([0.0; AT_A_TIME], [0.0; AT_A_TIME]);
    let each = |at: usize, id, weight| {
        let at = at & (AT_A_TIME - 1);
        totals[at] += weight;
        if weight > 0.0 && owns.ids[at] == Some(id) {
            by_itself[at] = lookup::PEAK;
        }
    };
    let mut batch = Batch::new();
    batch.around(owns, s);
    for_pairs(&batch, s, avx512, |_| {}, each);
    std::array::from_fn(|at| totals[at] - by_itself[at])
}

/// What [`lookup::gather`] sums up at a point.
#[derive(Clone, Copy, Default)]
struct Sums {
    /// Irradiance and trust, by dense weights.
    light: Vec4,
    weight: f32,
    /// The dense weights.
    total: f32,
    /// Radius of the first surfel.
    first: f32,
}

impl Sums {
    /// Adds a surfel that counts, and zeros for another: which ones do cannot be foreseen, and no branch depends on it.
    #[inline(always)]
    fn add(&mut self, light: &SurfelLight, radius: f32, weight: f32, enough: f32) {
        let counts =
            (light.trust != 0.0) & (weight >= lookup::LEAST_WEIGHT) & (self.weight < enough);
        let mask = u32::from(counts).wrapping_neg();
        let masked = |x: f32| f32::from_bits(x.to_bits() & mask);
        // Until one counts, each is the first.
        self.first = if self.total == 0.0 {
            radius
        } else {
            self.first
        };
        let shrinks = self.first / radius;
        let dense = masked(weight * (shrinks * shrinks));
        let [r, g, b] = light.irradiance.to_array();
        self.light += Vec4::new(masked(r), masked(g), masked(b), masked(light.trust)) * dense;
        self.weight += masked(weight);
        self.total += dense;
    }
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn gathers(
    points: &Points<'_>,
    enough: f32,
    beyond: impl Fn(usize) -> Option<Vec3>,
    s: &Surfels<'_>,
    light: &[SurfelLight],
    avx512: Option<Avx512>,
) -> [Gathered; AT_A_TIME] {
    let mut batch = Batch::new();
    batch.find(points, s);
    let mut sums = [Sums::default(); AT_A_TIME];
    let each = |at: usize, id: usize, weight: f32| {
        sums[at & (AT_A_TIME - 1)].add(&light[id], s.poses[id].radius, weight, enough);
    };
    for_pairs(&batch, s, avx512, |id| prefetch(light, id), each);
    let mut gathered = sums.map(|sums| Gathered {
        irradiance: sums.light.truncate(),
        weight: sums.weight,
        confidence: sums.light.w,
        ..Gathered::default()
    });
    let open: [Option<Vec3>; AT_A_TIME] = std::array::from_fn(|i| {
        let is_open = points[i].is_some() && gathered[i].weight < 1.0;
        let open = is_open.then(|| beyond(i)).flatten();
        if open.is_some() {
            for &id in batch.lists[i].ids.iter().take(lookup::AVERAGE_OF) {
                prefetch(s.poses, id as usize);
                prefetch(s.depths.texels(), s.depths.first(id as usize));
                prefetch(light, id as usize);
            }
        }
        open
    });
    for (i, g) in gathered.iter_mut().enumerate() {
        if g.weight > 0.0 {
            g.weight = g.weight.min(1.0);
            g.irradiance *= g.weight / sums[i].total;
            g.confidence /= sums[i].total;
        }
        if let Some(beyond) = open[i] {
            g.average = average(&batch.points[i], batch.lists[i].ids, beyond, s, light);
        }
    }
    gathered
}

/// The average of a cell at a point, as [`lookup::gather`] finds it.
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn average(
    at: &SurfelPose,
    ids: &[u32],
    beyond: Vec3,
    s: &Surfels<'_>,
    light: &[SurfelLight],
) -> Vec3 {
    const _: () = assert!(lookup::AVERAGE_OF == 8);
    let count = ids.len().min(8);
    let Some(&first) = ids.first() else {
        return lookup::average(Vec3::ZERO, 0.0, beyond);
    };
    let (point, normal) = (all(at.position), all(at.normal));
    let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
    let ids: [u32; 8] = std::array::from_fn(|i| ids.get(i).copied().unwrap_or(first));
    // SAFETY: this function is compiled for AVX2.
    let (weight, mask) = unsafe {
        let poses = Poses::load(s.poses, &ids);
        let weight = poses.leaning(&normal);
        let mask = above_zero(weight, count);
        if mask == 0 || s.depths.is_empty() {
            (stored(weight), mask)
        } else {
            let share = poses.openness(s.depths, &ids, &point);
            (stored(_mm256_mul_ps(weight, share)), mask)
        }
    };
    for_lanes(mask, |lane| {
        let (light, weight) = (&light[ids[lane] as usize], weight[lane]);
        if light.trust != 0.0 && weight >= lookup::LEAST_WEIGHT {
            sum += light.irradiance * weight;
            weights += weight;
        }
    });
    lookup::average(sum, weights, beyond)
}
