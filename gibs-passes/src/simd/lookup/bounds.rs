//! Eight bounds at a time: [`crate::shared::bounds::may_reach`].
#![allow(unsafe_code)]
use std::arch::x86_64::*;

use crate::shared::bounds::{FAR, MARGIN, RADIUS_AT};

const RADIUS: i32 = RADIUS_AT as i32;

/// A bit for each surfel that may reach a point, of which all lanes have the place.
///
/// # Safety
/// Inlined into functions for processors with AVX2 only.
#[inline(always)]
pub unsafe fn may_reach(bounds: __m256i, place: __m256i) -> u32 {
    // SAFETY: the caller is compiled for AVX2.
    unsafe {
        let margin = _mm256_set1_epi32((MARGIN << RADIUS_AT) as i32);
        within(_mm256_add_epi8(apart(bounds, place), margin))
    }
}

/// [`may_reach`] with a multiple of the radius.
///
/// # Safety
/// As [`may_reach`].
#[inline(always)]
pub unsafe fn may_reach_times(bounds: __m256i, place: __m256i, reach: u32) -> u32 {
    // SAFETY: the caller is compiled for AVX2.
    unsafe {
        let radius = _mm256_srli_epi32::<RADIUS>(bounds);
        let most = _mm256_add_epi32(
            _mm256_mullo_epi32(radius, _mm256_set1_epi32(reach as i32)),
            _mm256_set1_epi32(MARGIN as i32),
        );
        let most = _mm256_min_epu32(most, _mm256_set1_epi32(FAR as i32));
        let coordinates = _mm256_set1_epi32((1 << RADIUS_AT) - 1);
        let apart = _mm256_and_si256(apart(bounds, place), coordinates);
        within(_mm256_or_si256(apart, _mm256_slli_epi32::<RADIUS>(most)))
    }
}

/// Magnitudes of differences, a byte each, and the radius in the highest.
///
/// # Safety
/// As [`may_reach`].
#[inline(always)]
unsafe fn apart(bounds: __m256i, place: __m256i) -> __m256i {
    // SAFETY: the caller is compiled for AVX2.
    unsafe { _mm256_abs_epi8(_mm256_sub_epi8(bounds, place)) }
}

/// The sum of the squares of three bytes is at most that of the highest one, or that is as good as any.
///
/// # Safety
/// As [`may_reach`].
#[inline(always)]
unsafe fn within(bytes: __m256i) -> u32 {
    // SAFETY: the caller is compiled for AVX2.
    unsafe {
        // 128 becomes 127 as well: the signed bytes of the products have no more.
        let bytes = _mm256_min_epu8(bytes, _mm256_set1_epi8(FAR as i8));
        let always = _mm256_cmpgt_epi32(bytes, _mm256_set1_epi32(((FAR << RADIUS_AT) - 1) as i32));
        let signs = _mm256_set1_epi32(i32::from_le_bytes([1, 1, 1, -1i8 as u8]));
        let pairs = _mm256_maddubs_epi16(bytes, _mm256_sign_epi8(bytes, signs));
        let over = _mm256_madd_epi16(pairs, _mm256_set1_epi16(1));
        let inside = _mm256_cmpgt_epi32(_mm256_set1_epi32(1), over);
        _mm256_movemask_ps(_mm256_castsi256_ps(_mm256_or_si256(inside, always))) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shared::{bounds, hash};
    use crate::simd::Avx2;
    use crate::simd::lanes::loaded_words;

    /// Every byte along each axis, at every radius, against a point at random, and words near each other: eight different ones at a time, so
    /// that none may stand for another.
    #[test]
    fn eight_bounds_are_compared_as_each_is() {
        let Some(avx2) = Avx2::detect() else {
            eprintln!("not run: this processor has no AVX2");
            return;
        };
        let whole = (1u32 << RADIUS_AT) - 1;
        let along = |i: u32| {
            let (axis, byte, radius) = (i >> 16, i & 255, ((i >> 8) & 127).max(1));
            byte << (8 * axis) | radius << RADIUS_AT
        };
        let near = |i: u32| {
            let radius = (hash::hash2(i, 3) & 127).max(1);
            hash::hash2(i / 8, 1).wrapping_add(hash::hash2(i, 2) & 0x003f_3f3f) & whole
                | radius << RADIUS_AT
        };
        let eights = (0..3 * 65_536 / 8).map(|i| (i, false));
        let eights = eights.chain((0..16_384).map(|i| (i, true)));
        let (mut passed, mut mixed) = (0, 0);
        for (eight, is_near) in eights {
            let of = |lane: usize| 8 * eight + lane as u32;
            let words: [u32; 8] = std::array::from_fn(|lane| match is_near {
                true => near(of(lane)),
                false => along(of(lane)),
            });
            let place = match is_near {
                true => hash::hash2(eight, 1) & whole,
                false => hash::hash2(eight, 0) & whole,
            };
            for reach in [1, 2, 3] {
                let found = avx2.run(
                    #[inline(always)]
                    || {
                        // SAFETY: all run where there is AVX2, as the proof says.
                        unsafe {
                            let bounds = loaded_words(&words);
                            let at = _mm256_set1_epi32(place as i32);
                            match reach {
                                1 => [may_reach(bounds, at), may_reach_times(bounds, at, 1)],
                                _ => [may_reach_times(bounds, at, reach); 2],
                            }
                        }
                    },
                );
                let mut mask = 0;
                for (lane, &word) in words.iter().enumerate() {
                    mask |= u32::from(bounds::may_reach(word, place, reach)) << lane;
                }
                assert_eq!(found, [mask; 2], "{words:x?} {place:x} {reach}");
                passed += mask.count_ones();
                mixed += u32::from(mask != 0 && mask != 0xff);
            }
        }
        println!("{passed} passed, {mixed} eights of both kinds");
        assert!(passed > 10_000 && mixed > 10_000);
    }
}
