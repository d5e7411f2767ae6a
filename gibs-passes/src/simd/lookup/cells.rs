//! The cells of eight points, and where bounds there are compared with them: [`crate::shared::grid::cell`] and
//! [`crate::shared::bounds::place`], operation for operation.
use std::arch::x86_64::*;

use super::super::lanes::{Lanes3, all, positive, stored_words};
use crate::data::GridShape;
use crate::shared::bounds;

/// Cells of eight points and the points' places in them.
pub struct Cells {
    /// Index of each cell.
    pub cell: [u32; 8],
    /// As [`bounds::place`] gives it.
    pub place: [u32; 8],
}

/// [`crate::shared::portable::log2`].
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn log2(x: __m256) -> __m256 {
    let one = _mm256_set1_ps(1.0);
    let bits = _mm256_castps_si256(x);
    let exponent = _mm256_sub_ps(
        _mm256_cvtepi32_ps(_mm256_srli_epi32::<23>(bits)),
        _mm256_set1_ps(127.0),
    );
    let mantissa = _mm256_castsi256_ps(_mm256_or_si256(
        _mm256_and_si256(bits, _mm256_set1_epi32(0x007f_ffff)),
        _mm256_set1_epi32(0x3f80_0000),
    ));
    let high = _mm256_cmp_ps::<_CMP_GT_OQ>(mantissa, _mm256_set1_ps(std::f32::consts::SQRT_2));
    let halved = _mm256_mul_ps(mantissa, _mm256_set1_ps(0.5));
    let mantissa = _mm256_blendv_ps(mantissa, halved, high);
    let exponent = _mm256_add_ps(exponent, _mm256_and_ps(high, one));
    let t = _mm256_div_ps(_mm256_sub_ps(mantissa, one), _mm256_add_ps(mantissa, one));
    let t2 = _mm256_mul_ps(t, t);
    let mut series = _mm256_set1_ps(0.111_111_11);
    for term in [0.142_857_15, 0.2, 0.333_333_34, 1.0] {
        series = _mm256_add_ps(_mm256_set1_ps(term), _mm256_mul_ps(t2, series));
    }
    let scaled = _mm256_mul_ps(_mm256_set1_ps(2.885_39), t);
    _mm256_add_ps(exponent, _mm256_mul_ps(scaled, series))
}

/// A number from zero to `last`, rounded down.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn whole(x: __m256, last: __m256) -> __m256i {
    _mm256_cvttps_epi32(_mm256_min_ps(positive(x), last))
}

/// `b` where the mask is set, else `a`.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn chosen(a: __m256i, b: __m256i, mask: __m256) -> __m256i {
    _mm256_blendv_epi8(a, b, _mm256_castps_si256(mask))
}

impl Cells {
    /// The cells of eight points of a grid.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn of(position: &Lanes3, grid: &GridShape) -> Self {
        let (one, half) = (_mm256_set1_ps(1.0), _mm256_set1_ps(grid.half));
        let centre = all(grid.centre);
        let d: Lanes3 = std::array::from_fn(|i| _mm256_sub_ps(position[i], centre[i]));
        let a = d.map(|d| _mm256_andnot_ps(_mm256_set1_ps(-0.0), d));
        let m = _mm256_max_ps(_mm256_max_ps(a[0], a[1]), a[2]);
        let in_cube = _mm256_cmp_ps::<_CMP_LT_OQ>(m, half);
        let over = _mm256_blendv_ps(m, half, in_cube);
        let side = _mm256_set1_ps(grid.side as f32);
        let last = _mm256_set1_ps(grid.side as f32 - 1.0);
        let middle = _mm256_set1_ps(0.5);
        let index = d.map(|d| {
            let unit = _mm256_add_ps(_mm256_mul_ps(_mm256_div_ps(d, over), middle), middle);
            whole(_mm256_mul_ps(unit, side), last)
        });
        // The half-axis, and the other two coordinates in order.
        let not_below = |i: usize, j: usize| _mm256_cmp_ps::<_CMP_GE_OQ>(a[i], a[j]);
        let is_x = _mm256_and_ps(not_below(0, 1), not_below(0, 2));
        let is_y = not_below(1, 2);
        let along = _mm256_blendv_ps(_mm256_blendv_ps(d[2], d[1], is_y), d[0], is_x);
        let face = chosen(_mm256_set1_epi32(4), _mm256_set1_epi32(2), is_y);
        let face = chosen(face, _mm256_setzero_si256(), is_x);
        let negative = _mm256_cmp_ps::<_CMP_LT_OQ>(along, _mm256_setzero_ps());
        let face = _mm256_sub_epi32(face, _mm256_castps_si256(negative));
        let u = chosen(index[0], index[1], is_x);
        let v = chosen(chosen(index[1], index[2], is_y), index[2], is_x);
        let per_octave = _mm256_set1_ps(grid.per_octave);
        let slice = _mm256_mul_ps(log2(_mm256_div_ps(m, half)), per_octave);
        let slice = whole(slice, _mm256_set1_ps(grid.slices as f32 - 1.0));
        let (n, slices) = (
            _mm256_set1_epi32(grid.side as i32),
            _mm256_set1_epi32(grid.slices as i32),
        );
        let row = |high, low| _mm256_add_epi32(_mm256_mullo_epi32(high, n), low);
        let layer = _mm256_add_epi32(_mm256_mullo_epi32(face, slices), slice);
        let cube = grid.side.wrapping_mul(grid.side).wrapping_mul(grid.side);
        let beyond = _mm256_add_epi32(_mm256_set1_epi32(cube as i32), row(row(layer, v), u));
        let cell = chosen(beyond, row(row(index[2], index[1]), index[0]), in_cube);
        // Steps of bounds.
        let next = _mm256_add_epi32(slice, _mm256_set1_epi32(1));
        let octaves = _mm256_div_ps(_mm256_cvtepi32_ps(next), per_octave);
        let bits = _mm256_mul_ps(
            _mm256_sub_ps(_mm256_set1_ps(127.0), octaves),
            _mm256_set1_ps(8_388_608.0),
        );
        let power = _mm256_castsi256_ps(_mm256_cvttps_epi32(bits));
        let power = _mm256_blendv_ps(power, one, in_cube);
        let steps = _mm256_mul_ps(_mm256_set1_ps(bounds::steps_in_cube(grid)), power);
        let step = d.map(|d| {
            let down = _mm256_cvttps_epi32(_mm256_floor_ps(_mm256_mul_ps(d, steps)));
            _mm256_and_si256(down, _mm256_set1_epi32((1 << bounds::BITS) - 1))
        });
        const BITS: i32 = bounds::BITS as i32;
        let place = _mm256_or_si256(
            _mm256_or_si256(step[0], _mm256_slli_epi32::<BITS>(step[1])),
            _mm256_slli_epi32::<{ 2 * BITS }>(step[2]),
        );
        Self {
            cell: stored_words(cell),
            place: stored_words(place),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::Avx2;
    use super::*;
    use crate::shared::grid::{self, GridLayout};
    use crate::shared::hash;
    use glam::Vec3;

    /// Points from the centre to beyond the last slice, on its planes and axes too.
    #[test]
    fn eight_cells_are_those_of_eight_points() {
        let Some(avx2) = Avx2::detect() else {
            eprintln!("not run: this processor has no AVX2");
            return;
        };
        for (side, half) in [(4, 1e-3f32), (17, 0.5), (40, 1e3)] {
            let grid = GridLayout::new(side, 400.0).at(Vec3::new(0.1, -0.2, 0.3) * half, half);
            for case in 0..4000 {
                let points: [Vec3; 8] = std::array::from_fn(|lane| {
                    let random = |k| hash::unit(hash::hash3(case, lane as u32, k)) * 2.0 - 1.0;
                    let far = half * 2f32.powf(5.0 + 6.0 * random(3));
                    let d = Vec3::new(random(0), random(1), random(2)) * far;
                    grid.centre
                        + match case % 5 {
                            0 => Vec3::new(d.x, d.x, d.z),
                            1 => Vec3::new(d.x, 0.0, -d.x),
                            _ => d,
                        }
                });
                let found = avx2.run(
                    #[inline(always)]
                    || {
                        let lanes = |f: fn(Vec3) -> f32| {
                            let x = points.map(f);
                            // SAFETY: the load reads eight floats and needs no alignment; this runs where there is AVX2.
                            unsafe { _mm256_loadu_ps(x.as_ptr()) }
                        };
                        // SAFETY: as above.
                        unsafe {
                            Cells::of(&[lanes(|p| p.x), lanes(|p| p.y), lanes(|p| p.z)], &grid)
                        }
                    },
                );
                for (lane, &point) in points.iter().enumerate() {
                    let cell = grid::cell(point, &grid);
                    assert_eq!(found.cell[lane], cell, "{point}");
                    let steps = bounds::steps_in(cell, &grid);
                    let place = bounds::place(point - grid.centre, steps);
                    assert_eq!(found.place[lane], place, "{point}");
                }
            }
        }
    }
}
