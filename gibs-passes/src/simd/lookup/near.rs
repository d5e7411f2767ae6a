//! Weights of the surfels around several surfels, within several of their radii and with the depth functions of both.
#![allow(unsafe_code)]
use std::arch::x86_64::*;

use super::super::lanes::{loaded, stored};
use super::super::prefetch;
use super::above_zero;
use super::batch::Batch;
use super::candidates::Candidates;
use super::pairs::{Line, collect};
use super::poses::Poses;
use crate::shared::lists::Surfels;
use crate::shared::lookup::Owns;

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn neighbours<const REACH: u32>(
    owns: &Owns<'_>,
    s: &Surfels<'_>,
    soon: impl Fn(usize),
    wanted: impl Fn(usize) -> bool,
    mut each: impl FnMut(usize, usize, f32),
) {
    for &own in owns.ids.iter().flatten() {
        prefetch(s.depths.texels(), s.depths.first(own));
    }
    let mut batch = Batch::new();
    batch.around(owns, s);
    let (mut near, mut weighty) = (Candidates::new(), Line::new());
    let mut from = Some((0, 0));
    while let Some(at) = from {
        from = collect::<REACH>(&mut near, &batch.lists, at);
        weigh::<REACH>(&mut near, &mut weighty, &batch, s);
        for id in weighty.surfels() {
            soon(id);
            prefetch(s.depths.texels(), s.depths.first(id));
        }
        finish(&mut weighty, owns, &batch, s, |at, id, weight| {
            if wanted(id) {
                each(at, id, weight);
            }
        });
    }
}

/// Weights before the depth functions: those of the candidates that have any go into a line, which is empty.
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn weigh<const REACH: u32>(
    near: &mut Candidates,
    weighty: &mut Line,
    batch: &Batch<'_>,
    s: &Surfels<'_>,
) {
    for id in near.surfels() {
        prefetch(s.poses, id);
    }
    near.take(
        #[inline(always)]
        |surfels, points, count| {
            // SAFETY: this function is compiled for AVX2; the loads read eight words each and need no alignment.
            unsafe {
                let poses = Poses::load(s.poses, &surfels);
                let owns = Poses::load(&batch.points, &points);
                let to = poses.to(&owns.position);
                let nearness = poses.reaching(REACH as f32).nearness(&to);
                let weight = _mm256_mul_ps(nearness, poses.alignment(&owns.normal));
                weighty.append(
                    above_zero(weight, count),
                    _mm256_loadu_si256(surfels.as_ptr().cast()),
                    _mm256_loadu_si256(points.as_ptr().cast()),
                    weight,
                );
            }
        },
    );
}

/// Weights with both depth functions, for `each` to take; empties the line.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn finish(
    weighty: &mut Line,
    owns: &Owns<'_>,
    batch: &Batch<'_>,
    s: &Surfels<'_>,
    mut each: impl FnMut(usize, usize, f32),
) {
    weighty.take(
        #[inline(always)]
        |pairs| {
            let mut weights = pairs.weights;
            if !s.depths.is_empty() {
                let own_ids = pairs
                    .points
                    .map(|at| owns.ids[at as usize].unwrap_or(0) as u32);
                // SAFETY: this function is compiled for AVX2.
                weights = unsafe {
                    let poses = Poses::load(s.poses, &pairs.surfels);
                    let own_poses = Poses::load(&batch.points, &pairs.points);
                    let share = poses.visibility(s.depths, &pairs.surfels, &own_poses.position);
                    let weight = _mm256_mul_ps(loaded(&weights), share);
                    let own_share = own_poses.visibility(s.depths, &own_ids, &poses.position);
                    stored(_mm256_mul_ps(weight, own_share))
                };
            }
            let all = pairs.points.iter().zip(&pairs.surfels).zip(weights);
            for ((&at, &id), weight) in all.take(pairs.count) {
                each(at as usize, id as usize, weight);
            }
        },
    );
}
