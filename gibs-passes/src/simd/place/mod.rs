//! Surfels where they are now, eight at a time: [`crate::stages::positional_update::place_each`], operation for operation.
#![allow(unsafe_code)]
#[cfg(test)]
mod tests;

use std::arch::x86_64::*;

use super::Avx2;
use super::directions::{normalized, pack_in_steps, unpack};
use super::lanes::{
    Lanes3, all, all_lanes, all_same, columns, columns_where, difference, dot, larger, magnitudes,
    map_transposed, smaller, store_rows,
};
use crate::data::{SurfelBirth, SurfelPose, Transform};
use crate::shared::{grid, plane};
use crate::stages::positional_update::{LEAST_SHARE, View, place_each};
use bytemuck::Zeroable;

/// Same as [`place_each`].
#[inline]
pub fn place(
    view: &View<'_>,
    births: &[SurfelBirth; 8],
    transforms: &[&Transform; 8],
) -> [SurfelPose; 8] {
    match Avx2::detect() {
        // SAFETY: there is a proof that the processor has the features.
        Some(Avx2 { .. }) => unsafe { place_wide(view, births, transforms) },
        None => place_each(view, births, transforms),
    }
}

#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn place_wide(
    view: &View<'_>,
    births: &[SurfelBirth; 8],
    transforms: &[&Transform; 8],
) -> [SurfelPose; 8] {
    let births = std::array::from_fn(|lane| &births[lane]);
    let [x, y, z, _] = columns::<0, _>(&births);
    let [normal, across, _, lengths] = columns::<4, _>(&births);
    let same = all_same(transforms);
    let along = |[a, b, c, w]: [__m256; 4]| _mm256_add_ps(dot(&[a, b, c], &[x, y, z]), w);
    let position = [
        along(columns_where::<0, _>(transforms, same)),
        along(columns_where::<4, _>(transforms, same)),
        along(columns_where::<8, _>(transforms, same)),
    ];
    let to_local = [
        columns_where::<12, _>(transforms, same),
        columns_where::<16, _>(transforms, same),
        columns_where::<20, _>(transforms, same),
    ];
    let turned = |bits| normalized(&map_transposed(&to_local, &unpack(bits)));
    let plane = pack_in_steps::<8>(&turned(across), 2.0 * plane::STEPS);
    let clearance = _mm256_castsi256_ps(_mm256_slli_epi32::<16>(_mm256_castps_si256(lengths)));
    let radius = radius_at(view, &position, clearance);
    let [x, y, z] = position;
    let [nx, ny, nz] = turned(normal);
    let mut poses = [SurfelPose::zeroed(); 8];
    store_rows(
        &mut poses,
        &[x, y, z, radius],
        &[nx, ny, nz, _mm256_castsi256_ps(plane)],
    );
    poses
}

/// [`crate::stages::positional_update::radius_at`].
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn radius_at(view: &View<'_>, position: &Lanes3, clearance: __m256) -> __m256 {
    let from_eye = difference(position, &all(view.camera.eye));
    let distance = _mm256_sqrt_ps(dot(&from_eye, &from_eye));
    let angle = all_lanes(view.settings.radius_pixels * view.camera.pixel_angle);
    let [x, y, z] = magnitudes(&difference(position, &all(view.grid.centre)));
    let far = larger(larger(larger(x, y), z), all_lanes(view.grid.half));
    let side = _mm256_div_ps(
        _mm256_mul_ps(all_lanes(2.0), far),
        all_lanes(view.grid.side as f32),
    );
    let most = _mm256_mul_ps(side, all_lanes(grid::RADIUS_SHARE));
    let least = _mm256_mul_ps(all_lanes(1e-4), most);
    // The order of the operands lets what is not a number through.
    let wanted = _mm256_max_ps(least, _mm256_mul_ps(angle, distance));
    let wanted = _mm256_min_ps(most, wanted);
    let kept = larger(clearance, _mm256_mul_ps(all_lanes(LEAST_SHARE), wanted));
    smaller(wanted, kept)
}
