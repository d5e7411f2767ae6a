// Traversal by ray queries of the device: the other body of `trace_walk`. The device finds triangles; where they are hit
// and whether a cut-out stops the ray, the formulas of the software traversal say. Reads what that reads, of the nodes the
// leaves of the top level alone, and the stage's global `structure`.
import package::affine::{affine_map_point, affine_map_vector};
import package::intersect::{intersect_box, intersect_inverse, intersect_is_sound, intersect_triangle};
import package::trace::{TRACE_ALPHA_TEST, trace_miss, trace_stops};
import package::types::{Hit, NONE, Ray};

enable wgpu_ray_query;

/// `RAY_FLAG_TERMINATE_ON_FIRST_HIT` of WGSL's ray queries.
const TRACE_QUERY_FIRST: u32 = 4u;

/// The hit with a triangle that the device found: the custom index is the instance's leaf in the top level, the primitive the
/// triangle in its bottom level. Where the formulas refuse the triangle, which is within rounding of its edges, what the
/// device says counts.
fn trace_query_hit(ray: Ray, inverse: vec3<f32>, found: RayIntersection) -> Hit {
    let leaf = nodes[found.instance_custom_data];
    let near = intersect_box(leaf.min, leaf.max, ray.origin, inverse, ray.t_min).x;
    let instance = leaf.first;
    let rows = instances[instance].world_to_object;
    let origin = affine_map_point(rows, ray.origin);
    let direction = affine_map_vector(rows, ray.direction);
    let index = instances[instance].first_triangle + found.primitive_index;
    let hit = intersect_triangle(triangles[index], origin, direction, intersect_inverse(direction), ray.t_min);
    if hit.t < 0.0 {
        return Hit(found.t, found.barycentrics.x, found.barycentrics.y, index, instance);
    }
    return Hit(max(hit.t, near), hit.u, hit.v, index, instance);
}

/// The closest hit; of equal distances the one that the device prefers. With `any`, the first hit that is found.
fn trace_walk(ray: Ray, any: bool) -> Hit {
    let miss = trace_miss(ray.t_max);
    // What a query may not be asked: an empty interval, or one that is not a number.
    if !(intersect_is_sound(ray.origin, ray.direction) && ray.t_min <= ray.t_max) {
        return miss;
    }
    let inverse = intersect_inverse(ray.direction);
    let flags = select(0u, TRACE_QUERY_FIRST, any);
    var query: ray_query;
    rayQueryInitialize(
        &query,
        structure,
        RayDesc(flags, 0xffu, max(ray.t_min, 0.0), ray.t_max, ray.origin, ray.direction),
    );
    // Candidates are hits with bottom levels that have cut-outs; others the device commits by itself.
    while rayQueryProceed(&query) {
        let found = rayQueryGetCandidateIntersection(&query);
        let hit = trace_query_hit(ray, inverse, found);
        if (triangles[hit.triangle].material_flags & TRACE_ALPHA_TEST) == 0u
            || trace_stops(ray, hit.triangle, hit.u, hit.v) {
            rayQueryConfirmIntersection(&query);
        }
    }
    let found = rayQueryGetCommittedIntersection(&query);
    if found.kind == RAY_QUERY_INTERSECTION_NONE {
        return miss;
    }
    let hit = trace_query_hit(ray, inverse, found);
    if hit.t <= ray.t_max {
        return hit;
    }
    return miss;
}
