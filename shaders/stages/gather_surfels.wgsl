// Irradiance at points from the surfels around them, weighted by distance, normal and depth function.
import package::gather::lookup_gather;
import package::invocation::invocation_index;
import package::octahedral::octahedral_unpack;
import package::surface::surface_is_surface;
import package::types::{
    DispatchArgs, Gathered, GridShape, SurfacePoint, SurfelLight, SurfelPose, SurfelSettings
};

@group(0) @binding(0) var<uniform> batch: DispatchArgs;
@group(0) @binding(1) var<uniform> grid: GridShape;
@group(0) @binding(2) var<uniform> settings: SurfelSettings;
@group(0) @binding(3) var<storage, read> points: array<SurfacePoint>;
@group(0) @binding(4) var<storage, read> cells: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read> entries: array<u32>;
@group(0) @binding(6) var<storage, read> poses: array<SurfelPose>;
@group(0) @binding(7) var<storage, read> light: array<SurfelLight>;
@if(depths) @group(0) @binding(8) var<storage, read> depths: array<u32>;
@if(pixels) @group(0) @binding(9) var<storage, read> pixels: array<u32>;
@group(0) @binding(10) var<storage, read_write> gathered: array<Gathered>;

/// No summed weight is enough.
const ALL: f32 = 0x1.fffffep+127f;

/// Which point an invocation looks at.
@if(pixels)
fn place(number: u32) -> u32 {
    return pixels[number];
}
@else
fn place(number: u32) -> u32 {
    return number;
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let number = invocation_index(group, groups, 64u, lane);
    if number >= batch.count {
        return;
    }
    let i = place(number);
    let point = points[i];
    var found = Gathered();
    if surface_is_surface(point) {
        let normal = octahedral_unpack(point.shading_normal);
        found = lookup_gather(point.position, normal, ALL, settings.fallback != 0u, vec3<f32>(0.0));
    }
    gathered[i] = found;
}
