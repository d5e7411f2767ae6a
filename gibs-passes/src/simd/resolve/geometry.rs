//! Positions and normals at eight hits: the first part of [`crate::stages::resolve_hits::resolve`], operation for
//! operation.
use std::arch::x86_64::*;

use super::super::directions::{normalized, pack, unpack};
use super::super::lanes::{
    Lanes3, all_same, columns, columns_where, dot, either, has_any, inverted, is_word, larger,
    magnitude, magnitudes, map_transposed, scaled, sum, turned,
};
use crate::data::{Corners, Hit, Instance, NONE, Ray, Triangle};
use crate::shared::surface;

/// What eight hits are on.
pub struct On<'a> {
    /// The hits.
    pub hits: [&'a Hit; 8],
    /// Their rays.
    pub rays: [&'a Ray; 8],
    /// Triangles.
    pub triangles: [&'a Triangle; 8],
    /// Instances.
    pub instances: [&'a Instance; 8],
    /// Corners of the triangles.
    pub corners: [&'a Corners; 8],
}

/// Surfaces at eight hits, but for their materials.
#[derive(Clone, Copy)]
pub struct Geometry {
    /// Position and offset, in columns.
    pub place: [__m256; 4],
    /// Packed geometric and shading normals.
    pub normals: [__m256i; 2],
    /// The ray comes from the front.
    pub front: __m256,
    /// Texture coordinates.
    pub uv: [__m256; 2],
    /// Node that the surface moves with.
    pub transform_id: __m256i,
}

impl Geometry {
    /// Surfaces at eight hits.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn at(on: &On<'_>) -> Self {
        let [u, v, _, _] = columns::<1, _>(&on.hits);
        let w = _mm256_sub_ps(_mm256_sub_ps(_mm256_set1_ps(1.0), u), v);
        let [v0x, v0y, v0z, _] = columns::<0, _>(&on.triangles);
        let [e1x, e1y, e1z, _] = columns::<4, _>(&on.triangles);
        let [e2x, e2y, e2z, moves] = columns::<8, _>(&on.triangles);
        let (v0, e1, e2) = ([v0x, v0y, v0z], [e1x, e1y, e1z], [e2x, e2y, e2z]);
        let same = all_same(&on.instances);
        let to_world = [
            columns_where::<12, _>(&on.instances, same),
            columns_where::<16, _>(&on.instances, same),
            columns_where::<20, _>(&on.instances, same),
        ];
        let local = sum(&sum(&v0, &scaled(&e1, u)), &scaled(&e2, v));
        let reach = sum(&sum(&magnitudes(&v0), &magnitudes(&e1)), &magnitudes(&e2));
        let along = |[x, y, z, w]: [__m256; 4]| _mm256_add_ps(dot(&[x, y, z], &local), w);
        let far = |[x, y, z, w]: [__m256; 4]| {
            _mm256_add_ps(dot(&magnitudes(&[x, y, z]), &reach), magnitude(w))
        };
        let largest = larger(larger(far(to_world[0]), far(to_world[1])), far(to_world[2]));
        let place = [
            along(to_world[0]),
            along(to_world[1]),
            along(to_world[2]),
            _mm256_mul_ps(largest, _mm256_set1_ps(surface::OFFSET)),
        ];
        let to_object = [
            columns_where::<0, _>(&on.instances, same),
            columns_where::<4, _>(&on.instances, same),
            columns_where::<8, _>(&on.instances, same),
        ];
        let area = leveled(&cross(&e1, &e2));
        let face = normalized(&leveled(&map_transposed(&to_object, &area)));
        let [x, y, z, _] = columns::<4, _>(&on.rays);
        let front = _mm256_cmp_ps::<_CMP_LT_OQ>(dot(&face, &[x, y, z]), _mm256_setzero_ps());
        let [n0, n1, n2, smooth] = columns::<0, _>(&on.corners);
        let smooth = has_any(_mm256_castps_si256(smooth), u32::MAX);
        let mut shading = face;
        if _mm256_movemask_ps(smooth) != 0 {
            let first = unpack(n0);
            // Mostly all of a triangle's corners have the same normal.
            let (second, third) = match _mm256_movemask_ps(are_equal(n0, n1, n2)) {
                0xff => (first, first),
                _ => (unpack(n1), unpack(n2)),
            };
            let mixed = sum(
                &sum(&scaled(&first, w), &scaled(&second, u)),
                &scaled(&third, v),
            );
            let mapped = map_transposed(&to_object, &mixed);
            let some = _mm256_cmp_ps::<_CMP_GT_OQ>(dot(&mapped, &mapped), _mm256_setzero_ps());
            let known = either(_mm256_and_ps(some, smooth), &normalized(&mapped), &face);
            let against = _mm256_cmp_ps::<_CMP_LT_OQ>(dot(&known, &face), _mm256_setzero_ps());
            shading = turned(&known, _mm256_and_ps(against, smooth));
        }
        let back = inverted(front);
        let [_, _, instance_moves, _] = columns_where::<24, _>(&on.instances, same);
        Geometry {
            place,
            normals: [pack(&turned(&face, back)), pack(&turned(&shading, back))],
            front,
            uv: uv_at(&on.corners, u, v, w),
            transform_id: _mm256_castps_si256(_mm256_blendv_ps(
                moves,
                instance_moves,
                is_word(_mm256_castps_si256(moves), NONE),
            )),
        }
    }
}

/// Lanes in which three words are the same.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn are_equal(a: __m256, b: __m256, c: __m256) -> __m256 {
    let same = |a, b| _mm256_cmpeq_epi32(_mm256_castps_si256(a), _mm256_castps_si256(b));
    _mm256_castsi256_ps(_mm256_and_si256(same(a, b), same(a, c)))
}

/// [`crate::stages::trace_closest::uv_at`].
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn uv_at(corners: &[&Corners; 8], u: __m256, v: __m256, w: __m256) -> [__m256; 2] {
    let [ax, ay, bx, by] = columns::<4, _>(corners);
    let [_, _, cx, cy] = columns::<6, _>(corners);
    let mixed = |a, b, c| {
        let ab = _mm256_add_ps(_mm256_mul_ps(a, w), _mm256_mul_ps(b, u));
        _mm256_add_ps(ab, _mm256_mul_ps(c, v))
    };
    [mixed(ax, bx, cx), mixed(ay, by, cy)]
}

/// [`crate::stages::resolve_hits::leveled`].
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn leveled(v: &Lanes3) -> Lanes3 {
    let [x, y, z] = magnitudes(v);
    let largest = _mm256_castps_si256(_mm256_max_ps(_mm256_max_ps(x, y), z));
    let exponent = _mm256_min_epi32(_mm256_srli_epi32::<23>(largest), _mm256_set1_epi32(253));
    let factor = _mm256_slli_epi32::<23>(_mm256_sub_epi32(_mm256_set1_epi32(254), exponent));
    scaled(v, _mm256_castsi256_ps(factor))
}

#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn cross(a: &Lanes3, b: &Lanes3) -> Lanes3 {
    let part =
        |i: usize, j: usize| _mm256_sub_ps(_mm256_mul_ps(a[i], b[j]), _mm256_mul_ps(b[i], a[j]));
    [part(1, 2), part(2, 0), part(0, 1)]
}
