//! The lookup of surfels around a point, eight surfels at a time: [`crate::shared::lookup`], operation for operation.
//!
//! Weights of eight surfels are found at once. The few that reach the point are gathered up, in the order of the cell's
//! list, until there are eight again for the depth functions; sums are then taken one after the other, in that order.
#![allow(unsafe_code)]
use std::arch::x86_64::*;

use super::Avx2;
use crate::data::{Gathered, SurfelDepth, SurfelLight, SurfelPose};
use crate::shared::lookup::{self, Surfels};
use glam::Vec3;

type Lanes3 = [__m256; 3];

/// The lookup with the best instructions of this processor. Make one per workgroup.
#[derive(Clone, Copy, Debug)]
pub struct Lookup(Option<Avx2>);

impl Default for Lookup {
    fn default() -> Self {
        Self::new()
    }
}

impl Lookup {
    /// With AVX2 where the processor has it.
    #[inline]
    pub fn new() -> Self {
        Lookup(Avx2::detect())
    }

    /// Same as [`lookup::coverage`].
    #[inline]
    pub fn coverage(
        self,
        point: Vec3,
        normal: Vec3,
        s: &Surfels<'_>,
        seen: impl FnMut(usize),
    ) -> f32 {
        match self.0 {
            // SAFETY: there is a proof that the processor has the features.
            Some(Avx2 { .. }) => unsafe { coverage(point, normal, s, seen) },
            None => lookup::coverage(point, normal, s, seen),
        }
    }

    /// Same as [`lookup::neighbours`].
    #[inline]
    pub fn neighbours(
        self,
        point: Vec3,
        normal: Vec3,
        reach: f32,
        s: &Surfels<'_>,
        wanted: impl Fn(usize) -> bool,
        each: impl FnMut(usize, f32),
    ) {
        match self.0 {
            // SAFETY: there is a proof that the processor has the features.
            Some(Avx2 { .. }) => unsafe { neighbours(point, normal, reach, s, wanted, each) },
            None => lookup::neighbours(point, normal, reach, s, wanted, each),
        }
    }

    /// Same as [`lookup::gather`].
    #[inline]
    pub fn gather(
        self,
        point: Vec3,
        normal: Vec3,
        enough: f32,
        s: &Surfels<'_>,
        light: &[SurfelLight],
    ) -> Gathered {
        match self.0 {
            // SAFETY: there is a proof that the processor has the features.
            Some(Avx2 { .. }) => unsafe { gather(point, normal, enough, s, light) },
            None => lookup::gather(point, normal, enough, s, light),
        }
    }
}

/// Eight surfels, in columns.
#[derive(Clone, Copy)]
struct Poses {
    position: Lanes3,
    radius: __m256,
    normal: Lanes3,
}

const _: () = assert!(size_of::<SurfelPose>() == 32 && size_of::<SurfelDepth>() == 64);

impl Poses {
    /// # Safety
    /// Inlined into functions for processors with AVX2 only: as a call of its own, it would pass its result through
    /// memory, in the innermost loop.
    #[inline(always)]
    unsafe fn load(poses: &[SurfelPose], ids: &[u32; 8]) -> Self {
        let row = |lane: usize| std::ptr::from_ref(&poses[ids[lane] as usize]).cast::<f32>();
        // SAFETY: a pose is eight words, all of which are valid numbers, and the loads need no alignment; the caller
        // has AVX2.
        unsafe {
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
            }
        }
    }

    /// From each surfel to a point.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
    fn to(&self, point: &Lanes3) -> Lanes3 {
        [
            _mm256_sub_ps(point[0], self.position[0]),
            _mm256_sub_ps(point[1], self.position[1]),
            _mm256_sub_ps(point[2], self.position[2]),
        ]
    }

    /// The same surfels with so many times the radius.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
    fn reaching(self, reach: f32) -> Self {
        let radius = _mm256_mul_ps(_mm256_set1_ps(reach), self.radius);
        Poses { radius, ..self }
    }

    /// [`lookup::falloff`].
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
    fn falloff(&self, d: &Lanes3) -> __m256 {
        let h = dot(d, &self.normal);
        let flat = _mm256_set1_ps(lookup::SQUASH * lookup::SQUASH - 1.0);
        let along = _mm256_mul_ps(_mm256_mul_ps(flat, h), h);
        let squared = _mm256_div_ps(
            _mm256_add_ps(dot(d, d), along),
            _mm256_mul_ps(self.radius, self.radius),
        );
        let k = positive(_mm256_sub_ps(_mm256_set1_ps(1.0), squared));
        _mm256_mul_ps(_mm256_mul_ps(_mm256_set1_ps(lookup::PEAK), k), k)
    }

    /// [`lookup::alignment`].
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
    fn alignment(&self, normal: &Lanes3) -> __m256 {
        let c = positive(dot(normal, &self.normal));
        let squared = _mm256_mul_ps(c, c);
        let fourth = _mm256_mul_ps(squared, squared);
        _mm256_mul_ps(fourth, fourth)
    }

    /// [`lookup::visibility`].
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
    fn visibility(&self, depths: &[SurfelDepth], ids: &[u32; 8], point: &Lanes3) -> __m256 {
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
        let share = chebyshev(&m, t);
        _mm256_blendv_ps(share, _mm256_set1_ps(1.0), touching)
    }
}

#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
fn all(v: Vec3) -> Lanes3 {
    [
        _mm256_set1_ps(v.x),
        _mm256_set1_ps(v.y),
        _mm256_set1_ps(v.z),
    ]
}

#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
fn dot(a: &Lanes3, b: &Lanes3) -> __m256 {
    let xy = _mm256_add_ps(_mm256_mul_ps(a[0], b[0]), _mm256_mul_ps(a[1], b[1]));
    _mm256_add_ps(xy, _mm256_mul_ps(a[2], b[2]))
}

/// The number, or zero where it is negative or none.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
fn positive(x: __m256) -> __m256 {
    _mm256_max_ps(x, _mm256_setzero_ps())
}

#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
fn negated(x: __m256) -> __m256 {
    _mm256_xor_ps(x, _mm256_set1_ps(-0.0))
}

/// [`crate::shared::sampling::to_local`].
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
fn to_local(world: &Lanes3, n: &Lanes3) -> Lanes3 {
    let one = _mm256_set1_ps(1.0);
    let up = _mm256_cmp_ps::<_CMP_GE_OQ>(n[2], _mm256_setzero_ps());
    let sign = _mm256_blendv_ps(_mm256_set1_ps(-1.0), one, up);
    let a = _mm256_div_ps(_mm256_set1_ps(-1.0), _mm256_add_ps(sign, n[2]));
    let b = _mm256_mul_ps(_mm256_mul_ps(n[0], n[1]), a);
    let signed_x = _mm256_mul_ps(sign, n[0]);
    let tangent = [
        _mm256_add_ps(one, _mm256_mul_ps(_mm256_mul_ps(signed_x, n[0]), a)),
        _mm256_mul_ps(sign, b),
        negated(signed_x),
    ];
    let bitangent = [
        b,
        _mm256_add_ps(sign, _mm256_mul_ps(_mm256_mul_ps(n[1], n[1]), a)),
        negated(n[1]),
    ];
    [dot(world, &tangent), dot(world, &bitangent), dot(world, n)]
}

/// [`lookup::depth_moments`] in a direction that is clamped to the hemisphere first.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
fn moments(depths: &[SurfelDepth], ids: &[u32; 8], local: &Lanes3) -> [__m256; 2] {
    let (zero, half, one) = (
        _mm256_setzero_ps(),
        _mm256_set1_ps(0.5),
        _mm256_set1_ps(1.0),
    );
    let minus = _mm256_set1_ps(-0.0);
    let side = _mm256_set1_ps(lookup::DEPTH_SIDE as f32);
    let last = _mm256_set1_ps(lookup::DEPTH_SIDE as f32 - 1.0);
    let sum = _mm256_add_ps(
        _mm256_andnot_ps(minus, local[0]),
        _mm256_andnot_ps(minus, local[1]),
    );
    let sum = _mm256_add_ps(sum, positive(local[2]));
    let (x, y) = (_mm256_div_ps(local[0], sum), _mm256_div_ps(local[1], sum));
    let place = |s: __m256| {
        let unit = _mm256_add_ps(_mm256_mul_ps(s, half), half);
        _mm256_sub_ps(_mm256_mul_ps(unit, side), half)
    };
    let (u, v) = (place(_mm256_add_ps(x, y)), place(_mm256_sub_ps(x, y)));
    let (u0, v0) = (_mm256_floor_ps(u), _mm256_floor_ps(v));
    let (fu, fv) = (_mm256_sub_ps(u, u0), _mm256_sub_ps(v, v0));
    // The second operand is taken where the first is not a number, as by a conversion to integer.
    let clamped = |c: __m256| _mm256_cvttps_epi32(_mm256_min_ps(_mm256_max_ps(c, zero), last));
    let columns = [clamped(u0), clamped(_mm256_add_ps(u0, one))];
    let rows = [
        _mm256_slli_epi32::<2>(clamped(v0)),
        _mm256_slli_epi32::<2>(clamped(_mm256_add_ps(v0, one))),
    ];
    let surfels: [*const u32; 8] =
        std::array::from_fn(|lane| depths[ids[lane] as usize].texels.as_ptr());
    let texel = |row: __m256i, column: __m256i| {
        let mut index = [0u32; 8];
        // SAFETY: the store writes the eight words of the array and needs no alignment.
        unsafe { _mm256_storeu_si256(index.as_mut_ptr().cast(), _mm256_add_epi32(row, column)) };
        // SAFETY: row and column are clamped to 0..=3, so that the index stays below the 16 texels.
        let word = |lane: usize| unsafe { *surfels[lane].add(index[lane] as usize) } as i32;
        let words = _mm256_setr_epi32(
            word(0),
            word(1),
            word(2),
            word(3),
            word(4),
            word(5),
            word(6),
            word(7),
        );
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
    let scale = _mm256_set1_ps(lookup::MOMENT_SCALE);
    let moment = |k: usize| {
        let top = blend(corners[0][k], corners[1][k], fu, gu);
        let bottom = blend(corners[2][k], corners[3][k], fu, gu);
        _mm256_mul_ps(blend(top, bottom, fv, gv), scale)
    };
    [moment(0), moment(1)]
}

/// [`lookup::chebyshev`].
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
fn chebyshev(m: &[__m256; 2], t: __m256) -> __m256 {
    let one = _mm256_set1_ps(1.0);
    let variance = _mm256_max_ps(
        _mm256_sub_ps(m[1], _mm256_mul_ps(m[0], m[0])),
        _mm256_set1_ps(lookup::LEAST_VARIANCE),
    );
    let d = _mm256_sub_ps(t, m[0]);
    let bound = _mm256_div_ps(variance, _mm256_add_ps(variance, _mm256_mul_ps(d, d)));
    let floor = lookup::CHEBYSHEV_FLOOR;
    let tight = positive(_mm256_div_ps(
        _mm256_sub_ps(bound, _mm256_set1_ps(floor)),
        _mm256_set1_ps(1.0 - floor),
    ));
    let cubed = _mm256_mul_ps(_mm256_mul_ps(tight, tight), tight);
    _mm256_blendv_ps(cubed, one, _mm256_cmp_ps::<_CMP_LE_OQ>(t, m[0]))
}

#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
fn stored(x: __m256) -> [f32; 8] {
    let mut lanes = [0.0; 8];
    // SAFETY: the store writes the eight floats of the array and needs no alignment.
    unsafe { _mm256_storeu_ps(lanes.as_mut_ptr(), x) };
    lanes
}

/// Summed weight, over that of a surfel at its centre, that a few surfels are likely to reach.
const FEW: f32 = 1.0;

/// Surfels that wait for their depth functions, with their weights so far.
struct Pending {
    ids: [u32; 8],
    weights: [f32; 8],
    count: usize,
}

impl Pending {
    const EMPTY: Self = Pending {
        ids: [0; 8],
        weights: [0.0; 8],
        count: 0,
    };

    /// Adds a surfel; whether there are now eight.
    #[inline(always)]
    fn push(&mut self, id: u32, weight: f32) -> bool {
        self.ids[self.count & 7] = id;
        self.weights[self.count & 7] = weight;
        self.count += 1;
        self.count == 8
    }

    /// Multiplies the weights by what the depth functions let through, gives each surfel to `sum`, and empties itself.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
    fn flush(
        &mut self,
        s: &Surfels<'_>,
        use_depth: bool,
        point: &Lanes3,
        mut sum: impl FnMut(usize, f32),
    ) {
        let count = self.count.min(8);
        self.count = 0;
        if count == 0 {
            return;
        }
        if use_depth {
            // Lanes beyond the count hold surfels of before, or surfel 0, which exist.
            // SAFETY: this function is compiled for AVX2.
            let poses = unsafe { Poses::load(s.poses, &self.ids) };
            let share = poses.visibility(s.depths, &self.ids, point);
            let share = stored(share);
            for (weight, share) in self.weights.iter_mut().zip(share) {
                *weight *= share;
            }
        }
        for (&id, &weight) in self.ids.iter().zip(&self.weights).take(count) {
            sum(id as usize, weight);
        }
    }
}

/// Eight entries, the last one repeated where there are fewer, and a mask of those that are there.
#[inline(always)]
fn eight(chunk: &[u32]) -> ([u32; 8], u32) {
    match <[u32; 8]>::try_from(chunk) {
        Ok(ids) => (ids, 0xff),
        Err(_) => {
            let mut ids = [chunk[0]; 8];
            ids[..chunk.len()].copy_from_slice(chunk);
            (ids, (1 << chunk.len()) - 1)
        }
    }
}

/// Calls `each` with the lanes of a mask, in order.
#[inline(always)]
fn lanes(mut mask: u32, mut each: impl FnMut(usize)) {
    while mask != 0 {
        each(mask.trailing_zeros() as usize & 7);
        mask &= mask - 1;
    }
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
fn coverage(point: Vec3, normal: Vec3, s: &Surfels<'_>, mut seen: impl FnMut(usize)) -> f32 {
    let entries = s.around(point);
    let (point, normal) = (all(point), all(normal));
    let use_depth = !s.depths.is_empty();
    let mut pending = Pending::EMPTY;
    let mut total = 0.0;
    let mut sum = |id: usize, weight: f32| {
        total += weight;
        if weight > 0.0 {
            seen(id);
        }
    };
    for chunk in entries.chunks(8) {
        let (ids, there) = eight(chunk);
        // SAFETY: this function is compiled for AVX2.
        let poses = unsafe { Poses::load(s.poses, &ids) };
        let weight = _mm256_mul_ps(poses.falloff(&poses.to(&point)), poses.alignment(&normal));
        let some = _mm256_cmp_ps::<_CMP_GT_OQ>(weight, _mm256_setzero_ps());
        let mask = _mm256_movemask_ps(some) as u32 & there;
        if mask == 0 {
            continue;
        }
        let weights = stored(weight);
        lanes(mask, |lane| {
            if pending.push(ids[lane], weights[lane]) {
                pending.flush(s, use_depth, &point, &mut sum);
            }
        });
    }
    pending.flush(s, use_depth, &point, &mut sum);
    total
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
fn neighbours(
    point: Vec3,
    normal: Vec3,
    reach: f32,
    s: &Surfels<'_>,
    wanted: impl Fn(usize) -> bool,
    mut each: impl FnMut(usize, f32),
) {
    let entries = s.around(point);
    let (point, normal) = (all(point), all(normal));
    let use_depth = !s.depths.is_empty();
    let mut pending = Pending::EMPTY;
    for chunk in entries.chunks(8) {
        let (ids, there) = eight(chunk);
        // SAFETY: this function is compiled for AVX2.
        let poses = unsafe { Poses::load(s.poses, &ids) }.reaching(reach);
        let weight = _mm256_mul_ps(poses.falloff(&poses.to(&point)), poses.alignment(&normal));
        let some = _mm256_cmp_ps::<_CMP_GT_OQ>(weight, _mm256_setzero_ps());
        let mask = _mm256_movemask_ps(some) as u32 & there;
        if mask == 0 {
            continue;
        }
        let weights = stored(weight);
        lanes(mask, |lane| {
            let id = ids[lane];
            if wanted(id as usize) && pending.push(id, weights[lane]) {
                pending.flush(s, use_depth, &point, &mut each);
            }
        });
    }
    pending.flush(s, use_depth, &point, &mut each);
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
fn gather(
    point: Vec3,
    normal: Vec3,
    enough: f32,
    s: &Surfels<'_>,
    light: &[SurfelLight],
) -> Gathered {
    let entries = s.around(point);
    let (point, normal) = (all(point), all(normal));
    let use_depth = !s.depths.is_empty();
    // A few surfels are likely to be enough where that is little: they are not kept waiting for eight.
    let few = if enough < FEW * lookup::PEAK { 3 } else { 8 };
    let mut pending = Pending::EMPTY;
    let mut g = Gathered::default();
    let sum = |g: &mut Gathered, id: usize, weight: f32| {
        if g.weight < enough {
            g.irradiance += light[id].irradiance * weight;
            g.weight += weight;
            g.confidence += weight * light[id].trust;
        }
    };
    for chunk in entries.chunks(8) {
        let (ids, there) = eight(chunk);
        // SAFETY: this function is compiled for AVX2.
        let poses = unsafe { Poses::load(s.poses, &ids) };
        let weight = _mm256_mul_ps(poses.falloff(&poses.to(&point)), poses.alignment(&normal));
        let some = _mm256_cmp_ps::<_CMP_GT_OQ>(weight, _mm256_setzero_ps());
        let mask = _mm256_movemask_ps(some) as u32 & there;
        if mask == 0 {
            continue;
        }
        let weights = stored(weight);
        lanes(mask, |lane| {
            let id = ids[lane];
            if light[id as usize].trust != 0.0 && pending.push(id, weights[lane]) {
                pending.flush(s, use_depth, &point, |id, weight| sum(&mut g, id, weight));
            }
        });
        if pending.count >= few {
            pending.flush(s, use_depth, &point, |id, weight| sum(&mut g, id, weight));
        }
        if g.weight >= enough {
            break;
        }
    }
    pending.flush(s, use_depth, &point, |id, weight| sum(&mut g, id, weight));
    if g.weight > 0.0 {
        g.confidence /= g.weight;
    }
    if g.weight >= 1.0 {
        g.irradiance /= g.weight;
        g.weight = 1.0;
        return g;
    }
    let mut average_weight = 0.0;
    let mut sum = |id: usize, weight: f32| {
        g.average += light[id].irradiance * weight;
        average_weight += weight;
    };
    for chunk in entries[..entries.len().min(lookup::AVERAGE_OF)].chunks(8) {
        let (ids, there) = eight(chunk);
        // SAFETY: this function is compiled for AVX2.
        let weight = unsafe { Poses::load(s.poses, &ids) }.alignment(&normal);
        let some = _mm256_cmp_ps::<_CMP_GT_OQ>(weight, _mm256_setzero_ps());
        let weights = stored(weight);
        lanes(_mm256_movemask_ps(some) as u32 & there, |lane| {
            let id = ids[lane];
            if light[id as usize].trust != 0.0 && pending.push(id, weights[lane]) {
                pending.flush(s, use_depth, &point, &mut sum);
            }
        });
    }
    pending.flush(s, use_depth, &point, &mut sum);
    g.average /= average_weight.max(lookup::AVERAGE_LEAST);
    g
}
