// Decoding of an engine's G-buffer.
import package::octahedral::octahedral_decode;
import package::surface::SURFACE_OFFSET;
import package::types::{Camera, HostGbuffer};
import package::vector::{vector_dot, vector_max_element, vector_normalize};

/// Normals from 0 to 1.
const GBUFFER_NORMALS_UNSIGNED: u32 = 1u;
/// Octahedral normals, from -1 to 1.
const GBUFFER_NORMALS_OCTAHEDRAL: u32 = 2u;
/// A normal from depths is believed where the cosine to the normal given is at least this.
const GBUFFER_AGREEMENT: f32 = 0.5;
/// Distance of 1 to the next float.
const GBUFFER_EPSILON: f32 = 1.1920929e-7;

/// Distance along the viewing axis of a depth in the buffer.
fn gbuffer_view_depth(z: f32, host: HostGbuffer) -> f32 {
    return host.depth_scale / (z - host.depth_offset);
}

/// Where a pixel's surface is, relative to the floating origin.
fn gbuffer_position(at: vec2<u32>, z: f32, camera: Camera, host: HostGbuffer) -> vec3<f32> {
    let x = f32(at.x) + 0.5 - host.jitter.x;
    let y = f32(at.y) + 0.5 - host.jitter.y;
    let across = x / f32(camera.width) * 2.0 - 1.0;
    let upwards = 1.0 - y / f32(camera.height) * 2.0;
    let ray = camera.forward + camera.right * across + camera.up * upwards;
    return camera.eye + ray * gbuffer_view_depth(z, host);
}

/// Distance by which rays start off the surface.
fn gbuffer_offset(position: vec3<f32>, z: f32, camera: Camera, host: HostGbuffer) -> f32 {
    let reach = vector_max_element(max(abs(position), abs(camera.eye)));
    let d = gbuffer_view_depth(z, host);
    let step = host.depth_step + abs(z) * GBUFFER_EPSILON;
    return reach * SURFACE_OFFSET + 2.0 * (d * d / abs(host.depth_scale) * step);
}

/// The normal that the engine gives.
fn gbuffer_normal(texel: vec4<f32>, host: HostGbuffer) -> vec3<f32> {
    if host.normals == GBUFFER_NORMALS_OCTAHEDRAL {
        return octahedral_decode(texel.xy);
    }
    let v = select(texel.xyz, texel.xyz * 2.0 - 1.0, host.normals == GBUFFER_NORMALS_UNSIGNED);
    if vector_dot(v, v) > 0.0 {
        return vector_normalize(v);
    }
    return vec3<f32>(0.0, 0.0, 1.0);
}

fn gbuffer_facing(n: vec3<f32>, seen: vec3<f32>) -> vec3<f32> {
    return select(n, -n, vector_dot(n, seen) > 0.0);
}

/// Geometric and shading normal.
struct GbufferSides {
    geometric: vec3<f32>,
    shading: vec3<f32>,
}

/// Normals on the side that is seen: `flat` is that of the depths, of any length, `seen` the way from the eye.
fn gbuffer_sides(flat_normal: vec3<f32>, given: vec3<f32>, seen: vec3<f32>) -> GbufferSides {
    if vector_dot(flat_normal, flat_normal) > 0.0 {
        let geometric = gbuffer_facing(vector_normalize(flat_normal), seen);
        let shading = select(given, -given, vector_dot(given, geometric) < 0.0);
        if vector_dot(shading, geometric) >= GBUFFER_AGREEMENT {
            return GbufferSides(geometric, shading);
        }
    }
    let facing = gbuffer_facing(given, seen);
    return GbufferSides(facing, facing);
}
