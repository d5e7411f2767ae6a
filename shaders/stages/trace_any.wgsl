// Writes 1 for each ray that nothing stops between `t_min` and `t_max`, else 0.
import package::invocation::invocation_index;
@if(RAY_QUERY) import package::trace_query::trace_walk;
@else import package::trace::trace_walk;
import package::types::{BvhNode, Corners, DispatchArgs, Instance, Material, NONE, Ray, Triangle};

@group(0) @binding(0) var<uniform> batch: DispatchArgs;
@group(0) @binding(1) var<storage, read> nodes: array<BvhNode>;
@group(0) @binding(2) var<storage, read> triangles: array<Triangle>;
@group(0) @binding(3) var<storage, read> instances: array<Instance>;
@if(corners) @group(0) @binding(4) var<storage, read> corners: array<Corners>;
@if(materials) @group(0) @binding(5) var<storage, read> materials: array<Material>;
@if(texels) @group(0) @binding(6) var<storage, read> texels: array<u32>;
@group(0) @binding(7) var<storage, read> rays: array<Ray>;
@group(0) @binding(8) var<storage, read_write> visible: array<u32>;
@if(RAY_QUERY) @group(0) @binding(9) var structure: acceleration_structure;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = invocation_index(workgroup, groups, 64u, lane);
    if i >= batch.count {
        return;
    }
    let ray = rays[i];
    var free = 1u;
    if ray.t_max > 0.0 && trace_walk(ray, true).instance != NONE {
        free = 0u;
    }
    visible[i] = free;
}
