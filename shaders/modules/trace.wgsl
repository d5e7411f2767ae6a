// Traversal of the two-level tree, in software; `trace_query` has the other body of `trace_walk`. Reads the stage's globals `nodes`, `triangles` and `instances`; where the stage binds
// `materials`, also `corners` and those of `texture`, for the alpha test.
import package::affine::{affine_map_point, affine_map_vector};
import package::intersect::{intersect_box, intersect_inverse, intersect_is_sound, intersect_triangle};
@if(materials && corners) import package::texture::{texture_stops, texture_uv_at};
import package::types::{Hit, NONE, Ray};

/// Inner nodes above a leaf of both levels together, at most.
const TRACE_STACK: u32 = 64u;
/// Bit of a triangle's material: the alpha test decides whether a hit counts.
const TRACE_ALPHA_TEST: u32 = 0x80000000u;

/// A miss of a ray that ends at `t_max`.
fn trace_miss(t_max: f32) -> Hit {
    return Hit(t_max, 0.0, 0.0, NONE, NONE);
}

/// The alpha test.
@if(materials && corners)
fn trace_stops(ray: Ray, index: u32, u: f32, v: f32) -> bool {
    let material = triangles[index].material_flags & ~TRACE_ALPHA_TEST;
    let uv = texture_uv_at(corners[triangles[index].primitive].uvs, u, v);
    return texture_stops(material, uv, ray, index);
}
@else
fn trace_stops(ray: Ray, index: u32, u: f32, v: f32) -> bool {
    return true;
}

/// The closest hit; of equal distances the smallest (instance, triangle). With `any`, the first hit that is found.
///
/// One loop walks both levels, the nearer child first; `base` is the stack's size where the bottom level began.
@if(!RAY_QUERY)
fn trace_walk(ray: Ray, any: bool) -> Hit {
    var best = trace_miss(ray.t_max);
    if !intersect_is_sound(ray.origin, ray.direction) {
        return best;
    }
    let world_inverse = intersect_inverse(ray.direction);
    var origin = ray.origin;
    var direction = ray.direction;
    var inverse = world_inverse;
    var instance = NONE;
    var instance_near = 0.0;
    var stack_nodes: array<u32, TRACE_STACK>;
    var stack_nears: array<f32, TRACE_STACK>;
    var size = 0u;
    var base = 0u;
    let root = intersect_box(nodes[0].min, nodes[0].max, origin, inverse, ray.t_min);
    if !(root.x <= min(root.y, best.t)) {
        return best;
    }
    var near = root.x;
    var first = nodes[0].first;
    var count = nodes[0].count;
    loop {
        var descend = false;
        if count == 0u {
            let left = nodes[first];
            let right = nodes[first + 1u];
            let a = intersect_box(left.min, left.max, origin, inverse, ray.t_min);
            let b = intersect_box(right.min, right.max, origin, inverse, ray.t_min);
            let hits_a = a.x <= min(a.y, best.t);
            let hits_b = b.x <= min(b.y, best.t);
            let to_right = hits_b && (!hits_a || b.x < a.x);
            if hits_a && hits_b {
                stack_nodes[size] = select(first + 1u, first, to_right);
                stack_nears[size] = select(b.x, a.x, to_right);
                size++;
            }
            descend = hits_a || hits_b;
            near = select(a.x, b.x, to_right);
            first = select(left.first, right.first, to_right);
            count = select(left.count, right.count, to_right);
        } else if instance == NONE {
            // A leaf of the top level: go on at the root of its instance, in the instance's space.
            instance = first;
            instance_near = near;
            base = size;
            let rows = instances[instance].world_to_object;
            origin = affine_map_point(rows, ray.origin);
            direction = affine_map_vector(rows, ray.direction);
            inverse = intersect_inverse(direction);
            let node = nodes[instances[instance].root];
            let entry = intersect_box(node.min, node.max, origin, inverse, ray.t_min);
            descend = intersect_is_sound(origin, direction) && entry.x <= min(entry.y, best.t);
            near = entry.x;
            first = node.first;
            count = node.count;
        } else {
            for (var index = first; index < first + count; index++) {
                let triangle = triangles[index];
                let hit = intersect_triangle(triangle, origin, direction, inverse, ray.t_min);
                if hit.t < 0.0 {
                    continue;
                }
                let t = max(hit.t, instance_near);
                let before = instance < best.instance || (instance == best.instance && index < best.triangle);
                if (t < best.t || (t == best.t && before))
                    && ((triangle.material_flags & TRACE_ALPHA_TEST) == 0u || trace_stops(ray, index, hit.u, hit.v)) {
                    best = Hit(t, hit.u, hit.v, index, instance);
                    if any {
                        return best;
                    }
                }
            }
        }
        // Otherwise take the last node that was left behind and is still near enough.
        while !descend {
            if size == base && instance != NONE {
                instance = NONE;
                base = 0u;
                origin = ray.origin;
                direction = ray.direction;
                inverse = world_inverse;
            }
            if size == 0u {
                return best;
            }
            size--;
            near = stack_nears[size];
            if near <= best.t {
                let node = stack_nodes[size];
                first = nodes[node].first;
                count = nodes[node].count;
                descend = true;
            }
        }
    }
    return best;
}
