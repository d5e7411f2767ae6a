// The visible surfaces and the cells that they lie in, as a debug view shows them.
import package::debug::{DEBUG_VIEW_CELL_HEAT, DEBUG_VIEW_TRANSFORM_ID, debug_headlight, debug_nothing};
import package::grid::grid_cell;
import package::invocation::invocation_index;
import package::octahedral::octahedral_unpack;
import package::surface::surface_is_surface;
import package::types::{Camera, DebugPixel, DispatchArgs, GridShape, SurfacePoint, SurfelSettings};

@group(0) @binding(0) var<uniform> batch: DispatchArgs;
@group(0) @binding(1) var<uniform> camera: Camera;
@group(0) @binding(2) var<uniform> grid: GridShape;
@group(0) @binding(3) var<uniform> settings: SurfelSettings;
@group(0) @binding(4) var<storage, read> points: array<SurfacePoint>;
@if(cells) @group(0) @binding(5) var<storage, read> cells: array<vec2<u32>>;
@group(0) @binding(6) var<storage, read_write> debug: array<DebugPixel>;

/// Brightness of the lines between cells.
const LINE: f32 = 0.35;

@if(cells)
fn surfels_in(cell: u32) -> u32 {
    return cells[cell].y;
}
@else
fn surfels_in(cell: u32) -> u32 {
    return 0u;
}

/// Which of the seven grids a cell belongs to.
fn part(cell: u32) -> u32 {
    let side = grid.side;
    let cube = side * side * side;
    if cell < cube {
        return 0u;
    }
    return 1u + (cell - cube) / (grid.slices * side * side);
}

/// The surface at a pixel lies in another cell.
fn differs(pixel: u32, cell: u32) -> bool {
    let point = points[pixel];
    return surface_is_surface(point) && grid_cell(point.position, grid) != cell;
}

/// Dark where the pixel to the right or below lies in another cell.
fn line(i: u32, cell: u32) -> f32 {
    let x = i % camera.width;
    let right = x + 1u < camera.width && differs(i + 1u, cell);
    if right || (i + camera.width < batch.count && differs(i + camera.width, cell)) {
        return LINE;
    }
    return 1.0;
}

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
    let point = points[i];
    if !surface_is_surface(point) {
        debug[i] = debug_nothing();
        return;
    }
    let light = debug_headlight(camera.eye - point.position, octahedral_unpack(point.shading_normal));
    if settings.debug == DEBUG_VIEW_TRANSFORM_ID {
        debug[i] = DebugPixel(f32(point.transform_id), light);
        return;
    }
    let cell = grid_cell(point.position, grid);
    if settings.debug == DEBUG_VIEW_CELL_HEAT {
        debug[i] = DebugPixel(f32(surfels_in(cell)), line(i, cell));
        return;
    }
    debug[i] = DebugPixel(f32(part(cell)), light * line(i, cell));
}
