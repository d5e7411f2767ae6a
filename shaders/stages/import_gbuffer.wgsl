// An engine's G-buffer as surface points. One invocation per pixel.
import package::gbuffer::{gbuffer_facing, gbuffer_normal, gbuffer_offset, gbuffer_position};
import package::octahedral::octahedral_pack;
import package::surface::{surface_miss, surface_pack_albedo};
import package::types::{Camera, HostGbuffer, SurfacePoint};

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> host: HostGbuffer;
@group(0) @binding(2) var depth: texture_2d<f32>;
@group(0) @binding(3) var normal: texture_2d<f32>;
@group(0) @binding(4) var albedo: texture_2d<f32>;
@group(0) @binding(5) var ids: texture_2d<u32>;
@group(0) @binding(6) var<storage, read_write> points: array<SurfacePoint>;

fn point(at: vec2<u32>) -> SurfacePoint {
    let z = textureLoad(depth, at, 0).x;
    let id = textureLoad(ids, at, 0).x;
    if z == host.depth_clear || id >= host.nodes {
        return surface_miss();
    }
    let position = gbuffer_position(at, z, camera, host);
    let given = gbuffer_normal(textureLoad(normal, at, 0), host);
    let packed_normal = octahedral_pack(gbuffer_facing(given, position - camera.eye));
    let packed = surface_pack_albedo(textureLoad(albedo, at, 0).xyz, 0u);
    return SurfacePoint(
        position,
        gbuffer_offset(position, z, camera, host),
        packed_normal,
        packed_normal,
        packed.x,
        packed.y,
        vec3<f32>(),
        id,
    );
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x < camera.width && at.y < camera.height {
        points[at.y * camera.width + at.x] = point(at.xy);
    }
}
