//! Rays into irradiance, eight surfels at a time: [`crate::stages::integrate::integrate_each`], operation for operation.
#![allow(unsafe_code)]
#[cfg(test)]
mod tests;

use std::arch::x86_64::*;
use std::f32::consts::PI;
use std::ops::Range;

use super::Avx2;
use super::lanes::{
    Lanes3, all_lanes, columns, difference, either, element, for_lanes, inverted, larger,
    loaded_words, luminance, rows, scaled, sum,
};
use super::lookup::cells::Cells;
use crate::data::{ClampedLight, Neighbours, SurfelIrradiance, SurfelLight, SurfelPose};
use crate::shared::{estimator, lookup, requests, sharing};
use crate::stages::integrate::{Integrated, Rays, integrate_each};
use glam::Vec4;

/// Same as [`integrate_each`].
#[inline]
pub fn integrate(
    rays: &Rays<'_>,
    range: Range<usize>,
    known: impl Fn(usize) -> (SurfelIrradiance, Neighbours),
    set: impl FnMut(usize, Integrated),
) {
    match Avx2::detect() {
        // The clamp is off, but where it is asked for.
        // SAFETY: there is a proof that the processor has the features.
        Some(Avx2 { .. }) if rays.settings.clamp == 0 => unsafe {
            integrate_wide(rays, range, known, set)
        },
        _ => super::run(
            #[inline(always)]
            || integrate_each(rays, range, known, set),
        ),
    }
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn integrate_wide(
    rays: &Rays<'_>,
    range: Range<usize>,
    known: impl Fn(usize) -> (SurfelIrradiance, Neighbours),
    mut set: impl FnMut(usize, Integrated),
) {
    for first in range.clone().step_by(8) {
        // The last eight are filled up with the last of all.
        let ids: [usize; 8] = std::array::from_fn(|lane| (first + lane).min(range.end - 1));
        let [x, y, z, radius] = columns::<0, SurfelPose>(&ids.map(|i| &rays.poses[i]));
        let lives = _mm256_cmp_ps::<_CMP_NLE_UQ>(radius, _mm256_setzero_ps());
        let lives = _mm256_movemask_ps(lives) as u32 & first_lanes(range.end - first);
        if lives == 0 {
            continue;
        }
        let known = ids.map(&known);
        let mut states = known.map(|(state, _)| state);
        let mut counts = [0; 8];
        let mut sums = [Vec4::ZERO; 8];
        for_lanes(lives, |lane| {
            let (first, last) = requests::range(rays.spans[ids[lane]]);
            counts[lane] = last - first;
            let radiance = &rays.radiance[first as usize..last as usize];
            sums[lane] = radiance.iter().fold(Vec4::ZERO, |sum, &ray| sum + ray);
        });
        let counts = loaded_words(&counts);
        let none = _mm256_cmpeq_epi32(counts, _mm256_setzero_si256());
        let learns = inverted(_mm256_castsi256_ps(none));
        let learning = _mm256_movemask_ps(learns) as u32;
        let number = rays.frame.number;
        let cells = Cells::of(&[x, y, z], rays.grid);
        let mut forgetting = 0;
        for_lanes(lives, |lane| {
            let forget = rays.forget[cells.cell[lane] as usize];
            if forget.x > 0.0 {
                forgetting |= 1 << lane;
                if learning >> lane & 1 != 0 {
                    states[lane] = estimator::forget(&states[lane], forget.x, forget.y, number);
                }
            }
        });
        let before = State::of(&states);
        let mut after = before;
        if learning != 0 {
            let n = _mm256_cvtepi32_ps(counts);
            let [r, g, b, _] = columns::<0, _>(&std::array::from_fn(|lane| &sums[lane]));
            let mean = scaled(&[r, g, b], _mm256_div_ps(all_lanes(PI), n));
            let faintest = all_lanes(rays.settings.faintest);
            let faint = _mm256_cmp_ps::<_CMP_LT_OQ>(luminance(&mean), faintest);
            let sample = either(faint, &[_mm256_setzero_ps(); 3], &mean);
            let taught = before.with(&sample, counts, number);
            after = before.or(&taught, learns);
        }
        let told = std::array::from_fn(|lane| &known[lane].1);
        let light = after.light(number, &told);
        let turns = ids.map(|i| u32::from(sharing::is_turn(i as u32, number)));
        let turns = (0..8).fold(0, |mask, lane| mask | turns[lane] << lane);
        let asking = turns | after.is_young(number) | forgetting;
        let [a, b, c] = [after.mean_samples(), after.short_since(), after.rest()].map(|c| rows(&c));
        for lane in 0..8 {
            if lives >> lane & 1 == 0 {
                continue;
            }
            let irradiance: SurfelIrradiance = element([a[lane], b[lane], c[lane]]);
            let learned = (learning >> lane & 1 != 0).then_some(irradiance);
            let light: SurfelLight = element([light[lane]]);
            set(
                ids[lane],
                Integrated {
                    irradiance: learned,
                    light,
                    asks: asking >> lane & 1 != 0,
                    clamped: ClampedLight::default(),
                },
            );
        }
    }
}

/// A bit for each of the first `count` lanes.
#[inline]
fn first_lanes(count: usize) -> u32 {
    (1 << count.min(8)) - 1
}

/// [`SurfelIrradiance`] of eight surfels.
#[derive(Clone, Copy)]
struct State {
    mean: Lanes3,
    samples: __m256i,
    short_mean: Lanes3,
    since: __m256i,
    variance: __m256,
    short_noise: __m256,
    drawn: __m256i,
}

/// Lanes in which the first of two whole numbers below 2^31 is larger.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn is_more(a: __m256i, b: __m256i) -> __m256 {
    _mm256_castsi256_ps(_mm256_cmpgt_epi32(a, b))
}

impl State {
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn of(states: &[SurfelIrradiance; 8]) -> Self {
        let states = std::array::from_fn(|lane| &states[lane]);
        let [r, g, b, samples] = columns::<0, _>(&states);
        let [sr, sg, sb, since] = columns::<4, _>(&states);
        let [variance, short_noise, drawn, _] = columns::<8, _>(&states);
        State {
            mean: [r, g, b],
            samples: _mm256_castps_si256(samples),
            short_mean: [sr, sg, sb],
            since: _mm256_castps_si256(since),
            variance,
            short_noise,
            drawn: _mm256_castps_si256(drawn),
        }
    }

    /// The other one in the lanes of a mask.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn or(&self, other: &Self, mask: __m256) -> Self {
        let words = |a, b| _mm256_blendv_epi8(a, b, _mm256_castps_si256(mask));
        State {
            mean: either(mask, &other.mean, &self.mean),
            samples: words(self.samples, other.samples),
            short_mean: either(mask, &other.short_mean, &self.short_mean),
            since: words(self.since, other.since),
            variance: _mm256_blendv_ps(self.variance, other.variance, mask),
            short_noise: _mm256_blendv_ps(self.short_noise, other.short_noise, mask),
            drawn: words(self.drawn, other.drawn),
        }
    }

    /// [`estimator::update`] without the clamp.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn with(&self, sample: &Lanes3, rays: __m256i, frame: u32) -> Self {
        const MOST: u32 = estimator::MOST_SAMPLES;
        const { assert!(MOST.is_power_of_two()) };
        let (one, n) = (all_lanes(1.0), _mm256_cvtepi32_ps(rays));
        let drawn = _mm256_add_epi32(self.drawn, rays);
        let half = _mm256_set1_epi32((MOST / 2) as i32);
        let again = _mm256_and_si256(drawn, _mm256_set1_epi32((MOST / 2 - 1) as i32));
        let past = is_more(drawn, _mm256_set1_epi32((MOST - 1) as i32));
        let again = _mm256_add_epi32(half, again);
        let drawn = _mm256_blendv_epi8(drawn, again, _mm256_castps_si256(past));
        let level = luminance(sample);
        let squared = _mm256_mul_ps(level, level);
        let first = State {
            mean: *sample,
            samples: rays,
            short_mean: *sample,
            since: _mm256_set1_epi32(frame as i32),
            variance: _mm256_mul_ps(n, squared),
            short_noise: squared,
            drawn,
        };
        let confidence = _mm256_div_ps(n, all_lanes(estimator::FULL_CONFIDENCE));
        let confidence = _mm256_min_ps(confidence, one);
        let samples = _mm256_cvtepi32_ps(self.samples);
        let weight = _mm256_mul_ps(n, self.recency(samples, frame));
        let share = _mm256_div_ps(weight, _mm256_add_ps(samples, weight));
        let shortest = _mm256_mul_ps(all_lanes(estimator::SHORT_BLEND), confidence);
        let blend = larger(shortest, share);
        let rest = _mm256_sub_ps(one, blend);
        let delta = _mm256_sub_ps(level, luminance(&self.short_mean));
        let moved = |mean: &Lanes3, by| sum(mean, &scaled(&difference(sample, mean), by));
        let spread = _mm256_mul_ps(_mm256_mul_ps(delta, delta), rest);
        let spread = _mm256_mul_ps(n, spread);
        let follows = larger(share, _mm256_mul_ps(all_lanes(0.5), blend));
        let apart = _mm256_mul_ps(_mm256_sub_ps(spread, self.variance), follows);
        let variance = _mm256_add_ps(self.variance, apart);
        let kept = _mm256_mul_ps(_mm256_mul_ps(rest, rest), self.short_noise);
        let added = _mm256_mul_ps(_mm256_mul_ps(blend, blend), _mm256_div_ps(variance, n));
        let next = State {
            mean: moved(&self.mean, share),
            samples: _mm256_min_epi32(
                _mm256_add_epi32(self.samples, rays),
                _mm256_set1_epi32(MOST as i32),
            ),
            short_mean: moved(&self.short_mean, blend),
            since: self.since,
            variance,
            short_noise: _mm256_add_ps(kept, added),
            drawn,
        };
        let is_first = _mm256_cmpeq_epi32(self.samples, _mm256_setzero_si256());
        next.or(&first, _mm256_castsi256_ps(is_first))
    }

    /// Frames since it began, or began anew, as far as that matters.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn age(&self, frame: u32) -> __m256i {
        const LONG: i32 = 1 << 20;
        let age = _mm256_sub_epi32(_mm256_set1_epi32(frame as i32), self.since);
        _mm256_min_epu32(age, _mm256_set1_epi32(LONG))
    }

    /// Weight of a ray in the long mean, over its share in a plain one.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn recency(&self, samples: __m256, frame: u32) -> __m256 {
        let age = self.age(frame);
        let younger = |than: u32| is_more(_mm256_set1_epi32(than as i32), age);
        let error = _mm256_mul_ps(all_lanes(estimator::QUIET), luminance(&self.mean));
        let most = _mm256_mul_ps(samples, _mm256_mul_ps(error, error));
        let quiet = _mm256_cmp_ps::<_CMP_LE_OQ>(self.variance, most);
        let unsettled = _mm256_or_ps(younger(estimator::SETTLED), quiet);
        let recency = _mm256_blendv_ps(
            all_lanes(estimator::SETTLED_RECENCY),
            all_lanes(estimator::RECENCY),
            unsettled,
        );
        let few = is_more(
            _mm256_set1_epi32(estimator::PLAIN_MEAN as i32),
            self.samples,
        );
        let recency = _mm256_blendv_ps(recency, all_lanes(1.0), few);
        let forgot = is_more(self.drawn, self.samples);
        let anew = _mm256_and_ps(forgot, younger(estimator::ANEW));
        _mm256_blendv_ps(recency, all_lanes(estimator::ANEW_RECENCY), anew)
    }

    /// A bit for each that has had no rays, or began but lately.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn is_young(&self, frame: u32) -> u32 {
        let none = _mm256_cmpeq_epi32(self.samples, _mm256_setzero_si256());
        let fresh = is_more(_mm256_set1_epi32(sharing::FRESH as i32), self.age(frame));
        _mm256_movemask_ps(_mm256_or_ps(_mm256_castsi256_ps(none), fresh)) as u32
    }

    /// [`sharing::light`], a row each.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn light(&self, frame: u32, told: &[&Neighbours; 8]) -> [__m128; 8] {
        let age = _mm256_add_ps(_mm256_cvtepi32_ps(self.age(frame)), all_lanes(1.0));
        let own = _mm256_div_ps(age, all_lanes(lookup::TRUSTED_AFTER));
        let own = _mm256_min_ps(own, all_lanes(1.0));
        let [r, g, b, packed] = columns::<0, _>(told);
        let packed = _mm256_castps_si256(packed);
        let steps = _mm256_and_si256(packed, _mm256_set1_epi32(0xff));
        let trust = _mm256_div_ps(_mm256_cvtepi32_ps(steps), all_lanes(sharing::TRUST_STEPS));
        const FIRST: i32 = 31 - sharing::RAYS_BITS as i32;
        let first = _mm256_and_si256(
            _mm256_srli_epi32::<8>(packed),
            _mm256_set1_epi32((1 << sharing::RAYS_BITS) - 1),
        );
        let worth = _mm256_castsi256_ps(_mm256_slli_epi32::<FIRST>(first));
        // A surfel of no rays says what its neighbours do.
        let some = is_more(self.samples, _mm256_setzero_si256());
        let samples = _mm256_cvtepi32_ps(self.samples);
        let share = _mm256_div_ps(worth, _mm256_add_ps(worth, samples));
        let towards = difference(&[r, g, b], &self.mean);
        let mixed = sum(&self.mean, &scaled(&towards, share));
        let mixed = either(some, &mixed, &[r, g, b]);
        let mixed_trust = _mm256_add_ps(own, _mm256_mul_ps(_mm256_sub_ps(trust, own), share));
        let mixed_trust = _mm256_blendv_ps(trust, mixed_trust, some);
        let alone = _mm256_cmp_ps::<_CMP_EQ_OQ>(trust, _mm256_setzero_ps());
        let [r, g, b] = either(alone, &self.mean, &mixed);
        let alone_trust = _mm256_and_ps(own, some);
        let trust = _mm256_blendv_ps(mixed_trust, alone_trust, alone);
        rows(&[r, g, b, trust])
    }

    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn mean_samples(&self) -> [__m256; 4] {
        let [r, g, b] = self.mean;
        [r, g, b, _mm256_castsi256_ps(self.samples)]
    }

    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn short_since(&self) -> [__m256; 4] {
        let [r, g, b] = self.short_mean;
        [r, g, b, _mm256_castsi256_ps(self.since)]
    }

    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn rest(&self) -> [__m256; 4] {
        let drawn = _mm256_castsi256_ps(self.drawn);
        [self.variance, self.short_noise, drawn, _mm256_setzero_ps()]
    }
}
