//! The lookup of surfels around a point, eight surfels at a time: [`crate::shared::lookup`], operation for operation.
//!
//! Most surfels of a cell do not reach a point of it. Those that do, by their distance alone, are gathered up in the order
//! of the cell's list until there are eight; then come their weights and depth functions, and the sums, one after the
//! other, in that order.
#![allow(unsafe_code)]
mod poses;

use std::arch::x86_64::*;

use super::lanes::{Lanes3, all, stored};
use super::{Avx2, prefetch};
use crate::data::{Gathered, SurfelLight};
use crate::shared::lookup::{self, Place, Surfels};
use poses::{Poses, near};

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
        list: &[u32],
        reach: f32,
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

    /// Same as [`lookup::gather`].
    #[inline]
    pub fn gather(
        self,
        place: &Place<'_>,
        enough: f32,
        s: &Surfels<'_>,
        light: &[SurfelLight],
    ) -> Gathered {
        match self.0 {
            // SAFETY: there is a proof that the processor has the features.
            Some(Avx2 { .. }) => unsafe { gather(place, enough, s, light) },
            None => lookup::gather(place, enough, s, light),
        }
    }
}

/// Eight entries, the last one repeated where there are fewer, and a mask of those that are there.
#[inline(always)]
fn eight(chunk: &[u32]) -> ([u32; 8], u32) {
    match <[u32; 8]>::try_from(chunk) {
        Ok(ids) => (ids, 0xff),
        Err(_) => {
            let mut ids = [chunk[0]; 8];
            ids[..chunk.len()].copy_from_slice(chunk);
            (ids, (1 << chunk.len()) - 1)
        }
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

/// Calls `eight_near` with the surfels of a list that reach a point, eight at a time and in order, as far as it says that
/// it wants more, and with how many of them count. `found` hears of each a little before.
///
/// # Safety
/// Inlined into functions for processors with AVX2 only.
#[inline(always)]
unsafe fn for_near(
    list: &[u32],
    s: &Surfels<'_>,
    reach: f32,
    point: &Lanes3,
    found: impl Fn(usize),
    mut eight_near: impl FnMut(&[u32; 8], usize) -> bool,
) {
    let mut waiting = [0; 16];
    let mut count = 0;
    for chunk in list.chunks(8) {
        let (ids, there) = eight(chunk);
        // SAFETY: the caller is compiled for AVX2.
        let mask = unsafe { near(s.poses, &ids, reach, point) } & there;
        lanes(mask, |lane| {
            waiting[count & 15] = ids[lane];
            count += 1;
            found(ids[lane] as usize);
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
unsafe fn weights(
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
        let (weight, mask) = weights(s, ids, count, &poses, weight, point);
        (stored(weight), mask)
    }
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
fn coverage(place: &Place<'_>, s: &Surfels<'_>, mut seen: impl FnMut(usize)) -> f32 {
    let (point, normal) = (all(place.position), all(place.normal));
    let mut total = 0.0;
    let soon = |id| prefetch(s.depths, id);
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
    unsafe { for_near(place.list, s, 1.0, &point, soon, eight_near) };
    total
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
fn neighbours(
    own: usize,
    list: &[u32],
    reach: f32,
    s: &Surfels<'_>,
    wanted: impl Fn(usize) -> bool,
    mut each: impl FnMut(usize, f32),
) {
    let own_pose = &s.poses[own];
    let (point, normal) = (all(own_pose.position), all(own_pose.normal));
    let soon = |id| prefetch(s.depths, id);
    let eight_near = |ids: &[u32; 8], count| {
        // SAFETY: this function is compiled for AVX2.
        unsafe {
            let poses = Poses::load(s.poses, ids);
            let falloff = poses.reaching(reach).falloff(&poses.to(&point));
            let weight = _mm256_mul_ps(falloff, poses.alignment(&normal));
            let (mut weight, mask) = weights(s, ids, count, &poses, weight, &point);
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
    unsafe { for_near(list, s, reach, &point, soon, eight_near) };
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
fn gather(place: &Place<'_>, enough: f32, s: &Surfels<'_>, light: &[SurfelLight]) -> Gathered {
    let (point, normal) = (all(place.position), all(place.normal));
    let mut g = Gathered::default();
    let soon = |id| {
        prefetch(s.depths, id);
        prefetch(light, id);
    };
    let eight_near = |ids: &[u32; 8], count| {
        // SAFETY: this function is compiled for AVX2.
        let (weight, mask) = unsafe { weights_at(s, ids, count, &point, &normal) };
        lanes(mask, |lane| {
            let (light, weight) = (&light[ids[lane] as usize], weight[lane]);
            if light.trust != 0.0 && weight >= lookup::LEAST_WEIGHT && g.weight < enough {
                g.irradiance += light.irradiance * weight;
                g.weight += weight;
                g.confidence += weight * light.trust;
            }
        });
        g.weight < enough
    };
    // SAFETY: this function is compiled for AVX2.
    unsafe { for_near(place.list, s, 1.0, &point, soon, eight_near) };
    if g.weight > 0.0 {
        g.confidence /= g.weight;
    }
    if g.weight >= 1.0 {
        g.irradiance /= g.weight;
        g.weight = 1.0;
        return g;
    }
    let mut average_weight = 0.0;
    let most = place.list.len().min(lookup::AVERAGE_OF);
    for chunk in place.list[..most].chunks(8) {
        let (ids, _) = eight(chunk);
        // SAFETY: this function is compiled for AVX2.
        unsafe {
            let poses = Poses::load(s.poses, &ids);
            let weight = poses.alignment(&normal);
            let (weight, mask) = weights(s, &ids, chunk.len(), &poses, weight, &point);
            let weight = stored(weight);
            lanes(mask, |lane| {
                let (light, weight) = (&light[ids[lane] as usize], weight[lane]);
                if light.trust != 0.0 && weight >= lookup::LEAST_WEIGHT {
                    g.average += light.irradiance * weight;
                    average_weight += weight;
                }
            });
        }
    }
    g.average /= average_weight.max(lookup::AVERAGE_LEAST);
    g
}
