//! Eight bounds at a time: [`crate::shared::bounds::may_reach`].
#![allow(unsafe_code)]
use std::arch::x86_64::*;

use crate::shared::bounds::{ALWAYS, BITS, MARGIN, RADIUS_AT};

/// Where bounds are compared with: a point, and how many times their radii surfels reach.
pub struct Point {
    /// Coordinates in the highest bits.
    at: [__m256i; 3],
    /// Steps for each pair of steps of a radius.
    reach: __m256i,
}

/// Bits above a coordinate, where it is shifted to.
const ABOVE: i32 = 32 - BITS as i32;

impl Point {
    /// # Safety
    /// Inlined into functions for processors with AVX2 only.
    #[inline(always)]
    pub unsafe fn new(place: u32, reach: u32) -> Self {
        // SAFETY: the caller is compiled for AVX2.
        unsafe {
            let highest = |i: u32| _mm256_set1_epi32(((place >> (i * BITS)) << ABOVE) as i32);
            Self {
                at: [highest(0), highest(1), highest(2)],
                reach: _mm256_set1_epi32(2 * reach as i32),
            }
        }
    }

    /// A bit for each surfel that may reach the point.
    ///
    /// # Safety
    /// As [`Point::new`].
    #[inline(always)]
    pub unsafe fn may_reach(&self, bounds: __m256i) -> u32 {
        // SAFETY: the caller is compiled for AVX2.
        unsafe {
            // What lies below a coordinate does not change it: the shift to the right rounds down.
            let x = _mm256_sub_epi32(_mm256_slli_epi32::<ABOVE>(bounds), self.at[0]);
            let y = _mm256_slli_epi32::<{ ABOVE - BITS as i32 }>(bounds);
            let y = _mm256_sub_epi32(y, self.at[1]);
            let z = _mm256_slli_epi32::<{ ABOVE - 2 * BITS as i32 }>(bounds);
            let z = _mm256_sub_epi32(z, self.at[2]);
            let squared = |d| {
                let d = _mm256_srai_epi32::<ABOVE>(d);
                _mm256_mullo_epi32(d, d)
            };
            let distance = _mm256_add_epi32(_mm256_add_epi32(squared(x), squared(y)), squared(z));
            let pairs = _mm256_srli_epi32::<{ RADIUS_AT as i32 }>(bounds);
            let most = _mm256_add_epi32(
                _mm256_mullo_epi32(pairs, self.reach),
                _mm256_set1_epi32(MARGIN as i32),
            );
            let beyond = _mm256_cmpgt_epi32(distance, _mm256_mullo_epi32(most, most));
            let always = _mm256_cmpeq_epi32(pairs, _mm256_set1_epi32(ALWAYS as i32));
            let refused = _mm256_andnot_si256(always, beyond);
            !_mm256_movemask_ps(_mm256_castsi256_ps(refused)) as u32 & 0xff
        }
    }
}
