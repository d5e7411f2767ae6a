//! Distances into depth functions: [`crate::stages::update_depth::update_each`], operation for operation. Eight rays at a
//! time are taken to their texels, whichever surfels they are of; each texel learns from one after the other.
#![allow(unsafe_code)]
#[cfg(test)]
mod tests;

use std::arch::x86_64::*;
use std::ops::Range;

use super::directions::{hemisphere, to_local};
use super::lanes::{columns, dot, loaded, positive, stored, stored_words};
use super::lookup::poses::Poses;
use super::{Avx2, prefetch};
use crate::shared::depth::{FARTHEST, KNOWN, MOMENT_SCALE, count as texels_of, is_known};
use crate::shared::requests;
use crate::stages::update_depth::{DEPTH_SETTLES, Distances, update_each};

/// Rays whose hits are asked for at once.
const BATCH: usize = 64;

/// Same as [`update_each`].
#[inline]
pub fn update_depth(
    d: &Distances<'_>,
    range: Range<usize>,
    get: impl Fn(usize) -> u32,
    set: impl FnMut(usize, u32),
) {
    match Avx2::detect() {
        // SAFETY: there is a proof that the processor has the features.
        Some(Avx2 { .. }) => unsafe { update_wide(d, range, get, set) },
        None => update_each(d, range, get, set),
    }
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn update_wide(
    d: &Distances<'_>,
    range: Range<usize>,
    get: impl Fn(usize) -> u32,
    mut set: impl FnMut(usize, u32),
) {
    let mut batch = Batch {
        surfels: [0; BATCH],
        samples: [0.0; BATCH],
        rays: [0; BATCH],
        hits: [0; BATCH],
    };
    let mut count = 0;
    for i in range {
        let (first, last) = requests::range(d.spans[i]);
        if first == last {
            continue;
        }
        let before = d.irradiance[i].drawn;
        for ray in first..last {
            let hit = d.places.get(ray as usize).map_or(ray, |&place| place);
            prefetch(d.hits, hit as usize);
            let at = count % BATCH;
            batch.surfels[at] = i as u32;
            batch.samples[at] = (before + (ray - first)) as f32;
            batch.rays[at] = ray;
            batch.hits[at] = hit;
            count += 1;
            if count == BATCH {
                batch.learn(d, count, &get, &mut set);
                count = 0;
            }
        }
    }
    batch.learn(d, count, &get, &mut set);
}

/// Rays in their order.
struct Batch {
    surfels: [u32; BATCH],
    /// Rays that each surfel has drawn before.
    samples: [f32; BATCH],
    rays: [u32; BATCH],
    hits: [u32; BATCH],
}

impl Batch {
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn learn(
        &self,
        d: &Distances<'_>,
        count: usize,
        get: &impl Fn(usize) -> u32,
        set: &mut impl FnMut(usize, u32),
    ) {
        if count == 0 {
            return;
        }
        let mut texels = [[0; 8]; BATCH / 8];
        let mut distances = [[0.0; 8]; BATCH / 8];
        let mut blends = [[0.0; 8]; BATCH / 8];
        // The last eight are filled up with what was there before.
        for e in 0..count.div_ceil(8).min(BATCH / 8) {
            self.eight(d, e, &mut texels[e], &mut distances[e], &mut blends[e]);
        }
        let (texels, distances) = (texels.as_flattened(), distances.as_flattened());
        let lessons = texels.iter().zip(distances).zip(blends.as_flattened());
        let texels_each = texels_of(d.side);
        for (&surfel, ((&texel, &t), &blend)) in self.surfels[..count].iter().zip(lessons) {
            if texel != NOWHERE {
                let texel = surfel as usize * texels_each + texel as usize;
                set(texel, learn(get(texel), t, blend));
            }
        }
    }

    /// Texels, distances in diameters and shares of them in what the texels keep of eight rays.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn eight(
        &self,
        d: &Distances<'_>,
        e: usize,
        texels: &mut [u32; 8],
        distances: &mut [f32; 8],
        blends: &mut [f32; 8],
    ) {
        let part = |all: &[u32; BATCH]| all.as_chunks::<8>().0[e];
        // SAFETY: this function is compiled for AVX2.
        let poses = unsafe { Poses::load(d.poses, &part(&self.surfels)) };
        let rays = part(&self.rays).map(|ray| &d.rays[ray as usize]);
        let [x, y, z, t_max] = columns::<4, _>(&rays);
        let local = to_local(&[x, y, z], &poses.normal);
        let [u, v] = hemisphere(&[local[0], local[1], positive(local[2])]);
        let side = _mm256_set1_ps(d.side as f32);
        let last = _mm256_set1_ps(d.side as f32 - 1.0);
        // Zero for what is not a number.
        let at = |c| _mm256_cvttps_epi32(_mm256_min_ps(positive(_mm256_mul_ps(c, side)), last));
        let texel = _mm256_add_epi32(
            _mm256_mullo_epi32(at(v), _mm256_set1_epi32(d.side as i32)),
            at(u),
        );
        let none = _mm256_cmp_ps::<_CMP_LE_OQ>(t_max, _mm256_setzero_ps());
        let height = dot(&[x, y, z], &poses.across());
        let below = _mm256_cmp_ps::<_CMP_LT_OQ>(height, _mm256_setzero_ps());
        let none = _mm256_or_ps(none, below);
        let nowhere = _mm256_set1_epi32(NOWHERE as i32);
        *texels = stored_words(_mm256_blendv_epi8(
            texel,
            nowhere,
            _mm256_castps_si256(none),
        ));
        let t = loaded(&part(&self.hits).map(|hit| d.hits[hit as usize].t));
        let diameter = _mm256_mul_ps(_mm256_set1_ps(2.0), poses.radius);
        // The second operand is taken where the first is not a number.
        *distances = stored(_mm256_min_ps(
            _mm256_div_ps(t, diameter),
            _mm256_set1_ps(FARTHEST),
        ));
        let settles = _mm256_set1_ps(DEPTH_SETTLES);
        let samples = loaded(&self.samples.as_chunks::<8>().0[e]);
        let share = _mm256_div_ps(settles, _mm256_add_ps(settles, samples));
        *blends = stored(_mm256_max_ps(_mm256_set1_ps(d.least), share));
    }
}

/// Stands for the texel of a ray that teaches nothing.
const NOWHERE: u32 = u32::MAX;

/// [`crate::stages::update_depth::learn`], both moments at once.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn learn(texel: u32, t: f32, blend: f32) -> u32 {
    let new = _mm_setr_ps(t, t * t, 0.0, 0.0);
    let steps = _mm_cvtepi32_ps(_mm_cvtepu16_epi32(_mm_cvtsi32_si128(texel as i32)));
    let old = _mm_mul_ps(steps, _mm_set1_ps(MOMENT_SCALE));
    let change = _mm_mul_ps(_mm_sub_ps(new, old), _mm_set1_ps(blend));
    let unknown = _mm_set1_epi32(-i32::from(!is_known(texel)));
    let moments = _mm_blendv_ps(_mm_add_ps(old, change), new, _mm_castsi128_ps(unknown));
    let moments = _mm_max_ps(moments, _mm_setr_ps(KNOWN.x, KNOWN.y, 0.0, 0.0));
    // Not below zero, so that truncation rounds down; zero for what is not a number.
    let unit = _mm_min_ps(_mm_max_ps(moments, _mm_setzero_ps()), _mm_set1_ps(1.0));
    let steps = _mm_add_ps(_mm_mul_ps(unit, _mm_set1_ps(65_535.0)), _mm_set1_ps(0.5));
    let words = _mm_cvttps_epi32(steps);
    _mm_cvtsi128_si32(_mm_packus_epi32(words, words)) as u32
}
