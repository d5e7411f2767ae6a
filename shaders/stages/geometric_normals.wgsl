// Which way the surfaces of an engine's G-buffer face. One invocation per pixel.
import package::gbuffer::{gbuffer_position, gbuffer_sides, gbuffer_view_depth};
import package::octahedral::{octahedral_pack, octahedral_unpack};
import package::types::{Camera, HostGbuffer, SurfacePoint};
import package::vector::{vector_cross, vector_length};

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> host: HostGbuffer;
@group(0) @binding(2) var depth: texture_2d<f32>;
@group(0) @binding(3) var<storage, read_write> points: array<SurfacePoint>;

/// A point some texels away along one axis, and how much deeper it is.
struct Neighbour {
    position: vec3<f32>,
    deeper: f32,
    there: bool,
}

fn neighbour(at: vec2<u32>, z: f32, dx: i32, dy: i32) -> Neighbour {
    let other = vec2<i32>(at) + vec2<i32>(dx, dy);
    if any(other < vec2<i32>(0)) || any(other >= vec2<i32>(i32(camera.width), i32(camera.height))) {
        return Neighbour(vec3<f32>(), 0.0, false);
    }
    let place = vec2<u32>(other);
    let found = textureLoad(depth, place, 0).x;
    if found == host.depth_clear {
        return Neighbour(vec3<f32>(), 0.0, false);
    }
    let here = gbuffer_view_depth(z, host);
    let behind = gbuffer_view_depth(found, host);
    return Neighbour(gbuffer_position(place, found, camera, host), abs(behind - here), true);
}

/// Most that a point's offset may be over the way to a neighbour for the normal between the two to count.
const CERTAIN: f32 = 0.125;

/// The way to the nearer of two neighbours, along the positive axis.
fn way(position: vec3<f32>, before: Neighbour, after: Neighbour) -> vec3<f32> {
    if before.there && (!after.there || before.deeper < after.deeper) {
        return position - before.position;
    }
    if after.there {
        return after.position - position;
    }
    return vec3<f32>();
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = id.xy;
    if at.x >= camera.width || at.y >= camera.height {
        return;
    }
    let i = at.y * camera.width + at.x;
    if points[i].transform_id == 0xffffffffu {
        return;
    }
    let z = textureLoad(depth, at, 0).x;
    let position = points[i].position;
    let given = octahedral_unpack(points[i].shading_normal);
    let across = way(position, neighbour(at, z, -1, 0), neighbour(at, z, 1, 0));
    let down = way(position, neighbour(at, z, 0, -1), neighbour(at, z, 0, 1));
    // Far away the steps of a depth buffer are as wide as pixels, and make any plane of a smooth surface.
    let shortest = min(vector_length(across), vector_length(down));
    let is_certain = points[i].offset <= CERTAIN * shortest;
    let flat = select(vec3<f32>(), vector_cross(down, across), is_certain);
    let sides = gbuffer_sides(flat, given, position - camera.eye);
    points[i].geometric_normal = octahedral_pack(sides.geometric);
    points[i].shading_normal = octahedral_pack(sides.shading);
}
