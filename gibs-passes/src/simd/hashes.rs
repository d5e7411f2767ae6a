//! Eight random numbers: [`crate::shared::hash`], operation for operation.
use std::arch::x86_64::*;

/// [`crate::shared::hash::hash3`].
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn hash3(a: __m256i, b: __m256i, c: __m256i) -> __m256i {
    hash2(a, hash2(b, c))
}

/// [`crate::shared::hash::pcg`].
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn pcg(value: __m256i) -> __m256i {
    let state = _mm256_add_epi32(
        _mm256_mullo_epi32(value, _mm256_set1_epi32(747_796_405)),
        _mm256_set1_epi32(2_891_336_453_u32 as i32),
    );
    let by = _mm256_add_epi32(_mm256_srli_epi32::<28>(state), _mm256_set1_epi32(4));
    let word = _mm256_mullo_epi32(
        _mm256_xor_si256(_mm256_srlv_epi32(state, by), state),
        _mm256_set1_epi32(277_803_737),
    );
    _mm256_xor_si256(_mm256_srli_epi32::<22>(word), word)
}

/// [`crate::shared::hash::hash2`].
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn hash2(a: __m256i, b: __m256i) -> __m256i {
    pcg(_mm256_add_epi32(a, pcg(b)))
}

/// [`crate::shared::hash::unit`].
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn unit(bits: __m256i) -> __m256 {
    _mm256_mul_ps(
        _mm256_cvtepi32_ps(_mm256_srli_epi32::<8>(bits)),
        _mm256_set1_ps(1.0 / 16_777_216.0),
    )
}
