// The next segment of each pixel's path: a new path at the primary surface where the last one has ended and samples
// are left; a ray of no length for a pixel without work.
import package::hash::{hash_hash3, hash_pcg, hash_unit};
import package::invocation::invocation_index;
import package::octahedral::octahedral_unpack;
import package::sampling::{sampling_cosine_hemisphere, sampling_start, sampling_to_world};
import package::surface::surface_is_surface;
import package::types::{F32_MAX, Frame, Ray, ReferencePath, SurfacePoint};

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> primary: array<SurfacePoint>;
@group(0) @binding(2) var<storage, read_write> vertices: array<SurfacePoint>;
@group(0) @binding(3) var<storage, read_write> paths: array<ReferencePath>;
@group(0) @binding(4) var<storage, read_write> rays: array<Ray>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = invocation_index(group, groups, 64u, lane);
    if i >= arrayLength(&primary) {
        return;
    }
    var path = paths[i];
    var vertex = vertices[i];
    var ray = Ray(vec3<f32>(), 0.0, vec3<f32>(0.0, 0.0, 1.0), 0.0);
    if path.segment == 0u && path.done < frame.samples && surface_is_surface(primary[i]) {
        vertex = primary[i];
        vertices[i] = vertex;
        path.scale = vec3<f32>(1.0);
        path.sample = vec3<f32>();
        path.segment = 1u;
        path.seed = hash_hash3(i, path.done, frame.seed);
    }
    if path.segment != 0u {
        let first = hash_pcg(path.seed);
        let second = hash_pcg(first);
        path.seed = second;
        let normal = octahedral_unpack(vertex.shading_normal);
        let local = sampling_cosine_hemisphere(hash_unit(first), hash_unit(second));
        let direction = sampling_to_world(local, normal);
        let geometric = octahedral_unpack(vertex.geometric_normal);
        let origin = sampling_start(vertex.position, geometric, vertex.offset, 0.0, direction);
        ray = Ray(origin, 0.0, direction, F32_MAX);
    }
    paths[i] = path;
    rays[i] = ray;
}
