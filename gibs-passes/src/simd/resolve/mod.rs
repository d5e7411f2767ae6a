//! Surfaces at hits, eight at a time: [`crate::stages::resolve_hits::resolve`], operation for operation.
//!
//! What a hit needs lies anywhere in memory, each part known by the one before. It is asked for part by part, for as many
//! hits at once as a workgroup has; what needs no texture is done while the texels come.
#![allow(unsafe_code)]
mod geometry;
mod texture;

#[cfg(test)]
mod tests;

use std::arch::x86_64::*;
use std::mem::MaybeUninit;
use std::ops::Range;

use super::lanes::{
    Lanes3, all_same, columns_where, for_lanes, has_any, inverted, is_word, loaded, selected,
    store_columns, stored,
};
use super::{Avx2, prefetch};
use crate::data::{Hit, Material, NONE, Ray, SurfacePoint};
use crate::shared::{surface, texture as scalar};
use crate::stages::resolve_hits::{Scene, resolve_each};
use bytemuck::Zeroable;
use geometry::{Geometry, On};
use glam::{Vec2, Vec3};
use texture::{Picks, unorm16};

/// Hits that are asked for at once.
const BATCH: usize = 64;

/// Calls `set` with each index of a range, in whatever order, and what is where the ray of this index hit.
#[inline]
pub fn resolve_hits(
    scene: &Scene<'_>,
    rays: &[Ray],
    hits: &[Hit],
    range: Range<usize>,
    set: impl FnMut(usize, SurfacePoint),
) {
    match Avx2::detect() {
        // SAFETY: there is a proof that the processor has the features.
        Some(Avx2 { .. }) => unsafe { resolve_wide(scene, rays, hits, range, set) },
        None => resolve_each(scene, rays, hits, range, set),
    }
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn resolve_wide(
    scene: &Scene<'_>,
    rays: &[Ray],
    hits: &[Hit],
    range: Range<usize>,
    mut set: impl FnMut(usize, SurfacePoint),
) {
    for first in range.clone().step_by(BATCH) {
        let batch = first..range.end.min(first + BATCH);
        let mut found = [0; BATCH];
        let mut count = 0;
        for i in batch {
            let hit = &hits[i];
            if hit.instance == NONE {
                set(i, surface::MISS);
                continue;
            }
            prefetch(scene.triangles, hit.triangle as usize);
            found[count % BATCH] = i;
            count += 1;
        }
        // The last eight are filled up with hits that there are.
        let filler = found[0];
        let eights = count.div_ceil(8);
        found[count..eights * 8].fill(filler);
        for &i in &found[..count] {
            let triangle = &scene.triangles[hits[i].triangle as usize];
            prefetch(scene.corners, triangle.primitive as usize);
        }
        let (found, _) = found.as_chunks::<8>();
        let mut begun = [const { MaybeUninit::uninit() }; BATCH / 8];
        for (ids, begun) in found[..eights].iter().zip(&mut begun) {
            begun.write(Begun::at(scene, rays, hits, ids));
        }
        for ((e, ids), begun) in found[..eights].iter().enumerate().zip(&begun) {
            // SAFETY: the loop before has written as many.
            let begun: &Begun = unsafe { begun.assume_init_ref() };
            let points = begun.finished(scene.texels);
            for (&i, &point) in ids.iter().zip(&points).take(count - e * 8) {
                set(i, point);
            }
        }
    }
}

/// Eight surfaces whose texels are on their way.
struct Begun {
    geometry: Geometry,
    picks: Picks,
    /// Emission towards the ray.
    emission: Lanes3,
    /// See [`SurfacePoint::albedo_b_flags`].
    flags: __m256i,
}

impl Begun {
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn at(scene: &Scene<'_>, rays: &[Ray], hits: &[Hit], ids: &[usize; 8]) -> Self {
        let hits = ids.map(|i| &hits[i]);
        let triangles = hits.map(|hit| &scene.triangles[hit.triangle as usize]);
        let on = On {
            hits,
            rays: ids.map(|i| &rays[i]),
            triangles,
            instances: hits.map(|hit| &scene.instances[hit.instance as usize]),
            corners: triangles.map(|triangle| &scene.corners[triangle.primitive as usize]),
        };
        let materials = triangles.map(|triangle| &scene.materials[triangle.material() as usize]);
        let geometry = Geometry::at(&on);
        let same = all_same(&materials);
        let picks = Picks::at(&materials, same, &geometry.uv);
        picks.prefetch(scene.texels);
        let [r, g, b, material_flags] = columns_where::<4, _>(&materials, same);
        let [_, _, _, emission_texels] = columns_where::<16, _>(&materials, same);
        let material_flags = _mm256_castps_si256(material_flags);
        let two_sided = has_any(material_flags, scalar::DOUBLE_SIDED);
        let shines = _mm256_or_ps(geometry.front, two_sided);
        let plain = is_word(_mm256_castps_si256(emission_texels), NONE);
        let opaque = inverted(has_any(material_flags, scalar::ALPHA_MODE));
        let emitter = _mm256_and_ps(shines, _mm256_and_ps(plain, opaque));
        let mut emission = [r, g, b].map(|c| _mm256_and_ps(c, shines));
        let pictured = _mm256_movemask_ps(_mm256_andnot_ps(plain, shines)) as u32;
        if pictured != 0 {
            emission =
                pictured_emission(emission, pictured, &materials, scene.texels, &geometry.uv);
        }
        Begun {
            geometry,
            picks,
            emission,
            flags: selected(emitter, surface::EMITTER),
        }
    }

    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn finished(&self, texels: &[u32]) -> [SurfacePoint; 8] {
        let [red, green, blue] = self.picks.colors(texels).map(|c| unorm16(c));
        let Geometry {
            place,
            normals,
            transform_id,
            ..
        } = self.geometry;
        let words = [
            normals[0],
            normals[1],
            _mm256_or_si256(red, _mm256_slli_epi32::<16>(green)),
            _mm256_or_si256(blue, self.flags),
        ];
        let [r, g, b] = self.emission;
        let mut points = [SurfacePoint::zeroed(); 8];
        store_columns::<0, _>(&mut points, &place);
        store_columns::<4, _>(&mut points, &words.map(|w| _mm256_castsi256_ps(w)));
        store_columns::<8, _>(&mut points, &[r, g, b, _mm256_castsi256_ps(transform_id)]);
        points
    }
}

/// Emission with [`scalar::emission`] in the lanes of a mask: few materials have a texture of it.
#[inline(never)]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn pictured_emission(
    emission: Lanes3,
    mask: u32,
    materials: &[&Material; 8],
    texels: &[u32],
    uv: &[__m256; 2],
) -> Lanes3 {
    let uv = uv.map(|c| stored(c));
    let [r, g, b] = emission.map(|c| stored(c));
    let mut emission: [Vec3; 8] = std::array::from_fn(|lane| Vec3::new(r[lane], g[lane], b[lane]));
    for_lanes(mask, |lane| {
        let at = Vec2::new(uv[0][lane], uv[1][lane]);
        emission[lane] = scalar::emission(materials[lane], texels, at);
    });
    std::array::from_fn(|axis| loaded(&emission.map(|e| e[axis])))
}
