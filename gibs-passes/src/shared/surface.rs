//! Packing of [`SurfacePoint`]s.
use crate::data::{NONE, SurfacePoint};
use glam::{Vec3, Vec4};

/// Flag: the emission has no texture, so that emitter sampling covers it.
pub const EMITTER: u32 = 1 << 16;

/// Rays start off a surface by this share of the magnitude of the coordinates that its position came from: 2^-19,
/// sixteen times the rounding error of three vertex coordinates taken through an affine map.
pub const OFFSET: f32 = 1.0 / 524_288.0;

/// A number in `[0, 1]` as 16 bits, rounded.
#[inline]
pub fn unorm16(x: f32) -> u32 {
    (x.clamp(0.0, 1.0) * 65_535.0 + 0.5).floor() as u32
}

/// Albedo and flags in two words.
#[inline]
pub fn pack_albedo(albedo: Vec3, flags: u32) -> (u32, u32) {
    (
        unorm16(albedo.x) | (unorm16(albedo.y) << 16),
        unorm16(albedo.z) | flags,
    )
}

/// Albedo of a point.
#[inline]
pub fn albedo(point: &SurfacePoint) -> Vec3 {
    let part = |bits: u32| (bits & 0xffff) as f32;
    // A product with the reciprocal would be another number where a driver folds it into the next one. One division of four
    // numbers takes as long as one of one.
    let steps = Vec4::new(
        part(point.albedo_rg),
        part(point.albedo_rg >> 16),
        part(point.albedo_b_flags),
        0.0,
    );
    (steps / 65_535.0).truncate()
}

/// The ray hit something.
#[inline]
pub fn is_surface(point: &SurfacePoint) -> bool {
    point.transform_id != NONE
}

/// A point where a ray missed.
pub const MISS: SurfacePoint = SurfacePoint {
    position: Vec3::ZERO,
    offset: 0.0,
    geometric_normal: 0,
    shading_normal: 0,
    albedo_rg: 0,
    albedo_b_flags: 0,
    emission: Vec3::ZERO,
    transform_id: NONE,
};
