//! `debug/surface`: the visible surfaces and the cells that they lie in, as a debug view shows them (F3).
use crate::data::{Camera, DebugPixel, GridShape, SurfacePoint, SurfelSettings};
use crate::shared::debug::{self, DebugView};
use crate::shared::{grid, octahedral, surface};
use gibs_graph::{DispatchArgs, Workgroup, stage};
use glam::UVec2;

stage! {
    /// The transform id of each pixel's surface, which of the seven grids its cell belongs to, or how many surfels the
    /// cell lists; views of cells have lines between them.
    pub stage DebugSurface {
        wgsl: gibs_shaders::stages::DEBUG_SURFACE,
        workgroup: [64, 1, 1],
        ports: {
            uniform batch: DispatchArgs,
            uniform camera: Camera,
            uniform grid: GridShape,
            uniform settings: SurfelSettings,
            read points: SurfacePoint,
            optional_read cells: UVec2,
            write debug: DebugPixel,
        },
        cpu: kernel,
        wide: None,
    }
}

/// Brightness of the lines between cells.
const LINE: f32 = 0.35;

/// Which of the seven grids a cell belongs to.
#[inline]
pub fn part(cell: u32, grid: &GridShape) -> u32 {
    let cube = grid.side * grid.side * grid.side;
    match cell < cube {
        true => 0,
        false => 1 + (cell - cube) / (grid.slices * grid.side * grid.side),
    }
}

/// Dark where the pixel to the right or below lies in another cell.
fn line(p: &Views<'_>, i: usize, cell: u32) -> f32 {
    let differs = |pixel: usize| {
        let point = &p.points[pixel];
        surface::is_surface(point) && grid::cell(point.position, p.grid) != cell
    };
    let width = p.camera.width as usize;
    let right = i % width + 1 < width && differs(i + 1);
    if right || (i + width < p.batch.count as usize && differs(i + width)) {
        LINE
    } else {
        1.0
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    let view = DebugView::of(p.settings.debug);
    for i in group.range(p.batch.count) {
        let point = &p.points[i];
        if !surface::is_surface(point) {
            p.debug.set(i, debug::NOTHING);
            continue;
        }
        let normal = octahedral::unpack(point.shading_normal);
        let light = debug::headlight(p.camera.eye - point.position, normal);
        let cell = grid::cell(point.position, p.grid);
        let pixel = match view {
            Some(DebugView::TransformId) => debug::pixel(point.transform_id as f32, light),
            Some(DebugView::CellHeat) => {
                let listed = p.cells.get(cell as usize).map_or(0, |c| c.y);
                debug::pixel(listed as f32, line(p, i, cell))
            }
            _ => debug::pixel(part(cell, p.grid) as f32, light * line(p, i, cell)),
        };
        p.debug.set(i, pixel);
    }
}
