// Finds the closest hit of each ray in the two-level BVH; of equal distances the smallest (instance, triangle).
import package::invocation::invocation_index;
@if(RAY_QUERY) import package::trace_query::trace_walk;
@else import package::trace::trace_walk;
import package::types::{BvhNode, Corners, DispatchArgs, Hit, Instance, Material, Ray, Triangle};

@group(0) @binding(0) var<uniform> batch: DispatchArgs;
@group(0) @binding(1) var<storage, read> nodes: array<BvhNode>;
@group(0) @binding(2) var<storage, read> triangles: array<Triangle>;
@group(0) @binding(3) var<storage, read> instances: array<Instance>;
@if(corners) @group(0) @binding(4) var<storage, read> corners: array<Corners>;
@if(materials) @group(0) @binding(5) var<storage, read> materials: array<Material>;
@if(texels) @group(0) @binding(6) var<storage, read> texels: array<u32>;
@group(0) @binding(7) var<storage, read> rays: array<Ray>;
@group(0) @binding(8) var<storage, read_write> hits: array<Hit>;
@if(RAY_QUERY) @group(0) @binding(9) var structure: acceleration_structure;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let within = invocation_index(workgroup, groups, 64u, lane);
    if within >= batch.count {
        return;
    }
    let i = batch.first + within;
    hits[i] = trace_walk(rays[i], false);
}
