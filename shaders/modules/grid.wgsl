// The non-linear grid (GIBS, "Acceleration Structure"): uniform cells in a cube around the eye, and one trapezoidal
// grid along each of the six half-axes.
import package::portable::portable_log2;
import package::types::GridShape;

/// Most cells that one surfel can overlap.
const GRID_MAX_OVERLAP: u32 = 27u;
/// A surfel's radius is at most this share of its cell's side.
const GRID_RADIUS_SHARE: f32 = 0.75;

/// The distinct cells that a sphere overlaps: the first `count` of `cells`.
struct GridOverlap {
    cells: array<u32, 27>,
    count: u32,
}

fn grid_index(x: f32, side: u32) -> u32 {
    return u32(clamp((x * 0.5 + 0.5) * f32(side), 0.0, f32(side) - 1.0));
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
    let octaves = portable_log2(m / shape.half) * shape.per_octave;
    let slice = u32(clamp(octaves, 0.0, f32(shape.slices) - 1.0));
    let u = grid_index(axes.y / m, side);
    let v = grid_index(axes.z / m, side);
    return side * side * side + ((face * shape.slices + slice) * side + v) * side + u;
}

/// Side of the cells around a position, metres.
fn grid_cell_side(position: vec3<f32>, shape: GridShape) -> f32 {
    let a = abs(position - shape.centre);
    return 2.0 * max(max(max(a.x, a.y), a.z), shape.half) / f32(shape.side);
}

/// The distinct cells that the bounding box of a sphere overlaps, in the order of a fixed 3x3x3 pattern of points; the
/// radius is at most `GRID_RADIUS_SHARE` of the cell side.
fn grid_overlapped(position: vec3<f32>, radius: f32, shape: GridShape) -> GridOverlap {
    var found: GridOverlap;
    for (var i = 0u; i < 27u; i++) {
        let step = vec3<f32>(vec3<u32>(i % 3u, i / 3u % 3u, i / 9u)) - 1.0;
        let cell = grid_cell(position + step * radius, shape);
        var known = false;
        for (var j = 0u; j < found.count; j++) {
            known = known || found.cells[j] == cell;
        }
        if !known {
            found.cells[found.count] = cell;
            found.count++;
        }
    }
    return found;
}
