// The next segment of each path that goes on: packed, in order, with a ray over the cosine lobe where it is.
import package::hash::{hash_pcg, hash_unit};
import package::invocation::invocation_index;
import package::octahedral::octahedral_unpack;
import package::sampling::{sampling_cosine_hemisphere, sampling_start, sampling_to_world};
import package::types::{DispatchArgs, F32_MAX, Path, Ray, SurfacePoint};

@group(0) @binding(0) var<uniform> batch: DispatchArgs;
@group(0) @binding(1) var<storage, read> points: array<SurfacePoint>;
@group(0) @binding(2) var<storage, read> paths: array<Path>;
@group(0) @binding(3) var<storage, read> goes_on: array<u32>;
@group(0) @binding(4) var<storage, read> scanned: array<u32>;
@group(0) @binding(5) var<storage, read_write> next_rays: array<Ray>;
@group(0) @binding(6) var<storage, read_write> next_paths: array<Path>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = invocation_index(group, groups, 64u, lane);
    if i >= batch.count {
        return;
    }
    if goes_on[i] == 0u {
        return;
    }
    let point = points[i];
    var path = paths[i];
    let first = hash_pcg(path.seed);
    let second = hash_pcg(first);
    let normal = octahedral_unpack(point.shading_normal);
    let local = sampling_cosine_hemisphere(hash_unit(first), hash_unit(second));
    let direction = sampling_to_world(local, normal);
    let geometric = octahedral_unpack(point.geometric_normal);
    let origin = sampling_start(point.position, geometric, point.offset, direction);
    let slot = scanned[i];
    next_rays[slot] = Ray(origin, 0.0, direction, F32_MAX);
    path.seed = second;
    path.remaining -= 1u;
    next_paths[slot] = path;
}
