//! Lights for points, eight at a time: [`crate::stages::sample_lights::sample_each`], operation for operation.
#![allow(unsafe_code)]
#[cfg(test)]
mod tests;

use std::arch::x86_64::*;
use std::ops::Range;

use super::Avx2;
use super::directions::{start, unpack};
use super::hashes::{hash3, unit};
use super::lanes::{
    Lanes3, columns, difference, divided, dot, either, inverted, is_word, loaded_words, negated,
    positive, scaled, store_columns, store_rows, stored_words,
};
use crate::data::{Frame, Light, LightSample, NONE, Ray, SurfacePoint};
use crate::stages::sample_lights::{REACH, sample_each};
use bytemuck::Zeroable;

/// Same as [`sample_each`].
#[inline]
pub fn sample_lights(
    frame: &Frame,
    points: &[SurfacePoint],
    lights: &[Light],
    range: Range<usize>,
    set: impl FnMut(usize, Ray, LightSample),
) {
    match Avx2::detect() {
        // SAFETY: there is a proof that the processor has the features.
        Some(Avx2 { .. }) if frame.lights > 0 => unsafe {
            sample_wide(frame, points, lights, range, set)
        },
        _ => sample_each(frame, points, lights, range, set),
    }
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn sample_wide(
    frame: &Frame,
    points: &[SurfacePoint],
    lights: &[Light],
    range: Range<usize>,
    mut set: impl FnMut(usize, Ray, LightSample),
) {
    if range.is_empty() {
        return;
    }
    let each = frame.lights_per_point.max(1);
    let all_lights = frame.lights <= each;
    let weight = match all_lights {
        true => 1.0,
        false => frame.lights as f32 / each as f32,
    };
    let mut point = range.start / each as usize;
    let mut choice = range.start as u32 % each;
    let last = (range.end - 1) / each as usize;
    let zero = _mm256_setzero_ps();
    // The same lights often follow: those of every eight where there is only one.
    let mut held = [0; 8];
    let mut eight = Lights::load(&[&lights[0]; 8]);
    let mut rays = [Ray::zeroed(); 8];
    let mut samples = [LightSample::zeroed(); 8];
    for first in range.clone().step_by(8) {
        let mut at = [last; 8];
        let mut choices = [0; 8];
        for (at, to) in at.iter_mut().zip(&mut choices) {
            (*at, *to) = (point.min(last), choice);
            choice += 1;
            if choice == each {
                (choice, point) = (0, point + 1);
            }
        }
        let at = at.map(|point| &points[point]);
        let choices = loaded_words(&choices);
        let [x, y, z, offset] = columns::<0, _>(&at);
        let [geometric, shading, _, _] = columns::<4, _>(&at);
        let [_, _, _, node] = columns::<8, _>(&at);
        let position = [x, y, z];
        let within = _mm256_min_epu32(choices, _mm256_set1_epi32(frame.lights as i32 - 1));
        let surface = inverted(is_word(_mm256_castps_si256(node), NONE));
        let chosen = _mm256_castsi256_ps(_mm256_cmpeq_epi32(within, choices));
        let index = stored_words(match all_lights {
            true => within,
            false => drawn(frame, each, &position, choices),
        });
        if index != held {
            eight = Lights::load(&index.map(|i| &lights[i as usize]));
            held = index;
        }
        let (irradiance, to, distance) = eight.unshadowed(&position, &unpack(shading));
        let shines = |c| _mm256_cmp_ps::<_CMP_GT_OQ>(c, zero);
        let [r, g, b] = irradiance;
        let some = _mm256_or_ps(_mm256_or_ps(shines(r), shines(g)), shines(b));
        let lit = _mm256_and_ps(_mm256_and_ps(surface, chosen), some);
        let or_zero = |c| _mm256_and_ps(c, lit);
        let [x, y, z] = start(&position, &unpack(geometric), offset, 0.0, &to).map(or_zero);
        let up = _mm256_blendv_ps(_mm256_set1_ps(1.0), to[2], lit);
        let t_max = or_zero(_mm256_mul_ps(distance, _mm256_set1_ps(REACH)));
        store_rows(
            &mut rays,
            &[x, y, z, zero],
            &[or_zero(to[0]), or_zero(to[1]), up, t_max],
        );
        let [r, g, b] = scaled(&irradiance, _mm256_set1_ps(weight)).map(or_zero);
        store_columns::<0, _>(&mut samples, &[r, g, b, zero]);
        let pairs = rays.iter().zip(&samples);
        for (i, (&ray, &sample)) in (first..range.end).zip(pairs) {
            set(i, ray, sample);
        }
    }
}

/// Lights that points draw from the strata of the list.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn drawn(frame: &Frame, each: u32, position: &Lanes3, choice: __m256i) -> __m256i {
    use crate::shared::hash;
    let [x, y, z] = position.map(|c| _mm256_castps_si256(c));
    let of_frame = _mm256_set1_epi32(hash::hash2(frame.number, frame.seed) as i32);
    let bits = hash3(hash3(x, y, z), of_frame, choice);
    let u = unit(bits);
    let share = _mm256_div_ps(
        _mm256_add_ps(_mm256_cvtepi32_ps(choice), u),
        _mm256_set1_ps(each as f32),
    );
    // There are fewer than 2^31 lights, more would not fit any memory.
    let stratum = _mm256_mul_ps(share, _mm256_set1_ps(frame.lights as f32));
    _mm256_min_epu32(
        _mm256_cvttps_epi32(stratum),
        _mm256_set1_epi32(frame.lights as i32 - 1),
    )
}

/// Eight lights, in columns.
struct Lights {
    position: Lanes3,
    intensity: Lanes3,
    direction: Lanes3,
    cos_outer: __m256,
    cos_inner: __m256,
    directional: __m256,
    spot: __m256,
    /// Some are not directional.
    any_near: bool,
}

impl Lights {
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn load(lights: &[&Light; 8]) -> Self {
        let [x, y, z, kind] = columns::<0, _>(lights);
        let [r, g, b, cos_outer] = columns::<4, _>(lights);
        let [dx, dy, dz, cos_inner] = columns::<8, _>(lights);
        let kind = _mm256_castps_si256(kind);
        let directional = is_word(kind, 0);
        Lights {
            position: [x, y, z],
            intensity: [r, g, b],
            direction: [dx, dy, dz],
            cos_outer,
            cos_inner,
            directional,
            spot: is_word(kind, 2),
            any_near: _mm256_movemask_ps(directional) != 0xff,
        }
    }

    /// [`crate::stages::sample_lights::unshadowed`]; the direction and the distance only where it is above zero.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn unshadowed(&self, position: &Lanes3, n: &Lanes3) -> (Lanes3, Lanes3, __m256) {
        let opposite = self.direction.map(|c| negated(c));
        let far = _mm256_set1_ps(f32::MAX);
        if !self.any_near {
            let cosine = positive(dot(n, &opposite));
            return (scaled(&self.intensity, cosine), opposite, far);
        }
        let d = difference(&self.position, position);
        let squared = dot(&d, &d);
        let distance = _mm256_sqrt_ps(squared);
        let to = either(self.directional, &opposite, &divided(&d, distance));
        let cosine = positive(dot(n, &to));
        let falloff = _mm256_div_ps(cosine, squared);
        let share = self.cone_share(&to);
        let in_cone = _mm256_mul_ps(falloff, _mm256_mul_ps(share, share));
        let falloff = _mm256_blendv_ps(falloff, in_cone, self.spot);
        let inside = _mm256_cmp_ps::<_CMP_LE_OQ>(squared, _mm256_setzero_ps());
        let falloff = _mm256_andnot_ps(inside, falloff);
        let share = _mm256_blendv_ps(falloff, cosine, self.directional);
        let distance = _mm256_blendv_ps(distance, far, self.directional);
        (scaled(&self.intensity, share), to, distance)
    }

    /// Where a direction lies between the cones of a spot.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn cone_share(&self, to: &Lanes3) -> __m256 {
        let width = _mm256_max_ps(
            _mm256_sub_ps(self.cos_inner, self.cos_outer),
            _mm256_set1_ps(1e-7),
        );
        let cosine = negated(dot(&self.direction, to));
        let share = _mm256_div_ps(_mm256_sub_ps(cosine, self.cos_outer), width);
        // The second operand is taken where one is not a number, as `clamp` leaves it.
        _mm256_min_ps(
            _mm256_set1_ps(1.0),
            _mm256_max_ps(_mm256_setzero_ps(), share),
        )
    }
}
