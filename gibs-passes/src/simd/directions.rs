//! Eight unit vectors: [`crate::shared::octahedral`] and the frames of [`crate::shared::sampling`], operation for operation.
use std::arch::x86_64::*;

use crate::shared::octahedral;

use super::lanes::{Lanes3, difference, dot, either, magnitude, negated, positive, scaled, sum};

/// `Vec3::normalize`.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn normalized(v: &Lanes3) -> Lanes3 {
    let length = _mm256_sqrt_ps(dot(v, v));
    scaled(v, _mm256_div_ps(_mm256_set1_ps(1.0), length))
}

/// What an octahedral map makes of the lower half.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
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
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn pack(n: &Lanes3) -> __m256i {
    pack_in_steps::<16>(n, 65_535.0)
}

/// Unit vectors in two numbers of so many bits, which count so many steps.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn pack_in_steps<const BITS: i32>(n: &Lanes3, steps: f32) -> __m256i {
    let total = _mm256_add_ps(
        _mm256_add_ps(magnitude(n[0]), magnitude(n[1])),
        magnitude(n[2]),
    );
    let scale = _mm256_div_ps(_mm256_set1_ps(1.0), total);
    let [x, y] = folded(
        &[_mm256_mul_ps(n[0], scale), _mm256_mul_ps(n[1], scale)],
        n[2],
    );
    let half = _mm256_set1_ps(0.5);
    let word = |c| {
        let unit = _mm256_add_ps(_mm256_mul_ps(c, half), half);
        let steps = _mm256_add_ps(_mm256_mul_ps(unit, _mm256_set1_ps(steps)), half);
        // Not below zero, so that truncation rounds down; zero for what is not a number.
        _mm256_cvttps_epi32(positive(steps))
    };
    _mm256_or_si256(word(x), _mm256_slli_epi32::<BITS>(word(y)))
}

/// [`crate::shared::octahedral::unpack`].
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn unpack(bits: __m256) -> Lanes3 {
    let bits = _mm256_castps_si256(bits);
    let (one, two) = (_mm256_set1_ps(1.0), _mm256_set1_ps(2.0));
    let signed = |word| {
        let unit = _mm256_mul_ps(_mm256_cvtepi32_ps(word), _mm256_set1_ps(octahedral::STEP));
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
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn hemisphere(d: &Lanes3) -> [__m256; 2] {
    let half = _mm256_set1_ps(0.5);
    let sum = _mm256_add_ps(_mm256_add_ps(magnitude(d[0]), magnitude(d[1])), d[2]);
    // The second operand is taken where the first is not a number, as by `f32::max`.
    let sum = _mm256_max_ps(sum, _mm256_set1_ps(1e-30));
    let (x, y) = (_mm256_div_ps(d[0], sum), _mm256_div_ps(d[1], sum));
    let unit = |s: __m256| _mm256_add_ps(_mm256_mul_ps(s, half), half);
    [unit(_mm256_add_ps(x, y)), unit(_mm256_sub_ps(x, y))]
}

/// [`crate::shared::sampling::basis`].
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn basis(n: &Lanes3) -> [Lanes3; 2] {
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
    [tangent, bitangent]
}

/// [`crate::shared::sampling::to_local`].
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn to_local(world: &Lanes3, n: &Lanes3) -> Lanes3 {
    let [tangent, bitangent] = basis(n);
    [dot(world, &tangent), dot(world, &bitangent), dot(world, n)]
}

/// [`crate::shared::sampling::to_world`].
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn to_world(local: &Lanes3, n: &Lanes3) -> Lanes3 {
    let [tangent, bitangent] = basis(n);
    let flat = sum(&scaled(&tangent, local[0]), &scaled(&bitangent, local[1]));
    normalized(&sum(&flat, &scaled(n, local[2])))
}

/// [`crate::shared::sampling::cosine_hemisphere`].
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn cosine_hemisphere(u: __m256, v: __m256) -> Lanes3 {
    let radius = _mm256_sqrt_ps(u);
    let [sin, cos] = sin_cos_turns(v);
    let up = positive(_mm256_sub_ps(_mm256_set1_ps(1.0), u));
    [
        _mm256_mul_ps(radius, cos),
        _mm256_mul_ps(radius, sin),
        _mm256_sqrt_ps(up),
    ]
}

/// Directions over the lobes of eight surfaces.
pub struct Drawn {
    /// Unit directions.
    pub direction: Lanes3,
    /// Cosines with the normals.
    pub cosine: __m256,
    /// Densities, 1/sr.
    pub density: __m256,
}

/// [`crate::shared::mixture::over_the_lobe`], in a scene without emitters.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn over_the_lobe(normal: &Lanes3, u: __m256, v: __m256) -> Drawn {
    let local = cosine_hemisphere(u, v);
    let per_cosine = _mm256_set1_ps(std::f32::consts::FRAC_1_PI);
    Drawn {
        direction: to_world(&local, normal),
        cosine: local[2],
        density: _mm256_mul_ps(positive(local[2]), per_cosine),
    }
}

/// [`crate::shared::portable::sin_cos_turns`].
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn sin_cos_turns(turns: __m256) -> [__m256; 2] {
    let in_quarters = _mm256_mul_ps(_mm256_set1_ps(4.0), turns);
    let quarters = _mm256_floor_ps(_mm256_add_ps(in_quarters, _mm256_set1_ps(0.5)));
    let a = _mm256_mul_ps(
        _mm256_sub_ps(in_quarters, quarters),
        _mm256_set1_ps(std::f32::consts::FRAC_PI_2),
    );
    let a2 = _mm256_mul_ps(a, a);
    let series = |terms: &[f32]| {
        let add = |sum, &term: &f32| _mm256_add_ps(_mm256_set1_ps(term), _mm256_mul_ps(a2, sum));
        terms[1..].iter().fold(_mm256_set1_ps(terms[0]), add)
    };
    let of_sin = series(&[-0.000_198_412_7, 0.008_333_333, -0.166_666_67, 1.0]);
    let sin = _mm256_mul_ps(a, of_sin);
    let cos = series(&[
        0.000_024_801_588,
        -0.001_388_888_9,
        0.041_666_668,
        -0.5,
        1.0,
    ]);
    // From one quarter to the next the two change places, and one of them its sign.
    let quarter = _mm256_cvttps_epi32(quarters);
    let odd = _mm256_castsi256_ps(_mm256_slli_epi32::<31>(quarter));
    let second = _mm256_castsi256_ps(_mm256_slli_epi32::<30>(quarter));
    let sign = _mm256_set1_ps(-0.0);
    let of_sin = _mm256_and_ps(second, sign);
    let of_cos = _mm256_and_ps(_mm256_xor_ps(odd, second), sign);
    [
        _mm256_xor_ps(_mm256_blendv_ps(sin, cos, odd), of_sin),
        _mm256_xor_ps(_mm256_blendv_ps(cos, sin, odd), of_cos),
    ]
}

/// [`crate::shared::sampling::start`].
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn start(
    position: &Lanes3,
    n: &Lanes3,
    offset: __m256,
    below: f32,
    direction: &Lanes3,
) -> Lanes3 {
    let above = _mm256_cmp_ps::<_CMP_GE_OQ>(dot(n, direction), _mm256_set1_ps(-below));
    let step = scaled(n, offset);
    either(above, &sum(position, &step), &difference(position, &step))
}
