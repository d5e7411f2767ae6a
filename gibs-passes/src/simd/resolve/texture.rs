//! Base colours at eight hits: [`crate::shared::texture`] and [`crate::shared::surface`], operation for operation.
#![allow(unsafe_code)]
use std::arch::x86_64::*;

use super::super::lanes::{
    Lanes3, columns_where, either, has_any, inverted, is_word, positive, stored_words,
};
use super::super::prefetch;
use crate::data::{Material, NONE};
use crate::shared::texture;

/// Where the base colours of eight hits come from.
#[derive(Clone, Copy)]
pub struct Picks {
    /// Factor of the colour.
    factor: Lanes3,
    /// There is a texture.
    textured: __m256,
    /// Four texels, as a picture has them, top row first; the first words of all where there is no texture.
    texels: [__m256i; 4],
    /// Weights of the right and of the lower ones.
    weights: [__m256; 2],
}

impl Picks {
    /// What materials, all the same one or not, have at texture coordinates.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn at(materials: &[&Material; 8], same: bool, uv: &[__m256; 2]) -> Self {
        let [r, g, b, _] = columns_where::<0, _>(materials, same);
        let [ux, uy, uz, first] = columns_where::<8, _>(materials, same);
        let first = _mm256_castps_si256(first);
        let textured = inverted(is_word(first, NONE));
        let mut picks = Picks {
            factor: [r, g, b],
            textured,
            texels: [_mm256_setzero_si256(); 4],
            weights: [_mm256_setzero_ps(); 2],
        };
        if _mm256_movemask_ps(textured) == 0 {
            return picks;
        }
        let [vx, vy, vz, size] = columns_where::<12, _>(materials, same);
        let [_, sampler, _, _] = columns_where::<24, _>(materials, same);
        let (size, sampler) = (_mm256_castps_si256(size), _mm256_castps_si256(sampler));
        let nearest = has_any(sampler, texture::NEAREST);
        let width = _mm256_and_si256(size, _mm256_set1_epi32(0xffff));
        let x = Axis::at(mapped(&[ux, uy, uz], uv), width, sampler, nearest);
        let height = _mm256_srli_epi32::<16>(size);
        let v_sampler = _mm256_srli_epi32::<2>(sampler);
        let y = Axis::at(mapped(&[vx, vy, vz], uv), height, v_sampler, nearest);
        let row = |i| _mm256_add_epi32(first, _mm256_mullo_epi32(i, width));
        let (top, bottom) = (row(y.texels[0]), row(y.texels[1]));
        let there = |row, column| {
            let index = _mm256_add_epi32(row, column);
            _mm256_and_si256(index, _mm256_castps_si256(textured))
        };
        picks.texels = [
            there(top, x.texels[0]),
            there(top, x.texels[1]),
            there(bottom, x.texels[0]),
            there(bottom, x.texels[1]),
        ];
        picks.weights = [x.weight, y.weight];
        picks
    }

    /// Asks for the texels: with two rows of them, most of what [`Picks::colors`] waits for.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn prefetch(&self, texels: &[u32]) {
        if _mm256_movemask_ps(self.textured) == 0 {
            return;
        }
        for row in [self.texels[0], self.texels[2]] {
            for index in stored_words(row) {
                prefetch(texels, index as usize);
            }
        }
    }

    /// [`texture::base_color`], without the alpha.
    ///
    /// # Panics
    /// If there is no such texel.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn colors(&self, texels: &[u32]) -> Lanes3 {
        if _mm256_movemask_ps(self.textured) == 0 {
            return self.factor;
        }
        check(&self.texels, texels);
        let words = self.texels.map(|index| {
            // SAFETY: `check` found the texels in the slice and their indices below 2^31, as the gather takes them.
            unsafe { _mm256_i32gather_epi32::<4>(texels.as_ptr().cast(), index) }
        });
        let byte = _mm256_set1_epi32(0xff);
        let linear = |index: __m256i| {
            let index = _mm256_and_si256(index, byte);
            // SAFETY: `check` found the table's 256 words in the slice, and the index is a byte.
            unsafe { _mm256_i32gather_ps::<4>(texels.as_ptr().cast(), index) }
        };
        let one = _mm256_set1_ps(1.0);
        let [fx, fy] = self.weights;
        let (gx, gy) = (_mm256_sub_ps(one, fx), _mm256_sub_ps(one, fy));
        let blend = |a, b, f, g| _mm256_add_ps(_mm256_mul_ps(a, g), _mm256_mul_ps(b, f));
        let filtered = |corners: [__m256i; 4]| {
            let [a, b, c, d] = corners.map(linear);
            blend(blend(a, b, fx, gx), blend(c, d, fx, gx), fy, gy)
        };
        let sampled = [
            filtered(words),
            filtered(words.map(|w| _mm256_srli_epi32::<8>(w))),
            filtered(words.map(|w| _mm256_srli_epi32::<16>(w))),
        ];
        let product = |i: usize| _mm256_mul_ps(self.factor[i], sampled[i]);
        either(
            self.textured,
            &[product(0), product(1), product(2)],
            &self.factor,
        )
    }
}

/// # Panics
/// If one of the texels does not exist.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn check(indices: &[__m256i; 4], texels: &[u32]) {
    // Indices are signed in a gather.
    let count = texels.len().min(1 << 31);
    assert!(count >= texture::LUT, "textures without a table");
    let last = _mm256_set1_epi32((count - 1) as i32);
    let most = _mm256_max_epu32(
        _mm256_max_epu32(indices[0], indices[1]),
        _mm256_max_epu32(indices[2], indices[3]),
    );
    let inside = _mm256_cmpeq_epi32(_mm256_max_epu32(most, last), last);
    assert!(
        _mm256_movemask_epi8(inside) == -1,
        "texels {:?} of {count}",
        stored_words(most)
    );
}

#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn mapped(row: &Lanes3, uv: &[__m256; 2]) -> __m256 {
    let rest = _mm256_add_ps(_mm256_mul_ps(row[1], uv[1]), row[2]);
    _mm256_add_ps(_mm256_mul_ps(row[0], uv[0]), rest)
}

/// Texels along an axis.
struct Axis {
    /// The two around the coordinate; twice the same one without filtering.
    texels: [__m256i; 2],
    /// Weight of the second.
    weight: __m256,
}

impl Axis {
    /// At a texture coordinate, for pictures of a size; wrapped as the lowest bits of `sampler` say.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn at(coordinate: __m256, size: __m256i, sampler: __m256i, nearest: __m256) -> Self {
        let (half, one) = (_mm256_set1_ps(0.5), _mm256_set1_ps(1.0));
        let two = _mm256_set1_ps(2.0);
        let mode = _mm256_and_si256(sampler, _mm256_set1_epi32(3));
        let mirror = is_word(mode, 1);
        // The order of the operands lets what is not a number through.
        let clamped = _mm256_min_ps(two, _mm256_max_ps(_mm256_set1_ps(-1.0), coordinate));
        let periods = _mm256_floor_ps(_mm256_mul_ps(coordinate, half));
        let folded = _mm256_sub_ps(coordinate, _mm256_mul_ps(periods, two));
        let near = _mm256_blendv_ps(folded, clamped, is_word(mode, 2));
        let scaled = _mm256_mul_ps(near, _mm256_cvtepi32_ps(size));
        // Without filtering the texel is that around the coordinate itself, and has all the weight.
        let x = _mm256_sub_ps(scaled, _mm256_andnot_ps(nearest, half));
        let x0 = _mm256_floor_ps(x);
        let x1 = _mm256_add_ps(x0, _mm256_andnot_ps(nearest, one));
        let edges = Edges {
            size,
            mirror,
            clamp: has_any(mode, 2),
        };
        Axis {
            texels: [edges.wrap(x0), edges.wrap(x1)],
            weight: _mm256_andnot_ps(nearest, _mm256_sub_ps(x, x0)),
        }
    }
}

/// How an axis goes on beyond its ends.
struct Edges {
    /// Texels.
    size: __m256i,
    /// By its mirror image.
    mirror: __m256,
    /// By its last texels.
    clamp: __m256,
}

impl Edges {
    /// The texel that stands for another one.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn wrap(&self, texel: __m256) -> __m256i {
        let (zero, ones) = (_mm256_setzero_si256(), _mm256_set1_epi32(-1));
        let mirror = _mm256_castps_si256(self.mirror);
        // What is not a number becomes zero.
        let known = _mm256_cmp_ps::<_CMP_ORD_Q>(texel, texel);
        let i = _mm256_cvttps_epi32(_mm256_and_ps(texel, known));
        let last = _mm256_add_epi32(self.size, ones);
        let period = _mm256_add_epi32(self.size, _mm256_and_si256(self.size, mirror));
        let before = _mm256_and_si256(_mm256_cmpgt_epi32(zero, i), period);
        let j = _mm256_add_epi32(i, before);
        let inside = _mm256_cmpgt_epi32(period, j);
        let k = _mm256_sub_epi32(j, _mm256_andnot_si256(inside, period));
        let over = _mm256_cmpgt_epi32(k, last);
        let again = _mm256_sub_epi32(k, self.size);
        let back = _mm256_sub_epi32(_mm256_add_epi32(period, ones), k);
        let second = _mm256_blendv_epi8(again, back, mirror);
        let wrapped = _mm256_blendv_epi8(k, second, over);
        let clamped = _mm256_max_epi32(zero, _mm256_min_epi32(i, last));
        _mm256_blendv_epi8(wrapped, clamped, _mm256_castps_si256(self.clamp))
    }
}

/// [`crate::shared::surface::unorm16`].
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn unorm16(x: __m256) -> __m256i {
    let unit = _mm256_min_ps(positive(x), _mm256_set1_ps(1.0));
    let steps = _mm256_mul_ps(unit, _mm256_set1_ps(65_535.0));
    // Not below zero, so that truncation rounds down.
    _mm256_cvttps_epi32(_mm256_add_ps(steps, _mm256_set1_ps(0.5)))
}
