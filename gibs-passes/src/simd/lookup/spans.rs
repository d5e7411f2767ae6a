//! The cells that eight surfels overlap: [`crate::shared::grid::overlapped`], operation for operation.
use std::arch::x86_64::*;

use super::super::Avx2;
use super::super::lanes::{dot, larger, magnitude, magnitudes, positive, stored_words};
use super::cells::{log2, whole};
use super::poses::Poses;
use crate::data::{GridShape, SurfelPose};
use crate::shared::grid::{self, FLAT, MARGIN};

/// Same as [`grid::overlapped_by`].
#[inline(always)]
pub fn overlapped_by(
    surfels: impl Iterator<Item = usize>,
    poses: &[SurfelPose],
    grid: &GridShape,
    each: impl FnMut(u32, u32),
) {
    match Avx2::detect() {
        // SAFETY: there is a proof that the processor has the features.
        Some(Avx2 { .. }) => unsafe { overlapped_wide(surfels, poses, grid, each) },
        None => grid::overlapped_by(surfels, poses, grid, each),
    }
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn overlapped_wide(
    surfels: impl Iterator<Item = usize>,
    poses: &[SurfelPose],
    grid: &GridShape,
    mut each: impl FnMut(u32, u32),
) {
    let mut live = surfels.filter(|&i| poses[i].radius > 0.0);
    loop {
        let mut ids = [0; 8];
        let mut count = 0;
        for (id, i) in ids.iter_mut().zip(&mut live) {
            *id = i as u32;
            count += 1;
        }
        if count == 0 {
            return;
        }
        let filler = ids[0];
        ids[count..].fill(filler);
        let spans = Spans::of(poses, &ids, grid);
        for (lane, &id) in ids.iter().enumerate().take(count) {
            if spans.alone & 1 << lane == 0 {
                grid::overlapped(&poses[id as usize], grid, |cell| each(id, cell));
                continue;
            }
            let along = |axis: usize| spans.low[axis][lane]..=spans.high[axis][lane];
            for z in along(2) {
                for y in along(1) {
                    for x in along(0) {
                        each(id, spans.base[lane] + (z * grid.side + y) * grid.side + x);
                    }
                }
            }
        }
        if count < 8 {
            return;
        }
    }
}

/// As [`grid::Span`], for each of eight surfels that overlaps cells of one half-axis only, as most do.
struct Spans {
    /// A bit for each of those.
    alone: u32,
    base: [u32; 8],
    low: [[u32; 8]; 3],
    high: [[u32; 8]; 3],
}

impl Spans {
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn of(poses: &[SurfelPose], ids: &[u32; 8], grid: &GridShape) -> Self {
        // SAFETY: this function is compiled for AVX2.
        let poses = unsafe { Poses::load(poses, ids) };
        let (zero, one) = (_mm256_setzero_ps(), _mm256_set1_ps(1.0));
        let half = _mm256_set1_ps(grid.half);
        let normal = poses.across();
        let length = dot(&normal, &normal);
        let radius = _mm256_mul_ps(poses.radius, _mm256_set1_ps(MARGIN));
        let r = normal.map(|n| {
            let flat = _mm256_mul_ps(_mm256_mul_ps(n, _mm256_set1_ps(FLAT)), n);
            let across = positive(_mm256_sub_ps(one, _mm256_div_ps(flat, length)));
            _mm256_mul_ps(radius, _mm256_sqrt_ps(across))
        });
        let centre = super::all(grid.centre);
        let d: [_; 3] = std::array::from_fn(|i| _mm256_sub_ps(poses.position[i], centre[i]));
        let distance = magnitudes(&d);
        let below: [_; 3] = std::array::from_fn(|i| _mm256_sub_ps(distance[i], r[i]));
        let above: [_; 3] = std::array::from_fn(|i| _mm256_add_ps(distance[i], r[i]));
        let beyond = _mm256_set1_ps(grid.half * MARGIN);
        let is_along = |i: usize| {
            let others = larger(above[(i + 1) % 3], above[(i + 2) % 3]);
            _mm256_cmp_ps::<_CMP_GT_OQ>(below[i], larger(others, beyond))
        };
        let (is_x, is_y, is_z) = (is_along(0), is_along(1), is_along(2));
        let alone = _mm256_or_ps(_mm256_or_ps(is_x, is_y), is_z);
        // The half-axis, and the other two coordinates in order.
        let turned = |v: &[__m256; 3]| {
            let main = _mm256_blendv_ps(_mm256_blendv_ps(v[2], v[1], is_y), v[0], is_x);
            let u = _mm256_blendv_ps(v[0], v[1], is_x);
            let w = _mm256_blendv_ps(v[1], v[2], _mm256_or_ps(is_x, is_y));
            [main, u, w]
        };
        let ([main, u, v], [rm, ru, rv]) = (turned(&d), turned(&r));
        let along = magnitude(main);
        let far = _mm256_add_ps(along, rm);
        let near = _mm256_max_ps(_mm256_sub_ps(along, rm), half);
        let side = _mm256_set1_ps(grid.side as f32);
        let last = _mm256_set1_ps(grid.side as f32 - 1.0);
        let middle = _mm256_set1_ps(0.5);
        let index = |x: __m256| {
            let unit = _mm256_add_ps(_mm256_mul_ps(x, middle), middle);
            stored_words(whole(_mm256_mul_ps(unit, side), last))
        };
        let low = |x: __m256| {
            let is_below = _mm256_cmp_ps::<_CMP_LT_OQ>(x, zero);
            index(_mm256_div_ps(x, _mm256_blendv_ps(far, near, is_below)))
        };
        let high = |x: __m256| {
            let is_above = _mm256_cmp_ps::<_CMP_GT_OQ>(x, zero);
            index(_mm256_div_ps(x, _mm256_blendv_ps(far, near, is_above)))
        };
        let slice = |m: __m256| {
            let octaves = log2(_mm256_div_ps(m, half));
            let slice = _mm256_mul_ps(octaves, _mm256_set1_ps(grid.per_octave));
            stored_words(whole(slice, _mm256_set1_ps(grid.slices as f32 - 1.0)))
        };
        let face = |n| _mm256_castsi256_ps(_mm256_set1_epi32(n));
        let face = _mm256_blendv_ps(_mm256_blendv_ps(face(4), face(2), is_y), face(0), is_x);
        let negative = _mm256_cmp_ps::<_CMP_LT_OQ>(main, zero);
        let face = _mm256_sub_epi32(_mm256_castps_si256(face), _mm256_castps_si256(negative));
        let layer = grid.side.wrapping_mul(grid.side);
        let cube = layer.wrapping_mul(grid.side);
        let layers = _mm256_set1_epi32(grid.slices.wrapping_mul(layer) as i32);
        let base = _mm256_add_epi32(
            _mm256_set1_epi32(cube as i32),
            _mm256_mullo_epi32(face, layers),
        );
        Spans {
            alone: _mm256_movemask_ps(alone) as u32,
            base: stored_words(base),
            low: [
                low(_mm256_sub_ps(u, ru)),
                low(_mm256_sub_ps(v, rv)),
                slice(near),
            ],
            high: [
                high(_mm256_add_ps(u, ru)),
                high(_mm256_add_ps(v, rv)),
                slice(far),
            ],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shared::grid::GridLayout;
    use crate::shared::{hash, mark, plane};
    use glam::Vec3;

    /// From within the cube to beyond the last slice, on axes and diagonals too, of every size.
    #[test]
    fn eight_surfels_overlap_the_cells_that_each_does() {
        if Avx2::detect().is_none() {
            eprintln!("not run: this processor has no AVX2");
            return;
        }
        let (mut alone, mut pairs) = (0, 0);
        for (side, half) in [(4, 1e-3f32), (17, 0.5), (40, 1e3)] {
            let grid = GridLayout::new(side, 400.0).at(Vec3::new(0.1, -0.2, 0.3) * half, half);
            let poses: Vec<SurfelPose> = (0..6000u32)
                .map(|i| {
                    let random = |k| hash::unit(hash::hash3(i, side, k)) * 2.0 - 1.0;
                    let far = half * 2f32.powf(5.0 + 6.0 * random(3));
                    let d = Vec3::new(random(0), random(1), random(2)) * far;
                    let d = match i % 5 {
                        0 => Vec3::new(d.x, d.x, d.z),
                        1 => Vec3::new(d.x, 0.0, -d.x),
                        _ => d,
                    };
                    // What an engine's G-buffer makes of nonsense.
                    let d = match i % 97 {
                        0 => Vec3::new(d.x, 2.0 * d.x, f32::NAN),
                        1 => Vec3::new(f32::NAN, d.x, 2.0 * d.x),
                        2 => Vec3::new(f32::INFINITY, f32::INFINITY, f32::NAN),
                        _ => d,
                    };
                    let position = grid.centre + d;
                    let normal = Vec3::new(random(4), random(5), random(6)).normalize();
                    let share = 0.5 * hash::unit(hash::hash3(i, side, 7));
                    let radius = grid::cell_side(position, &grid) * share;
                    SurfelPose {
                        position,
                        radius: if i % 7 == 0 { 0.0 } else { radius },
                        normal,
                        mark: mark::of(i, plane::pack(normal), false),
                    }
                })
                .collect();
            for range in [0..6000, 3..3, 5..6, 11..24, 100..1003] {
                let (mut expected, mut found) = (Vec::new(), Vec::new());
                let all = || range.clone();
                grid::overlapped_by(all(), &poses, &grid, |id, cell| expected.push((id, cell)));
                overlapped_by(all(), &poses, &grid, |id, cell| found.push((id, cell)));
                assert_eq!(expected, found, "{side}, {range:?}");
                pairs += found.len();
            }
            let (eights, _) = poses.as_chunks::<8>();
            for first in (0..eights.len() as u32 * 8).step_by(8) {
                let ids: [u32; 8] = std::array::from_fn(|lane| first + lane as u32);
                // SAFETY: there is AVX2, see above.
                alone += unsafe { Spans::of(&poses, &ids, &grid) }.alone.count_ones();
            }
        }
        println!("{alone} of 18000 within one half-axis, {pairs} pairs");
        assert!(alone > 6000 && alone < 17_000);
    }
}
