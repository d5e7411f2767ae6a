//! Eight surfels at a time: weights and depth functions of [`crate::shared::lookup`], operation for operation.
#![allow(unsafe_code)]
use std::arch::x86_64::*;

use super::super::directions::{hemisphere, to_local};
use super::super::lanes::{Lanes3, dot, magnitude, positive};
use crate::data::SurfelPose;
use crate::shared::depth::{self, Depths};
use crate::shared::plane::{STEP, STEPS};
use crate::shared::{lookup, mark};

/// Eight surfels, in columns.
#[derive(Clone, Copy)]
pub struct Poses {
    /// Position, metres.
    pub position: Lanes3,
    /// Radius, metres.
    pub radius: __m256,
    /// Normal.
    pub normal: Lanes3,
    /// Mark.
    pub mark: __m256,
}

const _: () = assert!(size_of::<SurfelPose>() == 32);

/// # Panics
/// If one of eight surfels does not exist.
#[inline(always)]
fn check(ids: &[u32; 8], count: usize) {
    let most = ids.iter().fold(0, |most, &id| id.max(most));
    // Indices of texels, of which a surfel has at most 64, are signed.
    let exists = (most as usize) < count.min(1 << 25);
    assert!(exists, "surfel {most} of {count}");
}

impl Poses {
    /// # Safety
    /// Inlined into functions for processors with AVX2 only: as a call of its own, it would pass its result through
    /// memory, in the innermost loop.
    #[inline(always)]
    pub unsafe fn load(poses: &[SurfelPose], ids: &[u32; 8]) -> Self {
        check(ids, poses.len());
        // SAFETY: the surfels exist, a pose is eight words, all of which are valid numbers, and the loads need no
        // alignment; the caller has AVX2.
        unsafe {
            let row = |lane: usize| poses.as_ptr().add(ids[lane] as usize).cast::<f32>();
            // Transposes eight rows: pairs of words, then pairs of pairs, then halves.
            let (r0, r1) = (_mm256_loadu_ps(row(0)), _mm256_loadu_ps(row(1)));
            let (r2, r3) = (_mm256_loadu_ps(row(2)), _mm256_loadu_ps(row(3)));
            let (r4, r5) = (_mm256_loadu_ps(row(4)), _mm256_loadu_ps(row(5)));
            let (r6, r7) = (_mm256_loadu_ps(row(6)), _mm256_loadu_ps(row(7)));
            let (a0, a1) = (_mm256_unpacklo_ps(r0, r1), _mm256_unpackhi_ps(r0, r1));
            let (a2, a3) = (_mm256_unpacklo_ps(r2, r3), _mm256_unpackhi_ps(r2, r3));
            let (a4, a5) = (_mm256_unpacklo_ps(r4, r5), _mm256_unpackhi_ps(r4, r5));
            let (a6, a7) = (_mm256_unpacklo_ps(r6, r7), _mm256_unpackhi_ps(r6, r7));
            let b0 = _mm256_shuffle_ps::<0x44>(a0, a2);
            let b1 = _mm256_shuffle_ps::<0xee>(a0, a2);
            let b2 = _mm256_shuffle_ps::<0x44>(a1, a3);
            let b3 = _mm256_shuffle_ps::<0xee>(a1, a3);
            let b4 = _mm256_shuffle_ps::<0x44>(a4, a6);
            let b5 = _mm256_shuffle_ps::<0xee>(a4, a6);
            let b6 = _mm256_shuffle_ps::<0x44>(a5, a7);
            let b7 = _mm256_shuffle_ps::<0xee>(a5, a7);
            Poses {
                position: [
                    _mm256_permute2f128_ps::<0x20>(b0, b4),
                    _mm256_permute2f128_ps::<0x20>(b1, b5),
                    _mm256_permute2f128_ps::<0x20>(b2, b6),
                ],
                radius: _mm256_permute2f128_ps::<0x20>(b3, b7),
                normal: [
                    _mm256_permute2f128_ps::<0x31>(b0, b4),
                    _mm256_permute2f128_ps::<0x31>(b1, b5),
                    _mm256_permute2f128_ps::<0x31>(b2, b6),
                ],
                mark: _mm256_permute2f128_ps::<0x31>(b3, b7),
            }
        }
    }

    /// A bit for each that hides something within its radius: [`mark::is_open`] is false.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn hiding(&self) -> u32 {
        const { assert!(mark::OPEN == 1 << 31) };
        !_mm256_movemask_ps(self.mark) as u32 & 0xff
    }

    /// Normals of their planes.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn across(&self) -> Lanes3 {
        planes(self.mark)
    }

    /// From each surfel to a point.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn to(&self, point: &Lanes3) -> Lanes3 {
        [
            _mm256_sub_ps(point[0], self.position[0]),
            _mm256_sub_ps(point[1], self.position[1]),
            _mm256_sub_ps(point[2], self.position[2]),
        ]
    }

    /// The same surfels with so many times the radius.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn reaching(self, reach: f32) -> Self {
        let radius = _mm256_mul_ps(_mm256_set1_ps(reach), self.radius);
        Poses { radius, ..self }
    }

    /// [`lookup::nearness`].
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn nearness(&self, d: &Lanes3) -> __m256 {
        let across = self.across();
        let (h, whole) = (dot(d, &across), dot(&across, &across));
        let flat = _mm256_set1_ps(lookup::SQUASH * lookup::SQUASH - 1.0);
        let along = _mm256_mul_ps(_mm256_mul_ps(flat, h), h);
        let squared = _mm256_div_ps(
            _mm256_add_ps(_mm256_mul_ps(dot(d, d), whole), along),
            _mm256_mul_ps(whole, _mm256_mul_ps(self.radius, self.radius)),
        );
        positive(_mm256_sub_ps(_mm256_set1_ps(1.0), squared))
    }

    /// [`lookup::falloff`].
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn falloff(&self, d: &Lanes3) -> __m256 {
        let k = self.nearness(d);
        _mm256_mul_ps(_mm256_mul_ps(_mm256_set1_ps(lookup::PEAK), k), k)
    }

    /// [`lookup::alignment`].
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn alignment(&self, normal: &Lanes3) -> __m256 {
        let c = positive(dot(normal, &self.normal));
        let squared = _mm256_mul_ps(c, c);
        let fourth = _mm256_mul_ps(squared, squared);
        _mm256_mul_ps(fourth, fourth)
    }

    /// [`lookup::leaning`].
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn leaning(&self, normal: &Lanes3) -> __m256 {
        let c = positive(dot(normal, &self.normal));
        _mm256_mul_ps(c, c)
    }

    /// [`depth::visibility`].
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn visibility(&self, depths: Depths<'_>, ids: &[u32; 8], point: &Lanes3) -> __m256 {
        self.visibility_within(f32::MAX, depths, ids, point)
    }

    /// [`depth::openness`].
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn openness(&self, depths: Depths<'_>, ids: &[u32; 8], point: &Lanes3) -> __m256 {
        self.visibility_within(1.0, depths, ids, point)
    }

    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn visibility_within(
        &self,
        most: f32,
        depths: Depths<'_>,
        ids: &[u32; 8],
        point: &Lanes3,
    ) -> __m256 {
        let d = self.to(point);
        let distance = _mm256_sqrt_ps(dot(&d, &d));
        let touching =
            _mm256_cmp_ps::<_CMP_LT_OQ>(distance, _mm256_mul_ps(_mm256_set1_ps(0.02), self.radius));
        let direction = [
            _mm256_div_ps(d[0], distance),
            _mm256_div_ps(d[1], distance),
            _mm256_div_ps(d[2], distance),
        ];
        let m = moments(depths, ids, &to_local(&direction, &self.normal));
        let t = _mm256_div_ps(distance, _mm256_mul_ps(_mm256_set1_ps(2.0), self.radius));
        // The second operand is taken where the first is not a number, as by `f32::min`.
        let t = _mm256_min_ps(t, _mm256_set1_ps(most));
        let share = chebyshev(&m, t);
        _mm256_blendv_ps(share, _mm256_set1_ps(1.0), touching)
    }
}

/// Normals of the planes in eight marks: [`crate::shared::plane::unpack`].
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn planes(marks: __m256) -> Lanes3 {
    let (bits, low) = (_mm256_castps_si256(marks), _mm256_set1_epi32(0xff));
    let (steps, zero) = (_mm256_set1_ps(STEPS), _mm256_setzero_ps());
    let step = |word| _mm256_sub_ps(_mm256_cvtepi32_ps(_mm256_and_si256(word, low)), steps);
    let (x, y) = (step(bits), step(_mm256_srli_epi32::<8>(bits)));
    let z = _mm256_sub_ps(_mm256_sub_ps(steps, magnitude(x)), magnitude(y));
    let below = positive(_mm256_sub_ps(zero, z));
    // Towards zero, as far as the sign says: a step of zero has none.
    let folded = |c| {
        _mm256_sub_ps(
            c,
            _mm256_or_ps(below, _mm256_and_ps(c, _mm256_set1_ps(-0.0))),
        )
    };
    let step = _mm256_set1_ps(STEP);
    [folded(x), folded(y), z].map(|c| _mm256_mul_ps(c, step))
}

/// [`depth::depth_moments`] in a direction that is clamped to the hemisphere first.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn moments(depths: Depths<'_>, ids: &[u32; 8], local: &Lanes3) -> [__m256; 2] {
    let (zero, half, one) = (
        _mm256_setzero_ps(),
        _mm256_set1_ps(0.5),
        _mm256_set1_ps(1.0),
    );
    let count = depth::count(depths.side());
    assert!(
        (1..=64).contains(&count),
        "{count} texels of a depth function, of which a lookup takes up to 64"
    );
    let side = _mm256_set1_ps(depths.side() as f32);
    let last = _mm256_set1_ps(depths.side() as f32 - 1.0);
    let place = |unit: __m256| _mm256_sub_ps(_mm256_mul_ps(unit, side), half);
    let [u, v] = hemisphere(&[local[0], local[1], positive(local[2])]);
    let (u, v) = (place(u), place(v));
    let (u0, v0) = (_mm256_floor_ps(u), _mm256_floor_ps(v));
    let (fu, fv) = (_mm256_sub_ps(u, u0), _mm256_sub_ps(v, v0));
    // The second operand is taken where the first is not a number, as by a conversion to integer.
    let clamped = |c: __m256| _mm256_cvttps_epi32(_mm256_min_ps(_mm256_max_ps(c, zero), last));
    check(ids, depths.texels().len() / count);
    let columns = [clamped(u0), clamped(_mm256_add_ps(u0, one))];
    let times = |words: __m256i, by: u32| _mm256_mullo_epi32(words, _mm256_set1_epi32(by as i32));
    let rows = [
        times(clamped(v0), depths.side()),
        times(clamped(_mm256_add_ps(v0, one)), depths.side()),
    ];
    // SAFETY: the load reads the eight words of the array and needs no alignment.
    let ids = unsafe { _mm256_loadu_si256(ids.as_ptr().cast()) };
    let first = times(ids, count as u32);
    let texel = |row: __m256i, column: __m256i| {
        let index = _mm256_add_epi32(first, _mm256_add_epi32(row, column));
        // SAFETY: the surfels exist and are at most 2^25; row and column are clamped to less than the side, so that the index
        // stays within the texels of each, 64 at most, and below 2^31.
        let words = unsafe { _mm256_i32gather_epi32::<4>(depths.texels().as_ptr().cast(), index) };
        [
            _mm256_cvtepi32_ps(_mm256_and_si256(words, _mm256_set1_epi32(0xffff))),
            _mm256_cvtepi32_ps(_mm256_srli_epi32::<16>(words)),
        ]
    };
    let corners = [
        texel(rows[0], columns[0]),
        texel(rows[0], columns[1]),
        texel(rows[1], columns[0]),
        texel(rows[1], columns[1]),
    ];
    let (gu, gv) = (_mm256_sub_ps(one, fu), _mm256_sub_ps(one, fv));
    let blend = |a, b, f, g| _mm256_add_ps(_mm256_mul_ps(a, g), _mm256_mul_ps(b, f));
    let scale = _mm256_set1_ps(depth::MOMENT_SCALE);
    let moment = |k: usize| {
        let top = blend(corners[0][k], corners[1][k], fu, gu);
        let bottom = blend(corners[2][k], corners[3][k], fu, gu);
        _mm256_mul_ps(blend(top, bottom, fv, gv), scale)
    };
    [moment(0), moment(1)]
}

/// [`depth::chebyshev`].
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn chebyshev(m: &[__m256; 2], t: __m256) -> __m256 {
    let one = _mm256_set1_ps(1.0);
    let variance = _mm256_max_ps(
        _mm256_sub_ps(m[1], _mm256_mul_ps(m[0], m[0])),
        _mm256_set1_ps(depth::LEAST_VARIANCE),
    );
    let d = _mm256_sub_ps(t, m[0]);
    let bound = _mm256_div_ps(variance, _mm256_add_ps(variance, _mm256_mul_ps(d, d)));
    let floor = depth::CHEBYSHEV_FLOOR;
    let tight = positive(_mm256_div_ps(
        _mm256_sub_ps(bound, _mm256_set1_ps(floor)),
        _mm256_set1_ps(1.0 - floor),
    ));
    let cubed = _mm256_mul_ps(_mm256_mul_ps(tight, tight), tight);
    _mm256_blendv_ps(cubed, one, _mm256_cmp_ps::<_CMP_LE_OQ>(t, m[0]))
}
