//! Rays through the centres of pixels, eight at a time: [`crate::stages::primary_rays::primary_each`], operation for operation.
#![allow(unsafe_code)]
#[cfg(test)]
mod tests;

use std::arch::x86_64::*;
use std::ops::Range;

use super::Avx2;
use super::directions::normalized;
use super::lanes::{all, all_lanes, loaded, scaled, store_rows, sum};
use crate::data::{Camera, Ray};
use crate::stages::primary_rays::primary_each;
use bytemuck::Zeroable;

/// Same as [`primary_each`].
#[inline]
pub fn primary_rays(camera: &Camera, range: Range<usize>, set: impl FnMut(usize, Ray)) {
    match Avx2::detect() {
        // SAFETY: there is a proof that the processor has the features.
        Some(Avx2 { .. }) => unsafe { primary_wide(camera, range, set) },
        None => primary_each(camera, range, set),
    }
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn primary_wide(camera: &Camera, range: Range<usize>, mut set: impl FnMut(usize, Ray)) {
    let width = camera.width.max(1);
    let (mut x, mut y) = (range.start as u32 % width, range.start as u32 / width);
    let (half, one, two) = (all_lanes(0.5), all_lanes(1.0), all_lanes(2.0));
    for first in range.clone().step_by(8) {
        let (mut columns, mut rows) = ([0.0; 8], [0.0; 8]);
        for lane in 0..8 {
            (columns[lane], rows[lane]) = (x as f32, y as f32);
            x += 1;
            if x == width {
                (x, y) = (0, y + 1);
            }
        }
        let (at_x, at_y) = (
            _mm256_add_ps(loaded(&columns), half),
            _mm256_add_ps(loaded(&rows), half),
        );
        let doubled = |at, side: u32| _mm256_mul_ps(_mm256_div_ps(at, all_lanes(side as f32)), two);
        let across = _mm256_sub_ps(doubled(at_x, camera.width), one);
        let upwards = _mm256_sub_ps(one, doubled(at_y, camera.height));
        let through = sum(
            &sum(&all(camera.forward), &scaled(&all(camera.right), across)),
            &scaled(&all(camera.up), upwards),
        );
        let [dx, dy, dz] = normalized(&through);
        let [ox, oy, oz] = all(camera.eye);
        let mut rays = [Ray::zeroed(); 8];
        store_rows(
            &mut rays,
            &[ox, oy, oz, all_lanes(-0.0)],
            &[dx, dy, dz, all_lanes(f32::MAX)],
        );
        for (i, ray) in (first..range.end).zip(rays) {
            set(i, ray);
        }
    }
}
