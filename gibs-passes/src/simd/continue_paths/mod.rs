//! Next segments of paths, eight at a time: [`crate::stages::continue_paths::continue_each`], operation for operation.
#![allow(unsafe_code)]
#[cfg(test)]
mod tests;

use std::arch::x86_64::*;
use std::ops::Range;

use super::directions::{over_the_lobe, start, unpack};
use super::hashes::{pcg, unit};
use super::lanes::{columns, store_rows};
use super::{Avx2, prefetch};
use crate::data::{Path, Ray};
use crate::stages::continue_paths::{Paths, continue_each};
use bytemuck::Zeroable;

/// Paths that are looked through at once.
const BATCH: usize = 64;

/// Same as [`continue_each`], to which emitters, that most scenes do not have, are left.
#[inline]
pub fn continue_paths(paths: &Paths<'_>, range: Range<usize>, set: impl FnMut(usize, Ray, Path)) {
    match Avx2::detect() {
        // SAFETY: there is a proof that the processor has the features.
        Some(Avx2 { .. }) if paths.emitters.is_empty() => unsafe {
            continue_wide(paths, range, set)
        },
        Some(avx2) => avx2.run(
            #[inline(always)]
            || continue_each(paths, range, set),
        ),
        None => continue_each(paths, range, set),
    }
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn continue_wide(paths: &Paths<'_>, range: Range<usize>, mut set: impl FnMut(usize, Ray, Path)) {
    for first in range.clone().step_by(BATCH) {
        let mut going = [(0, 0); BATCH];
        let mut count = 0;
        for i in first..range.end.min(first + BATCH) {
            if let Some(place) = paths.place(i) {
                going[count % BATCH] = (i, place);
                prefetch(paths.points, i);
                prefetch(paths.paths, i);
                count += 1;
            }
        }
        for start in (0..count).step_by(8) {
            // The last eight are filled up with the last of all.
            let eight: [_; 8] = std::array::from_fn(|lane| going[(start + lane).min(count - 1)]);
            let (rays, next) = continued(paths, &eight.map(|(i, _)| i));
            let made = eight.iter().zip(rays.iter().zip(&next));
            for (&(_, place), (&ray, &path)) in made.take(count - start) {
                set(place, ray, path);
            }
        }
    }
}

#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn continued(paths: &Paths<'_>, ids: &[usize; 8]) -> ([Ray; 8], [Path; 8]) {
    let points = ids.map(|i| &paths.points[i]);
    let before = ids.map(|i| &paths.paths[i]);
    let [x, y, z, offset] = columns::<0, _>(&points);
    let [geometric, shading, _, _] = columns::<4, _>(&points);
    let [r, g, b, root] = columns::<0, _>(&before);
    let [seed, surfel, _, _] = columns::<4, _>(&before);
    let first = pcg(_mm256_castps_si256(seed));
    let second = pcg(first);
    let third = pcg(second);
    let drawn = over_the_lobe(&unpack(shading), unit(first), unit(second));
    let [dx, dy, dz] = drawn.direction;
    let [x, y, z] = start(
        &[x, y, z],
        &unpack(geometric),
        offset,
        0.0,
        &drawn.direction,
    );
    let mut rays = [Ray::zeroed(); 8];
    let far = _mm256_set1_ps(f32::MAX);
    store_rows(
        &mut rays,
        &[x, y, z, _mm256_setzero_ps()],
        &[dx, dy, dz, far],
    );
    let mut next = [Path::zeroed(); 8];
    store_rows(
        &mut next,
        &[r, g, b, root],
        &[
            _mm256_castsi256_ps(third),
            surfel,
            drawn.cosine,
            drawn.density,
        ],
    );
    (rays, next)
}
