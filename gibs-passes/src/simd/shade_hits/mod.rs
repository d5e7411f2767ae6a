//! Radiance along rays, eight at a time: [`crate::stages::shade_hits::shade_each`], operation for operation.
#![allow(unsafe_code)]
#[cfg(test)]
mod tests;

use std::arch::x86_64::*;
use std::f32::consts::FRAC_1_PI;
use std::ops::Range;

use super::Avx2;
use super::hashes::{pcg, unit};
use super::lanes::{
    Lanes3, columns, divided, either, for_lanes, has_any, inverted, is_word, loaded, magnitude,
    positive, scaled, store_columns, store_rows, stored, sum,
};
use crate::data::{NONE, Path, SurfacePoint};
use crate::shared::{environment, surface};
use crate::stages::shade_hits::{Hits, Shaded, factor, shade_each};
use bytemuck::Zeroable;
use glam::Vec4;

/// Same as [`shade_each`].
#[inline]
pub fn shade_hits(
    hits: &Hits<'_>,
    range: Range<usize>,
    path: impl Fn(usize) -> Path,
    set: impl FnMut(usize, Shaded),
) {
    match Avx2::detect() {
        // SAFETY: there is a proof that the processor has the features.
        Some(Avx2 { .. }) => unsafe { shade_wide(hits, range, path, set) },
        None => shade_each(hits, range, path, set),
    }
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn shade_wide(
    hits: &Hits<'_>,
    range: Range<usize>,
    path: impl Fn(usize) -> Path,
    mut set: impl FnMut(usize, Shaded),
) {
    for first in range.clone().step_by(8) {
        // The last eight are filled up with the last of all.
        let ids: [usize; 8] = std::array::from_fn(|lane| (first + lane).min(range.end - 1));
        let paths = ids.map(&path);
        let points = ids.map(|i| &hits.points[i]);
        let eight = shaded(hits, &ids, &paths, &points);
        for (lane, i) in (first..range.end).take(8).enumerate() {
            let goes_on = eight.goes_on >> lane & 1 != 0;
            let shaded = Shaded {
                root: paths[lane].root,
                added: eight.added[lane],
                goes_on: goes_on.then(|| eight.next[lane]),
            };
            set(i, shaded);
        }
    }
}

/// What comes of eight segments.
struct Eight {
    added: [Vec4; 8],
    /// A bit for each path that goes on.
    goes_on: u32,
    /// Those that do.
    next: [Path; 8],
}

#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn shaded(
    hits: &Hits<'_>,
    ids: &[usize; 8],
    paths: &[Path; 8],
    points: &[&SurfacePoint; 8],
) -> Eight {
    let (zero, one) = (_mm256_setzero_ps(), _mm256_set1_ps(1.0));
    let refs: [&Path; 8] = std::array::from_fn(|lane| &paths[lane]);
    let [tr, tg, tb, root] = columns::<0, _>(&refs);
    let [seed, surfel, cosine, density] = columns::<4, _>(&refs);
    let [_, _, albedo_rg, albedo_b_flags] = columns::<4, _>(points);
    let [er, eg, eb, node] = columns::<8, _>(points);
    let gathered = ids.map(|i| &hits.gathered[i]);
    let [ir, ig, ib, weight] = columns::<0, _>(&gathered);
    let [ar, ag, ab, confidence] = columns::<4, _>(&gathered);
    let is_surface = inverted(is_word(_mm256_castps_si256(node), NONE));
    // What the segments count; emitters, of which there are few, one by one.
    let lobe = magnitude(density);
    let share = _mm256_div_ps(
        _mm256_mul_ps(positive(cosine), _mm256_set1_ps(FRAC_1_PI)),
        lobe,
    );
    let some = _mm256_cmp_ps::<_CMP_GT_OQ>(lobe, zero);
    let to_emitter = _mm256_cmp_ps::<_CMP_LT_OQ>(density, zero);
    let mut counts = _mm256_andnot_ps(to_emitter, _mm256_and_ps(share, some));
    let flags = _mm256_castps_si256(albedo_b_flags);
    let bright = |c| _mm256_cmp_ps::<_CMP_NEQ_UQ>(c, zero);
    let shines = _mm256_or_ps(_mm256_or_ps(bright(er), bright(eg)), bright(eb));
    // Nobody draws what is dark.
    let is_drawn = _mm256_or_ps(shines, to_emitter);
    let emitters = _mm256_and_ps(is_drawn, has_any(flags, surface::EMITTER));
    let emitters = _mm256_and_ps(emitters, is_surface);
    let emitters = _mm256_movemask_ps(emitters) as u32;
    if emitters != 0 {
        let mut each = stored(counts);
        for_lanes(emitters, |lane| {
            let ray = &hits.rays[ids[lane]];
            each[lane] = factor(hits.frame, &paths[lane], ray, points[lane]);
        });
        counts = loaded(&each);
    }
    // Surfaces.
    let part = |bits: __m256i| {
        let steps = _mm256_and_si256(bits, _mm256_set1_epi32(0xffff));
        _mm256_div_ps(_mm256_cvtepi32_ps(steps), _mm256_set1_ps(65_535.0))
    };
    let rg = _mm256_castps_si256(albedo_rg);
    let albedo = [part(rg), part(_mm256_srli_epi32::<16>(rg)), part(flags)];
    let known = match hits.ends {
        true => sum(
            &[ir, ig, ib],
            &scaled(&[ar, ag, ab], _mm256_sub_ps(one, weight)),
        ),
        false => scaled(&[ir, ig, ib], confidence),
    };
    let mut arriving = known;
    if !hits.direct.is_empty() {
        let direct = ids.map(|i| &hits.direct[i]);
        let [r, g, b, _] = columns::<0, _>(&direct);
        arriving = sum(&[r, g, b], &known);
    }
    let reflected = scaled(&albedo, _mm256_set1_ps(FRAC_1_PI));
    let product = |a: &Lanes3, b: &Lanes3| std::array::from_fn(|i| _mm256_mul_ps(a[i], b[i]));
    let mut radiance = sum(&[er, eg, eb], &product(&reflected, &arriving));
    if _mm256_movemask_ps(is_surface) != 0xff {
        radiance = either(is_surface, &radiance, &sky(hits, ids, inverted(is_surface)));
    }
    let throughput = scaled(&[tr, tg, tb], counts);
    let [r, g, b] = product(&throughput, &radiance);
    let mut added = [Vec4::ZERO; 8];
    store_columns::<0, _>(&mut added, &[r, g, b, zero]);
    // Paths that go on.
    let largest = _mm256_max_ps(_mm256_max_ps(albedo[0], albedo[1]), albedo[2]);
    let seed = pcg(_mm256_castps_si256(seed));
    let trusted = _mm256_mul_ps(weight, confidence);
    let missing = _mm256_mul_ps(_mm256_sub_ps(one, trusted), largest);
    let chosen = _mm256_cmp_ps::<_CMP_LT_OQ>(unit(seed), missing);
    let may = _mm256_and_ps(_mm256_cmp_ps::<_CMP_GT_OQ>(counts, zero), is_surface);
    let goes_on = match hits.ends {
        true => 0,
        false => _mm256_movemask_ps(_mm256_and_ps(chosen, may)) as u32,
    };
    let mut next = [Path::zeroed(); 8];
    if goes_on != 0 {
        let [r, g, b] = divided(&product(&throughput, &albedo), largest);
        let seed = _mm256_castsi256_ps(seed);
        store_rows(
            &mut next,
            &[r, g, b, root],
            &[seed, surfel, cosine, density],
        );
    }
    Eight {
        added,
        goes_on,
        next,
    }
}

/// Radiance of the sky in the lanes of a mask.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn sky(hits: &Hits<'_>, ids: &[usize; 8], mask: __m256) -> Lanes3 {
    let mut seen = [[0.0; 8]; 3];
    for_lanes(_mm256_movemask_ps(mask) as u32, |lane| {
        let side = hits.frame.environment_side;
        let direction = hits.rays[ids[lane]].direction;
        let [r, g, b] = environment::radiance(hits.environment, side, direction).to_array();
        (seen[0][lane], seen[1][lane], seen[2][lane]) = (r, g, b);
    });
    std::array::from_fn(|axis| loaded(&seen[axis]))
}
