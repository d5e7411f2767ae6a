//! Rays over cosine lobes, eight at a time, whichever surfels they are of: [`crate::stages::generate_rays::generate_each`],
//! operation for operation.
#![allow(unsafe_code)]
#[cfg(test)]
mod tests;

use std::arch::x86_64::*;
use std::ops::Range;

use super::Avx2;
use super::directions::{normalized, over_the_lobe, start};
use super::hashes::{hash2, hash3, unit};
use super::lanes::{columns, loaded_words, store_rows};
use super::lookup::poses::planes;
use crate::data::{Path, Ray};
use crate::shared::sampling::R2_STEPS;
use crate::shared::{lengths, mark, plane, requests};
use crate::stages::generate_rays::{Surfels, generate_each};
use bytemuck::Zeroable;

/// Same as [`generate_each`]. Emitters and guides, which most scenes do not have, are left to that.
#[inline]
pub fn generate_rays(
    surfels: &Surfels<'_>,
    range: Range<usize>,
    set: impl FnMut(usize, Ray, Path),
) {
    let over_lobes = surfels.emitters.is_empty() && surfels.guides.is_empty();
    match Avx2::detect() {
        // SAFETY: there is a proof that the processor has the features.
        Some(Avx2 { .. }) if over_lobes => unsafe { generate_wide(surfels, range, set) },
        Some(avx2) => avx2.run(
            #[inline(always)]
            || generate_each(surfels, range, set),
        ),
        None => generate_each(surfels, range, set),
    }
}

/// Eight rays that are to be drawn.
struct Batch {
    /// The surfel of each.
    surfels: [usize; 8],
    /// Which of its surfel's rays it is, in this frame.
    turns: [u32; 8],
    /// Index of the ray.
    rays: [u32; 8],
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn generate_wide(
    surfels: &Surfels<'_>,
    range: Range<usize>,
    mut set: impl FnMut(usize, Ray, Path),
) {
    let mut batch = Batch {
        surfels: [range.start; 8],
        turns: [0; 8],
        rays: [0; 8],
    };
    let mut count = 0;
    for i in range {
        let (first, last) = requests::range(surfels.spans[i]);
        for ray in first..last {
            let at = count % 8;
            batch.surfels[at] = i;
            batch.turns[at] = ray - first;
            batch.rays[at] = ray;
            count += 1;
            if count == 8 {
                batch.draw(surfels, 8, &mut set);
                count = 0;
            }
        }
    }
    if count > 0 {
        // What stands behind the last ray was one before, or is a surfel's first.
        batch.draw(surfels, count, &mut set);
    }
}

impl Batch {
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn draw(&self, from: &Surfels<'_>, count: usize, set: &mut impl FnMut(usize, Ray, Path)) {
        let zero = _mm256_setzero_ps();
        let word = |word: u32| _mm256_set1_epi32(word as i32);
        let poses = self.surfels.map(|i| &from.poses[i]);
        let [x, y, z, _] = columns::<0, _>(&poses);
        let [nx, ny, nz, marks] = columns::<4, _>(&poses);
        let (position, normal) = ([x, y, z], [nx, ny, nz]);
        let offset = self
            .surfels
            .map(|i| lengths::up(from.births[i].lengths).to_bits());
        let drawn = self.surfels.map(|i| from.irradiance[i].drawn);
        let turn = loaded_words(&self.turns);
        let identity = _mm256_srli_epi32::<{ plane::BITS as i32 }>(_mm256_castps_si256(marks));
        let identity = _mm256_and_si256(identity, word(mark::IDENTITY));
        let surfel = hash2(identity, word(from.frame.seed));
        let index = _mm256_add_epi32(loaded_words(&drawn), turn);
        // As `sampling::r2`.
        let along = |axis: usize| {
            let shift = hash2(surfel, word(axis as u32));
            let steps = _mm256_mullo_epi32(index, word(R2_STEPS[axis]));
            unit(_mm256_add_epi32(steps, shift))
        };
        let across = normalized(&planes(marks));
        let drawn = over_the_lobe(&normal, along(0), along(1));
        let [dx, dy, dz] = drawn.direction;
        let offset = _mm256_castsi256_ps(loaded_words(&offset));
        let [x, y, z] = start(&position, &across, offset, plane::OFF, &drawn.direction);
        let mut rays = [Ray::zeroed(); 8];
        store_rows(
            &mut rays,
            &[x, y, z, zero],
            &[dx, dy, dz, _mm256_set1_ps(f32::MAX)],
        );
        let seed = hash3(surfel, word(from.frame.number), turn);
        let one = _mm256_set1_ps(1.0);
        let mut paths = [Path::zeroed(); 8];
        store_rows(
            &mut paths,
            &[one, one, one, _mm256_castsi256_ps(loaded_words(&self.rays))],
            &[
                _mm256_castsi256_ps(seed),
                _mm256_castsi256_ps(loaded_words(&self.surfels.map(|i| i as u32))),
                drawn.cosine,
                drawn.density,
            ],
        );
        let made = rays.iter().zip(&paths).take(count);
        for (&index, (&ray, &path)) in self.rays.iter().zip(made) {
            set(index as usize, ray, path);
        }
    }
}
