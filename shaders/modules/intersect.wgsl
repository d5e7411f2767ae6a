// Ray against box and ray against triangle: the formulas of the CPU traversal, in the same order of operations.
import package::types::{F32_MAX, Triangle};
import package::vector::{vector_cross, vector_dot};

/// Smallest magnitude of a direction component that is inverted as it stands, so that reciprocals stay finite.
const INTERSECT_SMALLEST_DIRECTION: f32 = 1e-18;
/// Largest magnitude of a ray's origin, in world and in object space.
const INTERSECT_FARTHEST_ORIGIN: f32 = 1e18;
/// `1 + 2 gamma(3)`, rounded up: makes the slab test conservative (Ize 2013, "Robust BVH Ray Traversal").
const INTERSECT_FAR_SCALE: f32 = 0x1.000008p0f;
/// Padding of boxes relative to their largest coordinate, 2^-18.
const INTERSECT_BOX_PADDING: f32 = 1.0 / 262144.0;

/// Distance, and weights of the second and third vertex; a miss has a distance below zero.
struct IntersectHit {
    t: f32,
    u: f32,
    v: f32,
}

/// Whether a ray can hit anything: it starts within reach and is finite, so that no product of what follows overflows
/// into something that is not a number.
fn intersect_is_sound(origin: vec3<f32>, direction: vec3<f32>) -> bool {
    return all(abs(origin) <= vec3<f32>(INTERSECT_FARTHEST_ORIGIN)) && all(abs(direction) <= vec3<f32>(F32_MAX));
}

/// Component-wise reciprocal of a direction, finite.
fn intersect_inverse(direction: vec3<f32>) -> vec3<f32> {
    let negative = (bitcast<vec3<u32>>(direction) & vec3<u32>(0x80000000u)) != vec3<u32>();
    let smallest = vec3<f32>(INTERSECT_SMALLEST_DIRECTION);
    let safe = select(direction, select(smallest, -smallest, negative), abs(direction) < smallest);
    return vec3<f32>(1.0) / safe;
}

/// Distances at which a ray enters a box, at least `t_min`, and leaves it; the ray misses the box where the former is
/// the larger one. Slab test (Kay and Kajiya 1986). Planes are told apart by the direction, not by their order, so that
/// an inverted box is always missed.
fn intersect_box(low: vec3<f32>, high: vec3<f32>, origin: vec3<f32>, inverse: vec3<f32>, t_min: f32) -> vec2<f32> {
    let backward = inverse < vec3<f32>();
    let near = (select(low, high, backward) - origin) * inverse;
    let far = (select(high, low, backward) - origin) * inverse;
    return vec2<f32>(
        max(max(max(near.x, near.y), near.z), t_min),
        min(min(far.x, far.y), far.z) * INTERSECT_FAR_SCALE,
    );
}

/// Two-sided intersection of a ray's whole line with a triangle (Moeller and Trumbore 1997, with the determinants
/// expanded about the triangle's normal). The hit counts beyond `t_min`, within the triangle's padded box, and its
/// distance is never below the entry into that box.
fn intersect_triangle(
    triangle: Triangle,
    origin: vec3<f32>,
    direction: vec3<f32>,
    inverse: vec3<f32>,
    t_min: f32,
) -> IntersectHit {
    let miss = IntersectHit(-1.0, 0.0, 0.0);
    let n = vector_cross(triangle.e1, triangle.e2);
    let c = triangle.v0 - origin;
    let r = vector_cross(c, direction);
    let det = vector_dot(direction, n);
    let turn = select(1.0, -1.0, det < 0.0);
    let size = abs(det);
    let u = vector_dot(triangle.e2, r) * turn;
    let v = -(vector_dot(triangle.e1, r) * turn);
    if !(u >= 0.0 && v >= 0.0 && u + v <= size && size > 0.0) {
        return miss;
    }
    let t = vector_dot(c, n) * turn / size;
    if !(t > t_min && t <= F32_MAX) {
        return miss;
    }
    let v1 = triangle.v0 + triangle.e1;
    let v2 = triangle.v0 + triangle.e2;
    let low = min(min(triangle.v0, v1), v2);
    let high = max(max(triangle.v0, v1), v2);
    let largest = max(abs(low), abs(high));
    let padding = vec3<f32>(max(max(largest.x, largest.y), largest.z) * INTERSECT_BOX_PADDING);
    let entry = intersect_box(low - padding, high + padding, origin, inverse, t_min);
    if !(entry.x <= entry.y) {
        return miss;
    }
    return IntersectHit(max(t, entry.x), u / size, v / size);
}
