//! Sixteen entries of lists at a time, where the processor has AVX-512.
#![allow(unsafe_code)]
use std::arch::x86_64::*;

use super::candidates::Candidates;

use crate::shared::bounds::{FAR, MARGIN, RADIUS_AT};
use crate::shared::lists::List;

/// Same as [`pairs::collect`](super::pairs::collect), which must not go on from where this one stopped: that may lie behind the end of
/// the list.
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512vnni,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn collect(
    near: &mut Candidates,
    lists: &[List<'_>],
    (first, mut start): (usize, usize),
) -> Option<(usize, usize)> {
    let mut line = near.filling();
    for (at, list) in lists.iter().enumerate().skip(first) {
        let here = _mm512_set1_epi32(at as i32);
        let place = _mm512_set1_epi32(list.place as i32);
        while start < list.ids.len() {
            let (bounds, there) = sixteen(&list.bounds[start..]);
            let (ids, _) = sixteen(&list.ids[start..]);
            line.append_sixteen(may_reach(bounds, place) & there, ids, here);
            start += 16;
            if line.is_full() {
                return Some((at, start));
            }
        }
        start = 0;
    }
    None
}

/// The first sixteen entries, and a mask of those that are there; zero stands for the others.
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512vnni,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn sixteen(entries: &[u32]) -> (__m512i, u16) {
    let there = _bzhi_u32(u16::MAX.into(), entries.len().min(16) as u32) as u16;
    // SAFETY: the load reads those words of the slice that the mask names, and needs no alignment.
    let loaded = unsafe { _mm512_maskz_loadu_epi32(there, entries.as_ptr().cast()) };
    (loaded, there)
}

/// A bit for each surfel that may reach a point, of which all lanes have the place: [`crate::shared::bounds::may_reach`].
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512vnni,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn may_reach(bounds: __m512i, place: __m512i) -> u16 {
    let apart = _mm512_abs_epi8(_mm512_sub_epi8(bounds, place));
    let margin = _mm512_set1_epi32((MARGIN << RADIUS_AT) as i32);
    // 128 becomes 127 as well: the signed bytes of the products have no more.
    let far = _mm512_set1_epi8(FAR as i8);
    let bytes = _mm512_min_epu8(_mm512_add_epi8(apart, margin), far);
    let always = _mm512_cmpge_epi32_mask(bytes, _mm512_set1_epi32((FAR << RADIUS_AT) as i32));
    // The squares of three bytes less that of the highest one.
    const RADII: u64 = 0x8888_8888_8888_8888;
    let signed = _mm512_mask_sub_epi8(bytes, RADII, _mm512_setzero_si512(), bytes);
    let over = _mm512_dpbusd_epi32(_mm512_setzero_si512(), bytes, signed);
    always | _mm512_cmple_epi32_mask(over, _mm512_setzero_si512())
}

#[cfg(test)]
mod tests {
    use super::super::pairs::{self, FULL};
    use super::*;
    use crate::shared::{bounds, hash};
    use crate::simd::Avx2;
    use crate::simd::x86::Avx512;

    /// A line is filled from lists, and emptied, until they end.
    fn pairs_by(
        mut collect: impl FnMut(&mut Candidates, (usize, usize)) -> Option<(usize, usize)>,
    ) -> Vec<(u32, u32)> {
        let (mut near, mut pairs) = (Candidates::new(), Vec::new());
        let mut from = Some((0, 0));
        while let Some(at) = from {
            from = collect(&mut near, at);
            near.take(|surfels, points, count| {
                pairs.extend(surfels.into_iter().zip(points).take(count));
            });
        }
        pairs
    }

    /// Lists of every length up to a few vectors, and so long that the line is full more than once; bounds near the point and
    /// anywhere, of any radius.
    #[test]
    fn sixteen_at_a_time_are_those_that_scalar_bounds_let_through() {
        let Some(_) = Avx2::detect() else {
            eprintln!("not run: this processor has no AVX2");
            return;
        };
        let avx512 = Avx512::detect();
        if avx512.is_none() {
            eprintln!("eight at a time only: this processor has no AVX-512");
        }
        let mut full = 0;
        for case in 0..600 {
            let random = |i: u32, k| hash::hash3(case, i, k);
            let place = random(0, 0) & 0x00ff_ffff;
            let bound = |i: u32| match random(i, 1) % 3 {
                0 => random(i, 2) & 0x7fff_ffff,
                1 => place ^ (random(i, 3) & 0x000f_0f0f) ^ (random(i, 4) & 0x0f00_0000),
                _ => place ^ (random(i, 5) & 0x7f03_0303),
            };
            let length = match case % 3 {
                0 => 1200,
                _ => case,
            };
            let bounds: Vec<u32> = (0..length).map(bound).collect();
            let ids: Vec<u32> = (0..length).map(|i| random(i, 6)).collect();
            // Parts of any alignment, and an empty one.
            let cut = (random(1, 7) % (length + 1)) as usize;
            let part = |range: std::ops::Range<usize>| List {
                ids: &ids[range.clone()],
                bounds: &bounds[range],
                place,
            };
            let lists = [part(0..cut), part(cut..cut), part(cut..length as usize)];
            let expected: Vec<(u32, u32)> = (0..)
                .zip(&lists)
                .flat_map(|(at, list)| {
                    let both = list.ids.iter().zip(list.bounds);
                    both.filter(|&(_, &b)| bounds::may_reach(b, place, 1))
                        .map(move |(&id, _)| (id, at))
                })
                .collect();
            full += usize::from(expected.len() > FULL);
            // SAFETY: the processor has AVX2.
            let eight = pairs_by(|near, from| unsafe { pairs::collect::<1>(near, &lists, from) });
            assert_eq!(eight, expected, "case {case}");
            if avx512.is_some() {
                // SAFETY: there is a proof that the processor has the features.
                let sixteen = pairs_by(|near, from| unsafe { collect(near, &lists, from) });
                assert_eq!(sixteen, expected, "case {case}");
            }
        }
        assert!(full > 50, "{full} lists that are longer than a line");
    }
}
