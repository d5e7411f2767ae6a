//! Eight unit vectors: [`crate::shared::octahedral`] and the frames of [`crate::shared::sampling`], operation for operation.
use std::arch::x86_64::*;

use super::lanes::{Lanes3, dot, magnitude, negated, positive, scaled};

/// `Vec3::normalize`.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
pub fn normalized(v: &Lanes3) -> Lanes3 {
    let length = _mm256_sqrt_ps(dot(v, v));
    scaled(v, _mm256_div_ps(_mm256_set1_ps(1.0), length))
}

/// What an octahedral map makes of the lower half.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
fn folded(p: &[__m256; 2], z: __m256) -> [__m256; 2] {
    let one = _mm256_set1_ps(1.0);
    let over = |along, across| {
        let positive = _mm256_cmp_ps::<_CMP_GE_OQ>(along, _mm256_setzero_ps());
        let sign = _mm256_blendv_ps(_mm256_set1_ps(-1.0), one, positive);
        _mm256_mul_ps(_mm256_sub_ps(one, magnitude(across)), sign)
    };
    let upper = _mm256_cmp_ps::<_CMP_GE_OQ>(z, _mm256_setzero_ps());
    [
        _mm256_blendv_ps(over(p[0], p[1]), p[0], upper),
        _mm256_blendv_ps(over(p[1], p[0]), p[1], upper),
    ]
}

/// [`crate::shared::octahedral::pack`].
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
pub fn pack(n: &Lanes3) -> __m256i {
    let total = _mm256_add_ps(
        _mm256_add_ps(magnitude(n[0]), magnitude(n[1])),
        magnitude(n[2]),
    );
    let [x, y] = folded(
        &[_mm256_div_ps(n[0], total), _mm256_div_ps(n[1], total)],
        n[2],
    );
    let half = _mm256_set1_ps(0.5);
    let word = |c| {
        let unit = _mm256_add_ps(_mm256_mul_ps(c, half), half);
        let steps = _mm256_add_ps(_mm256_mul_ps(unit, _mm256_set1_ps(65_535.0)), half);
        // Not below zero, so that truncation rounds down; zero for what is not a number.
        _mm256_cvttps_epi32(positive(steps))
    };
    _mm256_or_si256(word(x), _mm256_slli_epi32::<16>(word(y)))
}

/// [`crate::shared::octahedral::unpack`].
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
pub fn unpack(bits: __m256) -> Lanes3 {
    let bits = _mm256_castps_si256(bits);
    let (one, two) = (_mm256_set1_ps(1.0), _mm256_set1_ps(2.0));
    let signed = |word| {
        let unit = _mm256_div_ps(_mm256_cvtepi32_ps(word), _mm256_set1_ps(65_535.0));
        _mm256_sub_ps(_mm256_mul_ps(unit, two), one)
    };
    let p = [
        signed(_mm256_and_si256(bits, _mm256_set1_epi32(0xffff))),
        signed(_mm256_srli_epi32::<16>(bits)),
    ];
    let z = _mm256_sub_ps(_mm256_sub_ps(one, magnitude(p[0])), magnitude(p[1]));
    let [x, y] = folded(&p, z);
    normalized(&[x, y, z])
}

/// [`crate::shared::octahedral::hemisphere_encode`].
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
pub fn hemisphere(d: &Lanes3) -> [__m256; 2] {
    let half = _mm256_set1_ps(0.5);
    let sum = _mm256_add_ps(_mm256_add_ps(magnitude(d[0]), magnitude(d[1])), d[2]);
    // The second operand is taken where the first is not a number, as by `f32::max`.
    let sum = _mm256_max_ps(sum, _mm256_set1_ps(1e-30));
    let (x, y) = (_mm256_div_ps(d[0], sum), _mm256_div_ps(d[1], sum));
    let unit = |s: __m256| _mm256_add_ps(_mm256_mul_ps(s, half), half);
    [unit(_mm256_add_ps(x, y)), unit(_mm256_sub_ps(x, y))]
}

/// [`crate::shared::sampling::to_local`].
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
pub fn to_local(world: &Lanes3, n: &Lanes3) -> Lanes3 {
    let one = _mm256_set1_ps(1.0);
    let up = _mm256_cmp_ps::<_CMP_GE_OQ>(n[2], _mm256_setzero_ps());
    let sign = _mm256_blendv_ps(_mm256_set1_ps(-1.0), one, up);
    let a = _mm256_div_ps(_mm256_set1_ps(-1.0), _mm256_add_ps(sign, n[2]));
    let b = _mm256_mul_ps(_mm256_mul_ps(n[0], n[1]), a);
    let signed_x = _mm256_mul_ps(sign, n[0]);
    let tangent = [
        _mm256_add_ps(one, _mm256_mul_ps(_mm256_mul_ps(signed_x, n[0]), a)),
        _mm256_mul_ps(sign, b),
        negated(signed_x),
    ];
    let bitangent = [
        b,
        _mm256_add_ps(sign, _mm256_mul_ps(_mm256_mul_ps(n[1], n[1]), a)),
        negated(n[1]),
    ];
    [dot(world, &tangent), dot(world, &bitangent), dot(world, n)]
}
