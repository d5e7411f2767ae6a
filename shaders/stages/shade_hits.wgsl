// Radiance that comes back along each ray, and which paths go on.
import package::direct::direct_irradiance;
import package::mixture::{MIXTURE_SLACK, mixture_weight};
import package::octahedral::octahedral_unpack;
import package::sky::sky_radiance;
import package::emitter::emitter_density;
import package::hash::{hash_pcg, hash_unit};
import package::invocation::invocation_index;
import package::surface::{SURFACE_EMITTER, surface_albedo, surface_is_surface};
import package::types::{DispatchArgs, Frame, Gathered, Path, Ray, SurfacePoint};
import package::vector::{vector_dot, vector_max_element};

@group(0) @binding(0) var<uniform> batch: DispatchArgs;
@group(0) @binding(1) var<uniform> frame: Frame;
@group(0) @binding(2) var<storage, read> rays: array<Ray>;
@group(0) @binding(3) var<storage, read> points: array<SurfacePoint>;
@if(direct) @group(0) @binding(4) var<storage, read> direct: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read> gathered: array<Gathered>;
@if(environment) @group(0) @binding(6) var<storage, read> environment: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> paths: array<Path>;
@group(0) @binding(8) var<storage, read_write> radiance: array<vec4<f32>>;
@if(goes_on) @group(0) @binding(9) var<storage, read_write> goes_on: array<u32>;

/// No path goes on.
@if(goes_on)
const ENDS = false;
@else
const ENDS = true;

/// A bit for each path of the workgroup that goes on. Zero when it starts.
@if(goes_on)
var<workgroup> going: array<atomic<u32>, 2>;

const PATHS_PER_WORD: u32 = 32u;
const FRAC_1_PI: f32 = 0.31830987;

/// What the segment counts, by how its ray was drawn.
fn factor_of(path: Path, ray: Ray, point: SurfacePoint) -> f32 {
    let is_emitter = surface_is_surface(point) && (point.albedo_b_flags & SURFACE_EMITTER) != 0u;
    let d = point.position - ray.origin;
    let distance = sqrt(vector_dot(d, d));
    let arrives = is_emitter && distance >= ray.t_max * (1.0 - 2.0 * MIXTURE_SLACK);
    if path.density < 0.0 && !arrives {
        return 0.0;
    }
    var drawn_there = 0.0;
    if is_emitter {
        let facing = -vector_dot(octahedral_unpack(point.geometric_normal), ray.direction);
        drawn_there = emitter_density(frame, point.emission, facing, distance);
    }
    return mixture_weight(path.cosine, abs(path.density), drawn_there);
}

/// Whether the path goes on.
fn shade(i: u32) -> bool {
    let path = paths[i];
    let point = points[i];
    let factor = factor_of(path, rays[i], point);
    var goes = false;
    var added: vec3<f32>;
    if surface_is_surface(point) {
        let albedo = surface_albedo(point);
        let largest = vector_max_element(albedo);
        let seed = hash_pcg(path.seed);
        let trusted = gathered[i].weight * gathered[i].confidence;
        var arriving = direct_irradiance(i);
        if ENDS {
            // The path ends here: all that the surfels know, and the cell's average for what they leave.
            arriving += gathered[i].irradiance + gathered[i].average * (1.0 - gathered[i].weight);
        } else {
            arriving += gathered[i].irradiance * gathered[i].confidence;
        }
        if !ENDS && factor > 0.0 && hash_unit(seed) < (1.0 - trusted) * largest {
            goes = true;
            paths[i].throughput = path.throughput * factor * albedo / largest;
            paths[i].seed = seed;
        }
        added = point.emission + albedo * FRAC_1_PI * arriving;
    } else {
        added = sky_radiance(frame.environment_side, rays[i].direction);
    }
    let sum = radiance[path.root];
    radiance[path.root] = sum + vec4<f32>(path.throughput * factor * added, 0.0);
    return goes;
}

@if(goes_on)
fn shade_all(i: u32, lane: u32) {
    let is_path = i < batch.count;
    if is_path {
        if shade(i) {
            atomicOr(&going[lane / PATHS_PER_WORD], 1u << (lane % PATHS_PER_WORD));
        }
    }
    workgroupBarrier();
    if is_path && lane % PATHS_PER_WORD == 0u {
        goes_on[i / PATHS_PER_WORD] = atomicLoad(&going[lane / PATHS_PER_WORD]);
    }
}
@else
fn shade_all(i: u32, lane: u32) {
    if i < batch.count {
        shade(i);
    }
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = invocation_index(group, groups, 64u, lane);
    shade_all(i, lane);
}
