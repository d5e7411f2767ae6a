//! Pixels that the surfels light themselves, eight at a time: [`crate::stages::select_pixels::select_each`], operation for
//! operation. Every second pixel of a row has the same neighbours to ask.
#![allow(unsafe_code)]
#[cfg(test)]
mod tests;

use std::arch::x86_64::*;
use std::ops::Range;

use super::Avx2;
use super::directions::unpack;
use super::lanes::{Lanes3, all, columns, difference, dot, inverted, is_word, magnitude};
use crate::data::{Camera, NONE, SurfacePoint};
use crate::shared::surface;
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
        let (x, y) = (first % width, first / width);
        let last = end.min(first - x + width);
        // Pixels that nothing has to be asked about are set at once; in the last column and the last row, those around
        // lie beyond the picture.
        let (even, odd) = (first + x % 2, first + 1 - x % 2);
        let inner = last.min(y * width + width - 1);
        if y % 2 == 1 && y + 1 == height {
            (first..last).for_each(|i| set(i, surface::is_surface(&points[i])));
        } else {
            let is_last = last > inner && width.is_multiple_of(2);
            if is_last {
                set(inner, surface::is_surface(&points[inner]));
            }
            let w = width as isize;
            let scene = (camera, points);
            if y % 2 == 0 {
                (even..last)
                    .step_by(2)
                    .for_each(|i| set(i, surface::is_surface(&points[i])));
                every_second(scene, odd..inner, [-1, 1], &mut set);
            } else {
                every_second(scene, even..last, [-w, w], &mut set);
                every_second(scene, odd..inner, [-w - 1, w + 1, 1 - w, w - 1], &mut set);
            }
        }
        first = last;
    }
    (end.max(range.start)..range.end).for_each(|i| set(i, false));
}

/// Selects every second pixel of a range: those with a surface that another one is next to, by these differences of
/// indices.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn every_second<const AROUND: usize>(
    (camera, points): (&Camera, &[SurfacePoint]),
    range: Range<usize>,
    around: [isize; AROUND],
    set: &mut impl FnMut(usize, bool),
) {
    if range.is_empty() {
        return;
    }
    let last = range.end - 1 - (range.end - 1 - range.start) % 2;
    for first in range.step_by(16) {
        let ids: [usize; 8] = std::array::from_fn(|lane| (first + 2 * lane).min(last));
        let here = Here::at(camera, &ids.map(|i| &points[i]));
        let mut same = here.is_surface;
        for by in around {
            let there = ids.map(|i| &points[i.wrapping_add_signed(by)]);
            same = _mm256_and_ps(same, here.continuous(&there));
        }
        let selected = _mm256_movemask_ps(_mm256_andnot_ps(same, here.is_surface));
        for (lane, i) in (first..=last).step_by(2).take(8).enumerate() {
            set(i, selected >> lane & 1 != 0);
        }
    }
}

/// Eight points, in columns, whose neighbours are asked about.
struct Here {
    position: Lanes3,
    tolerance: __m256,
    packed: [__m256i; 2],
    geometric: Lanes3,
    shading: Lanes3,
    node: __m256i,
    is_surface: __m256,
}

impl Here {
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn at(camera: &Camera, points: &[&SurfacePoint; 8]) -> Self {
        let [x, y, z, offset] = columns::<0, _>(points);
        let [geometric, shading, _, _] = columns::<4, _>(points);
        let [_, _, _, node] = columns::<8, _>(points);
        let node = _mm256_castps_si256(node);
        let position = [x, y, z];
        let to = difference(&position, &all(camera.eye));
        // As `upsample::tolerance`.
        let distance = _mm256_sqrt_ps(dot(&to, &to));
        let share = _mm256_set1_ps(PLANE_TOLERANCE * camera.pixel_angle);
        Here {
            position,
            tolerance: _mm256_add_ps(_mm256_mul_ps(share, distance), offset),
            packed: [_mm256_castps_si256(geometric), _mm256_castps_si256(shading)],
            geometric: unpack(geometric),
            shading: unpack(shading),
            node,
            is_surface: inverted(is_word(node, NONE)),
        }
    }

    /// [`crate::shared::upsample::continuous`].
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn continuous(&self, there: &[&SurfacePoint; 8]) -> __m256 {
        let [x, y, z, _] = columns::<0, _>(there);
        let [geometric, shading, _, _] = columns::<4, _>(there);
        let [_, _, _, node] = columns::<8, _>(there);
        let d = difference(&[x, y, z], &self.position);
        let in_plane = |normal: &Lanes3| {
            let off = magnitude(dot(normal, &d));
            _mm256_cmp_ps::<_CMP_NGT_UQ>(off, self.tolerance)
        };
        let same = |a, b| _mm256_castsi256_ps(_mm256_cmpeq_epi32(a, _mm256_castps_si256(b)));
        let mut found = _mm256_and_ps(same(self.node, node), in_plane(&self.geometric));
        // Normals that are the same need not be unpacked.
        let flat = same(self.packed[0], geometric);
        if _mm256_movemask_ps(_mm256_andnot_ps(flat, found)) != 0 {
            let back = _mm256_or_ps(flat, in_plane(&unpack(geometric)));
            found = _mm256_and_ps(found, back);
        }
        let parallel = same(self.packed[1], shading);
        if _mm256_movemask_ps(_mm256_andnot_ps(parallel, found)) != 0 {
            let cosine = dot(&unpack(shading), &self.shading);
            let close = _mm256_cmp_ps::<_CMP_GE_OQ>(cosine, _mm256_set1_ps(NORMAL_TOLERANCE));
            found = _mm256_and_ps(found, _mm256_or_ps(parallel, close));
        }
        found
    }
}
