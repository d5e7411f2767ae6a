// Packing of surface points.
import package::types::{NONE, SurfacePoint};

/// Flag: the emission has no texture, so that emitter sampling covers it.
const SURFACE_EMITTER: u32 = 0x10000u;
/// Rays start off a surface by this share of the magnitude of the coordinates that its position came from.
const SURFACE_OFFSET: f32 = 1.0 / 524288.0;

/// A number in `[0, 1]` as 16 bits, rounded.
fn surface_unorm16(x: f32) -> u32 {
    return u32(floor(clamp(x, 0.0, 1.0) * 65535.0 + 0.5));
}

/// Albedo and flags in two words.
fn surface_pack_albedo(albedo: vec3<f32>, flags: u32) -> vec2<u32> {
    return vec2<u32>(
        surface_unorm16(albedo.x) | (surface_unorm16(albedo.y) << 16u),
        surface_unorm16(albedo.z) | flags,
    );
}

/// Albedo of a point.
fn surface_albedo(point: SurfacePoint) -> vec3<f32> {
    let low = vec3<u32>(point.albedo_rg, point.albedo_rg >> 16u, point.albedo_b_flags) & vec3<u32>(0xffffu);
    return vec3<f32>(low) / 65535.0;
}

/// The ray hit something.
fn surface_is_surface(point: SurfacePoint) -> bool {
    return point.transform_id != NONE;
}

/// A point where a ray missed.
fn surface_miss() -> SurfacePoint {
    return SurfacePoint(vec3<f32>(), 0.0, 0u, 0u, 0u, 0u, vec3<f32>(), NONE);
}
