// The non-linear grid (GIBS, "Acceleration Structure"): uniform cells in a cube around the eye, and one trapezoidal
// grid along each of the six half-axes.
import package::portable::portable_log2;
import package::lookup::LOOKUP_SQUASH;
import package::plane::plane_unpack;
import package::types::{GridShape, SurfelPose};
import package::vector::vector_dot;

/// Number of grids: the cube and six half-axes.
const GRID_PARTS: u32 = 7u;
/// What a surfel reaches is taken this much larger when its cells are found, so that rounding leaves none out.
const GRID_MARGIN: f32 = 1.001;
/// A surfel's radius is at most this share of its cell's side.
const GRID_RADIUS_SHARE: f32 = 0.5;

fn grid_index(x: f32, side: u32) -> u32 {
    return u32(clamp((x * 0.5 + 0.5) * f32(side), 0.0, f32(side) - 1.0));
}

/// The slice at a distance along a half-axis.
fn grid_slice(m: f32, shape: GridShape) -> u32 {
    return u32(clamp(portable_log2(m / shape.half) * shape.per_octave, 0.0, f32(shape.slices) - 1.0));
}

/// The cell of a position.
fn grid_cell(position: vec3<f32>, shape: GridShape) -> u32 {
    let d = position - shape.centre;
    let a = abs(d);
    let m = max(max(a.x, a.y), a.z);
    let side = shape.side;
    if m < shape.half {
        let x = grid_index(d.x / shape.half, side);
        let y = grid_index(d.y / shape.half, side);
        let z = grid_index(d.z / shape.half, side);
        return (z * side + y) * side + x;
    }
    // Face 0..6 is the half-axis; u and v are the other two axes, in order.
    var face = 4u;
    var axes = d.zxy;
    if a.x >= a.y && a.x >= a.z {
        face = 0u;
        axes = d.xyz;
    } else if a.y >= a.z {
        face = 2u;
        axes = d.yxz;
    }
    face += select(0u, 1u, axes.x < 0.0);
    let slice = grid_slice(m, shape);
    let u = grid_index(axes.y / m, side);
    let v = grid_index(axes.z / m, side);
    return side * side * side + ((face * shape.slices + slice) * side + v) * side + u;
}

/// Side of the cells around a position, metres.
fn grid_cell_side(position: vec3<f32>, shape: GridShape) -> f32 {
    let a = abs(position - shape.centre);
    return 2.0 * max(max(max(a.x, a.y), a.z), shape.half) / f32(shape.side);
}

/// A box of cells in one of the seven grids: cell `(z * side + y) * side + x` above `base`, for each coordinate from
/// `low` to `high`, both included. For a half-axis, z counts slices.
struct GridSpan {
    found: bool,
    base: u32,
    low: vec3<u32>,
    high: vec3<u32>,
}

/// How far a surfel reaches along each axis: the box around the flat ellipsoid outside which it has no weight.
fn grid_extents(pose: SurfelPose) -> vec3<f32> {
    let flat = 1.0 - 1.0 / (LOOKUP_SQUASH * LOOKUP_SQUASH);
    let normal = plane_unpack(pose.mark);
    // The constant before the second factor: a driver may move it there.
    let across = max(vec3<f32>(1.0) - normal * flat * normal / vector_dot(normal, normal), vec3<f32>(0.0));
    return pose.radius * GRID_MARGIN * sqrt(across);
}

fn grid_low(x: f32, near: f32, far: f32) -> f32 {
    return x / select(far, near, x < 0.0);
}

fn grid_high(x: f32, near: f32, far: f32) -> f32 {
    return x / select(far, near, x > 0.0);
}

/// Coordinates along a face's axis and the other two, in order.
fn grid_turned(v: vec3<f32>, face: u32) -> vec3<f32> {
    if face < 2u {
        return v.xyz;
    }
    if face < 4u {
        return v.yxz;
    }
    return v.zxy;
}

/// The cells of one of the grids that a box around a position, which reaches `r` along each axis, can overlap: all that it
/// does, and a few more. A cell is in at most one part's span.
fn grid_span(position: vec3<f32>, r: vec3<f32>, shape: GridShape, part: u32) -> GridSpan {
    var span: GridSpan;
    let d = position - shape.centre;
    let side = shape.side;
    if part == 0u {
        let low = (d - r) / shape.half;
        let high = (d + r) / shape.half;
        if max(max(low.x, low.y), low.z) > 1.0 || min(min(high.x, high.y), high.z) < -1.0 {
            return span;
        }
        span.found = true;
        span.low = vec3<u32>(grid_index(low.x, side), grid_index(low.y, side), grid_index(low.z, side));
        span.high = vec3<u32>(grid_index(high.x, side), grid_index(high.y, side), grid_index(high.z, side));
        return span;
    }
    let face = part - 1u;
    let axes = grid_turned(d, face);
    let reach = grid_turned(r, face);
    let along = select(axes.x, -axes.x, (face & 1u) == 1u);
    let far = along + reach.x;
    if far < shape.half || abs(axes.y) - reach.y > far || abs(axes.z) - reach.z > far {
        return span;
    }
    // Within the half-axis's pyramid the main coordinate lies between the two; a lateral one is divided by it.
    let near = max(along - reach.x, shape.half);
    let u0 = grid_low(axes.y - reach.y, near, far);
    let u1 = grid_high(axes.y + reach.y, near, far);
    let v0 = grid_low(axes.z - reach.z, near, far);
    let v1 = grid_high(axes.z + reach.z, near, far);
    span.found = true;
    span.base = side * side * side + face * shape.slices * side * side;
    span.low = vec3<u32>(grid_index(u0, side), grid_index(v0, side), grid_slice(near, shape));
    span.high = vec3<u32>(grid_index(u1, side), grid_index(v1, side), grid_slice(far, shape));
    return span;
}
