//! `*/resolve_hits`: what the surface is like where each ray hit.
use super::trace_closest::uv_at;
use crate::data::{Corners, Hit, Instance, Material, NONE, Ray, SurfacePoint, Triangle};
use crate::shared::{octahedral, surface, texture};
use crate::simd;
use gibs_graph::{DispatchArgs, Workgroup, stage};
use glam::{Vec3, Vec4};
use std::ops::Range;

stage! {
    /// Position, normals, albedo, emission and transform id of each hit. Normals face the ray; emission leaves the
    /// front only, or both sides of a two-sided material.
    pub stage ResolveHits {
        wgsl: gibs_shaders::stages::RESOLVE_HITS,
        workgroup: [64, 1, 1],
        ports: {
            uniform batch: DispatchArgs,
            read rays: Ray,
            read hits: Hit,
            read triangles: Triangle,
            read instances: Instance,
            read corners: Corners,
            read materials: Material,
            optional_read texels: u32,
            write points: SurfacePoint,
        },
        cpu: kernel,
        wide: Some(wide_kernel),
    }
}

#[inline]
fn xyz(v: Vec4) -> Vec3 {
    Vec3::new(v.x, v.y, v.z)
}

/// An affine map given by rows, applied to a point.
#[inline]
pub fn map_point(rows: &[Vec4; 3], p: Vec3) -> Vec3 {
    Vec3::new(
        xyz(rows[0]).dot(p) + rows[0].w,
        xyz(rows[1]).dot(p) + rows[1].w,
        xyz(rows[2]).dot(p) + rows[2].w,
    )
}

/// A vector times the power of two that brings its largest component to between 1 and 2: its direction to the same digits, of a
/// length whose square is a number. The square of a triangle's area times a node's scale need not be one.
#[inline]
pub fn leveled(v: Vec3) -> Vec3 {
    let exponent = (v.abs().max_element().to_bits() >> 23).min(253);
    v * f32::from_bits((254 - exponent) << 23)
}

/// The transpose of a linear map given by rows, applied to a vector. With the inverse map's rows, this maps normals.
#[inline]
pub fn map_transposed(rows: &[Vec4; 3], v: Vec3) -> Vec3 {
    xyz(rows[0]) * v.x + xyz(rows[1]) * v.y + xyz(rows[2]) * v.z
}

/// Magnitude of the numbers that made a position: where each coordinate's rounding error comes from.
#[inline]
fn magnitude(rows: &[Vec4; 3], reach: Vec3) -> f32 {
    let row = |r: Vec4| xyz(r).abs().dot(reach) + r.w.abs();
    row(rows[0]).max(row(rows[1])).max(row(rows[2]))
}

/// What hits are looked up in.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    /// Triangles, in the order of the tree.
    pub triangles: &'a [Triangle],
    /// Instances.
    pub instances: &'a [Instance],
    /// Vertices of the triangles, by primitive.
    pub corners: &'a [Corners],
    /// Materials.
    pub materials: &'a [Material],
    /// Texels of all textures; empty where there are none.
    pub texels: &'a [u32],
}

fn scene<'a>(p: &Views<'a>) -> Scene<'a> {
    Scene {
        triangles: p.triangles.slice(),
        instances: p.instances.slice(),
        corners: p.corners.slice(),
        materials: p.materials.slice(),
        texels: p.texels.slice(),
    }
}

fn wide_kernel(p: &Views<'_>, group: Workgroup) {
    let (range, set) = (group.range(p.batch.count), |i, point| {
        p.points.set(i, point)
    });
    simd::resolve_hits(&scene(p), &p.rays, &p.hits, range, set);
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    let (range, set) = (group.range(p.batch.count), |i, point| {
        p.points.set(i, point)
    });
    resolve_each(&scene(p), &p.rays, &p.hits, range, set);
}

/// Calls `set` with each index of a range and what is where the ray of this index hit.
#[inline]
pub fn resolve_each(
    scene: &Scene<'_>,
    rays: &[Ray],
    hits: &[Hit],
    range: Range<usize>,
    mut set: impl FnMut(usize, SurfacePoint),
) {
    for i in range {
        let hit = &hits[i];
        set(
            i,
            if hit.instance == NONE {
                surface::MISS
            } else {
                resolve(scene, rays[i].direction, hit)
            },
        );
    }
}

/// The surface at a hit of a ray in a direction.
pub fn resolve(scene: &Scene<'_>, direction: Vec3, hit: &Hit) -> SurfacePoint {
    let triangle = &scene.triangles[hit.triangle as usize];
    let instance = &scene.instances[hit.instance as usize];
    let corners = &scene.corners[triangle.primitive as usize];
    let material = &scene.materials[triangle.material() as usize];
    let local = triangle.v0 + triangle.e1 * hit.u + triangle.e2 * hit.v;
    let position = map_point(&instance.object_to_world, local);
    let reach = triangle.v0.abs() + triangle.e1.abs() + triangle.e2.abs();
    let offset = magnitude(&instance.object_to_world, reach) * surface::OFFSET;
    // The counter-clockwise side; a mirroring map turns the winding, not the side.
    let area = leveled(triangle.e1.cross(triangle.e2));
    let face = leveled(map_transposed(&instance.world_to_object, area)).normalize();
    let front = face.dot(direction) < 0.0;
    let side = if front { 1.0 } else { -1.0 };
    let mut smooth = face;
    if corners.smooth != 0 {
        let normal = |corner: usize| octahedral::unpack(corners.normals[corner]);
        let (a, b, c) = (normal(0), normal(1), normal(2));
        let mixed = a * (1.0 - hit.u - hit.v) + b * hit.u + c * hit.v;
        let mapped = map_transposed(&instance.world_to_object, mixed);
        if mapped.dot(mapped) > 0.0 {
            smooth = mapped.normalize();
        }
        // A vertex normal that contradicts the winding is taken for the same side.
        if smooth.dot(face) < 0.0 {
            smooth = -smooth;
        }
    }
    let uv = uv_at(corners, hit.u, hit.v);
    let color = texture::base_color(material, scene.texels, uv);
    let shines = front || material.flags & texture::DOUBLE_SIDED != 0;
    let emission = if shines {
        texture::emission(material, scene.texels, uv)
    } else {
        Vec3::ZERO
    };
    let emitter = if shines && texture::is_sampled_emitter(material) {
        surface::EMITTER
    } else {
        0
    };
    let (albedo_rg, albedo_b_flags) = surface::pack_albedo(xyz(color), emitter);
    let transform_id = if triangle.transform_id == NONE {
        instance.transform_id
    } else {
        triangle.transform_id
    };
    SurfacePoint {
        position,
        offset,
        geometric_normal: octahedral::pack(face * side),
        shading_normal: octahedral::pack(smooth * side),
        albedo_rg,
        albedo_b_flags,
        emission,
        transform_id,
    }
}
