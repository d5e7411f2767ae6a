//! Pixels that the surfels light themselves, sixteen at a time: [`crate::stages::select_pixels::select_each`], operation for
//! operation. Of the sixteen, the eight with even columns ask the same neighbours each, and so do the eight with odd ones, whose
//! neighbours on the right are those on the left of the next lane.
#![allow(unsafe_code)]
#[cfg(test)]
mod tests;

use std::arch::x86_64::*;
use std::ops::Range;

use super::Avx2;
use super::directions::unpack;
use super::lanes::{
    Lanes3, all, columns, difference, dot, inverted, is_word, loaded_words, magnitude,
};
use crate::data::{Camera, NONE, SurfacePoint};
use crate::shared::upsample::{NORMAL_TOLERANCE, PLANE_TOLERANCE};
use crate::stages::select_pixels::select_each;

/// Same as [`select_each`].
#[inline]
pub fn select_pixels(
    camera: &Camera,
    points: &[SurfacePoint],
    range: Range<usize>,
    set: impl FnMut(usize, bool),
) {
    match Avx2::detect() {
        // SAFETY: there is a proof that the processor has the features.
        Some(Avx2 { .. }) => unsafe { select_wide(camera, points, range, set) },
        None => select_each(camera, points, range, set),
    }
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn select_wide(
    camera: &Camera,
    points: &[SurfacePoint],
    range: Range<usize>,
    mut set: impl FnMut(usize, bool),
) {
    let (width, height) = (camera.width as usize, camera.height as usize);
    let end = range.end.min(width * height);
    let mut first = range.start;
    while first < end {
        let y = first / width;
        let row = Row {
            camera,
            points,
            width,
            start: y * width,
            is_odd: y % 2 == 1,
            is_last: y + 1 == height,
        };
        let last = end.min(row.start + width);
        // From an even column on, whichever the first one is.
        let even = (first - row.start) & !1;
        for x in (even..last - row.start).step_by(16) {
            let selected = row.select(x);
            let begin = row.start + x;
            for i in begin.max(first)..last.min(begin + 16) {
                set(i, selected >> (i - begin) & 1 != 0);
            }
        }
        first = last;
    }
    (end.max(range.start)..range.end).for_each(|i| set(i, false));
}

/// A row of the picture.
struct Row<'a> {
    camera: &'a Camera,
    points: &'a [SurfacePoint],
    width: usize,
    /// Index of the first pixel.
    start: usize,
    /// Its number is odd, so that even ones lie above and below.
    is_odd: bool,
    /// No row is below.
    is_last: bool,
}

impl Row<'_> {
    /// A bit for each of sixteen pixels from an even column on that is selected; those beyond the row have arbitrary ones.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn select(&self, x: usize) -> u32 {
        let column = |i: usize| self.start + (x + i).min(self.width - 1);
        let evens: [usize; 8] = std::array::from_fn(|lane| column(2 * lane));
        let odds: [usize; 8] = std::array::from_fn(|lane| column(2 * lane + 1));
        let beyond = column(16);
        // Right of the odd ones among these there is a pixel.
        let inner = within((self.width - x - 1) / 2);
        let even = Points::at(self.points, &evens);
        let odd = Points::at(self.points, &odds);
        let (mut even_lies, mut odd_lies) = (_mm256_setzero_ps(), _mm256_setzero_ps());
        if !self.is_odd {
            let next = even.shifted(&self.points[beyond]);
            let here = Here::at(self.camera, &odd);
            odd_lies = _mm256_and_ps(here.continuous(&even), here.continuous(&next));
        } else if !self.is_last {
            let [above, below] = [evens.map(|i| i - self.width), evens.map(|i| i + self.width)]
                .map(|ids| Points::at(self.points, &ids));
            let here = Here::at(self.camera, &even);
            even_lies = _mm256_and_ps(here.continuous(&above), here.continuous(&below));
            let here = Here::at(self.camera, &odd);
            odd_lies = _mm256_and_ps(here.continuous(&above), here.continuous(&below));
            let next = above.shifted(&self.points[beyond - self.width]);
            odd_lies = _mm256_and_ps(odd_lies, here.continuous(&next));
            let next = below.shifted(&self.points[beyond + self.width]);
            odd_lies = _mm256_and_ps(odd_lies, here.continuous(&next));
        }
        odd_lies = _mm256_and_ps(odd_lies, inner);
        let selected = |of: &Points, lies: __m256| {
            _mm256_movemask_ps(_mm256_andnot_ps(lies, of.are_surfaces())) as u32
        };
        let (even, odd) = (selected(&even, even_lies), selected(&odd, odd_lies));
        _pdep_u32(even, 0x5555) | _pdep_u32(odd, 0xaaaa)
    }
}

/// The mask of the first lanes.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn within(count: usize) -> __m256 {
    let lanes = loaded_words(&[0, 1, 2, 3, 4, 5, 6, 7]);
    _mm256_castsi256_ps(_mm256_cmpgt_epi32(_mm256_set1_epi32(count as i32), lanes))
}

/// Eight points, in columns: what tells surfaces apart.
struct Points {
    position: Lanes3,
    offset: __m256,
    geometric: __m256,
    shading: __m256,
    node: __m256,
}

impl Points {
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn at(points: &[SurfacePoint], ids: &[usize; 8]) -> Self {
        let points = ids.map(|i| &points[i]);
        let [x, y, z, offset] = columns::<0, _>(&points);
        let [geometric, shading, _, _] = columns::<4, _>(&points);
        let [_, _, _, node] = columns::<8, _>(&points);
        Points {
            position: [x, y, z],
            offset,
            geometric,
            shading,
            node,
        }
    }

    /// The same, a lane on, and another one behind the last.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn shifted(&self, last: &SurfacePoint) -> Self {
        let on = loaded_words(&[1, 2, 3, 4, 5, 6, 7, 7]);
        let shift = |lanes: __m256, last: f32| {
            let moved = _mm256_permutevar8x32_ps(lanes, on);
            _mm256_blend_ps::<0x80>(moved, _mm256_set1_ps(last))
        };
        let [x, y, z] = self.position;
        Points {
            position: [
                shift(x, last.position.x),
                shift(y, last.position.y),
                shift(z, last.position.z),
            ],
            offset: shift(self.offset, last.offset),
            geometric: shift(self.geometric, f32::from_bits(last.geometric_normal)),
            shading: shift(self.shading, f32::from_bits(last.shading_normal)),
            node: shift(self.node, f32::from_bits(last.transform_id)),
        }
    }

    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn are_surfaces(&self) -> __m256 {
        inverted(is_word(_mm256_castps_si256(self.node), NONE))
    }
}

/// Eight points whose neighbours are asked about.
struct Here<'a> {
    points: &'a Points,
    tolerance: __m256,
    geometric: Lanes3,
    shading: Lanes3,
}

impl<'a> Here<'a> {
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn at(camera: &Camera, points: &'a Points) -> Self {
        let to = difference(&points.position, &all(camera.eye));
        // As `upsample::tolerance`.
        let distance = _mm256_sqrt_ps(dot(&to, &to));
        let share = _mm256_set1_ps(PLANE_TOLERANCE * camera.pixel_angle);
        Here {
            points,
            tolerance: _mm256_add_ps(_mm256_mul_ps(share, distance), points.offset),
            geometric: unpack(points.geometric),
            shading: unpack(points.shading),
        }
    }

    /// [`crate::shared::upsample::continuous`].
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn continuous(&self, there: &Points) -> __m256 {
        let d = difference(&there.position, &self.points.position);
        let in_plane = |normal: &Lanes3| {
            let off = magnitude(dot(normal, &d));
            _mm256_cmp_ps::<_CMP_NGT_UQ>(off, self.tolerance)
        };
        let same = |a: __m256, b: __m256| {
            _mm256_castsi256_ps(_mm256_cmpeq_epi32(
                _mm256_castps_si256(a),
                _mm256_castps_si256(b),
            ))
        };
        let node = same(self.points.node, there.node);
        let mut found = _mm256_and_ps(node, in_plane(&self.geometric));
        // Normals that are the same need not be unpacked.
        let flat = same(self.points.geometric, there.geometric);
        if _mm256_movemask_ps(_mm256_andnot_ps(flat, found)) != 0 {
            let back = _mm256_or_ps(flat, in_plane(&unpack(there.geometric)));
            found = _mm256_and_ps(found, back);
        }
        let parallel = same(self.points.shading, there.shading);
        if _mm256_movemask_ps(_mm256_andnot_ps(parallel, found)) != 0 {
            let cosine = dot(&unpack(there.shading), &self.shading);
            let close = _mm256_cmp_ps::<_CMP_GE_OQ>(cosine, _mm256_set1_ps(NORMAL_TOLERANCE));
            found = _mm256_and_ps(found, _mm256_or_ps(parallel, close));
        }
        found
    }
}
