//! Numbers and vectors of eight lanes.
#![allow(unsafe_code)]
use std::arch::x86_64::*;

use bytemuck::Pod;
use glam::Vec3;

/// Eight vectors, by coordinate.
pub type Lanes3 = [__m256; 3];

/// One vector, eight times.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn all(v: Vec3) -> Lanes3 {
    [
        _mm256_set1_ps(v.x),
        _mm256_set1_ps(v.y),
        _mm256_set1_ps(v.z),
    ]
}

/// One number, eight times.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn all_lanes(x: f32) -> __m256 {
    _mm256_set1_ps(x)
}

/// [`crate::shared::estimator::luminance`].
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn luminance(c: &Lanes3) -> __m256 {
    dot(
        c,
        &[all_lanes(0.2126), all_lanes(0.7152), all_lanes(0.0722)],
    )
}

/// [`crate::stages::resolve_hits::map_transposed`].
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn map_transposed(rows: &[[__m256; 4]; 3], v: &Lanes3) -> Lanes3 {
    let part = |i: usize| {
        let [x, y, z, _] = rows[i];
        scaled(&[x, y, z], v[i])
    };
    sum(&sum(&part(0), &part(1)), &part(2))
}

/// Eight dot products.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn dot(a: &Lanes3, b: &Lanes3) -> __m256 {
    let xy = _mm256_add_ps(_mm256_mul_ps(a[0], b[0]), _mm256_mul_ps(a[1], b[1]));
    _mm256_add_ps(xy, _mm256_mul_ps(a[2], b[2]))
}

/// The number, or zero where it is negative or none.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn positive(x: __m256) -> __m256 {
    _mm256_max_ps(x, _mm256_setzero_ps())
}

/// The number with the other sign.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn negated(x: __m256) -> __m256 {
    _mm256_xor_ps(x, _mm256_set1_ps(-0.0))
}

/// The lanes, in order.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn stored(x: __m256) -> [f32; 8] {
    let mut lanes = [0.0; 8];
    // SAFETY: the store writes the eight floats of the array and needs no alignment.
    unsafe { _mm256_storeu_ps(lanes.as_mut_ptr(), x) };
    lanes
}

/// The whole numbers of the lanes, in order.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn stored_words(x: __m256i) -> [u32; 8] {
    let mut lanes = [0; 8];
    // SAFETY: the store writes the eight words of the array and needs no alignment.
    unsafe { _mm256_storeu_si256(lanes.as_mut_ptr().cast(), x) };
    lanes
}

/// Calls `each` with the lanes of a mask of eight bits, in order.
#[inline(always)]
pub fn for_lanes(mut mask: u32, mut each: impl FnMut(usize)) {
    while mask != 0 {
        each(mask.trailing_zeros() as usize & 7);
        mask &= mask - 1;
    }
}

/// The bits of a mask, or zero.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn selected(mask: __m256, bits: u32) -> __m256i {
    _mm256_and_si256(_mm256_castps_si256(mask), _mm256_set1_epi32(bits as i32))
}

/// Lanes in which a word has any of some bits.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn has_any(words: __m256i, bits: u32) -> __m256 {
    let found = _mm256_and_si256(words, _mm256_set1_epi32(bits as i32));
    let none = _mm256_cmpeq_epi32(found, _mm256_setzero_si256());
    inverted(_mm256_castsi256_ps(none))
}

/// Lanes in which a word is another.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn is_word(words: __m256i, word: u32) -> __m256 {
    _mm256_castsi256_ps(_mm256_cmpeq_epi32(words, _mm256_set1_epi32(word as i32)))
}

/// The other lanes.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn inverted(mask: __m256) -> __m256 {
    _mm256_xor_ps(mask, _mm256_castsi256_ps(_mm256_set1_epi32(-1)))
}

/// Each vector times a number.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn scaled(v: &Lanes3, k: __m256) -> Lanes3 {
    [
        _mm256_mul_ps(v[0], k),
        _mm256_mul_ps(v[1], k),
        _mm256_mul_ps(v[2], k),
    ]
}

/// Each vector plus another.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn sum(a: &Lanes3, b: &Lanes3) -> Lanes3 {
    [
        _mm256_add_ps(a[0], b[0]),
        _mm256_add_ps(a[1], b[1]),
        _mm256_add_ps(a[2], b[2]),
    ]
}

/// Each vector less another.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn difference(a: &Lanes3, b: &Lanes3) -> Lanes3 {
    [
        _mm256_sub_ps(a[0], b[0]),
        _mm256_sub_ps(a[1], b[1]),
        _mm256_sub_ps(a[2], b[2]),
    ]
}

/// Each vector over a number.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn divided(v: &Lanes3, k: __m256) -> Lanes3 {
    [
        _mm256_div_ps(v[0], k),
        _mm256_div_ps(v[1], k),
        _mm256_div_ps(v[2], k),
    ]
}

/// Each vector with the magnitudes of its coordinates.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn magnitudes(v: &Lanes3) -> Lanes3 {
    [magnitude(v[0]), magnitude(v[1]), magnitude(v[2])]
}

/// The number without its sign.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn magnitude(x: __m256) -> __m256 {
    _mm256_andnot_ps(_mm256_set1_ps(-0.0), x)
}

/// `f32::max`: the other one where one is not a number.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn larger(a: __m256, b: __m256) -> __m256 {
    let unordered = _mm256_cmp_ps::<_CMP_UNORD_Q>(a, a);
    // The instruction gives its second operand where either is not a number.
    _mm256_blendv_ps(_mm256_max_ps(b, a), b, unordered)
}

/// `f32::min`: the other one where one is not a number.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn smaller(a: __m256, b: __m256) -> __m256 {
    let unordered = _mm256_cmp_ps::<_CMP_UNORD_Q>(a, a);
    // The instruction gives its second operand where either is not a number.
    _mm256_blendv_ps(_mm256_min_ps(b, a), b, unordered)
}

/// `chosen` in the lanes of a mask, elsewhere `other`.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn either(mask: __m256, chosen: &Lanes3, other: &Lanes3) -> Lanes3 {
    [
        _mm256_blendv_ps(other[0], chosen[0], mask),
        _mm256_blendv_ps(other[1], chosen[1], mask),
        _mm256_blendv_ps(other[2], chosen[2], mask),
    ]
}

/// Each vector, turned around in the lanes of a mask.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn turned(v: &Lanes3, mask: __m256) -> Lanes3 {
    let sign = _mm256_and_ps(mask, _mm256_set1_ps(-0.0));
    [
        _mm256_xor_ps(v[0], sign),
        _mm256_xor_ps(v[1], sign),
        _mm256_xor_ps(v[2], sign),
    ]
}

/// Rows of four words to columns of eight lanes, or the other way round: the halves of register `i` are rows `i` and
/// `i + 4`.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn transposed(r: &[__m256; 4]) -> [__m256; 4] {
    let (a0, a1) = (
        _mm256_unpacklo_ps(r[0], r[1]),
        _mm256_unpackhi_ps(r[0], r[1]),
    );
    let (a2, a3) = (
        _mm256_unpacklo_ps(r[2], r[3]),
        _mm256_unpackhi_ps(r[2], r[3]),
    );
    [
        _mm256_shuffle_ps::<0x44>(a0, a2),
        _mm256_shuffle_ps::<0xee>(a0, a2),
        _mm256_shuffle_ps::<0x44>(a1, a3),
        _mm256_shuffle_ps::<0xee>(a1, a3),
    ]
}

/// Words `FIRST..FIRST + 4` of eight elements, in columns.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn columns<const FIRST: usize, T: Pod>(elements: &[&T; 8]) -> [__m256; 4] {
    const { assert!((FIRST + 4) * size_of::<f32>() <= size_of::<T>()) };
    let row = |lane: usize| {
        let start = std::ptr::from_ref(elements[lane]).cast::<f32>();
        // SAFETY: the four words lie within the element, as asserted, and plain data has no padding; the load needs no
        // alignment.
        unsafe { _mm_loadu_ps(start.add(FIRST)) }
    };
    transposed(&[
        _mm256_set_m128(row(4), row(0)),
        _mm256_set_m128(row(5), row(1)),
        _mm256_set_m128(row(6), row(2)),
        _mm256_set_m128(row(7), row(3)),
    ])
}

/// All elements are the same one: neighbours mostly hit one instance, of one material.
#[inline(always)]
pub fn all_same<T>(elements: &[&T; 8]) -> bool {
    elements.iter().all(|&e| std::ptr::eq(e, elements[0]))
}

/// [`columns`] of elements of which all are the first where `same` says so.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn columns_where<const FIRST: usize, T: Pod>(elements: &[&T; 8], same: bool) -> [__m256; 4] {
    const { assert!((FIRST + 4) * size_of::<f32>() <= size_of::<T>()) };
    if !same {
        return columns::<FIRST, T>(elements);
    }
    let start = std::ptr::from_ref(elements[0]).cast::<f32>();
    std::array::from_fn(|i| {
        // SAFETY: the word lies within the element, as asserted, and plain data has no padding.
        _mm256_set1_ps(unsafe { start.add(FIRST + (i & 3)).read_unaligned() })
    })
}

/// The rows of four columns, by lane.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn rows(columns: &[__m256; 4]) -> [__m128; 8] {
    let [a, b, c, d] = transposed(columns);
    let low = |pair| _mm256_castps256_ps128(pair);
    let high = |pair| _mm256_extractf128_ps::<1>(pair);
    [
        low(a),
        low(b),
        low(c),
        low(d),
        high(a),
        high(b),
        high(c),
        high(d),
    ]
}

/// An element from its rows. It need not pass through memory, where vectors of another size could not be read back at once.
#[inline(always)]
pub fn element<T: Pod, const N: usize>(rows: [__m128; N]) -> T {
    const { assert!(size_of::<T>() == N * size_of::<__m128>()) };
    // SAFETY: any bits are valid in plain data, and the sizes are equal, as asserted.
    unsafe { std::mem::transmute_copy(&rows) }
}

/// Inverse of [`columns`].
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn store_columns<const FIRST: usize, T: Pod>(elements: &mut [T; 8], columns: &[__m256; 4]) {
    const { assert!((FIRST + 4) * size_of::<f32>() <= size_of::<T>()) };
    let rows = transposed(columns);
    let start = elements.as_mut_ptr();
    let store = |lane: usize, row: __m128| {
        // SAFETY: the lane is one of the eight, the four words lie within its element, as asserted, any bits are valid in
        // plain data, and the store needs no alignment.
        unsafe { _mm_storeu_ps(start.add(lane & 7).cast::<f32>().add(FIRST), row) };
    };
    for (lane, &pair) in rows.iter().enumerate() {
        store(lane, _mm256_castps256_ps128(pair));
        store(lane + 4, _mm256_extractf128_ps::<1>(pair));
    }
}

/// Elements of eight words, from their columns: each is written at once, so that it may be read at once soon after.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn store_rows<T: Pod>(elements: &mut [T; 8], low: &[__m256; 4], high: &[__m256; 4]) {
    const { assert!(size_of::<T>() == 8 * size_of::<f32>()) };
    let start = elements.as_mut_ptr();
    let store = |lane: usize, row: __m256| {
        // SAFETY: the lane is one of the eight, its element is eight words, as asserted, any bits are valid in plain data,
        // and the store needs no alignment.
        unsafe { _mm256_storeu_ps(start.add(lane & 7).cast(), row) };
    };
    let halves = transposed(low).into_iter().zip(transposed(high));
    for (lane, (low, high)) in halves.enumerate() {
        store(lane, _mm256_permute2f128_ps::<0x20>(low, high));
        store(lane + 4, _mm256_permute2f128_ps::<0x31>(low, high));
    }
}

/// Inverse of [`stored`].
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn loaded(lanes: &[f32; 8]) -> __m256 {
    // SAFETY: the load reads the eight floats of the array and needs no alignment.
    unsafe { _mm256_loadu_ps(lanes.as_ptr()) }
}

/// Inverse of [`stored_words`].
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn loaded_words(lanes: &[u32; 8]) -> __m256i {
    // SAFETY: the load reads the eight words of the array and needs no alignment.
    unsafe { _mm256_loadu_si256(lanes.as_ptr().cast()) }
}
