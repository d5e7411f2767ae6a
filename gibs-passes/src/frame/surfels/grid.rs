//! Surfels where they are now, and the grid over them (S3, S5).
use super::{Grid, SurfelFrame, Surfels};
use crate::data::*;
use crate::frame::{SceneInputs, Settings};
use crate::shared::grid::GridLayout;
use crate::shared::scan::exclusive_scan;
use crate::stages::*;
use gibs_graph::{Buffer, Dispatch, Graph};
use glam::UVec2;

pub(super) fn update_positions(
    g: &mut Graph,
    scene: &SceneInputs,
    shape: &Buffer<GridShape>,
    settings: &Buffer<SurfelSettings>,
    surfels: Surfels,
    capacity: u64,
) -> Surfels {
    let moved = g.add::<positional_update::PositionalUpdate>(
        "persistent/positional_update",
        positional_update::Inputs {
            camera: &scene.camera,
            frame: &scene.frame,
            grid: shape,
            settings,
            transforms: &scene.transforms,
            births: surfels.births,
            poses: surfels.poses,
            unseen: surfels.unseen,
            depths: surfels.depths,
        },
        Dispatch::Elements(capacity),
    );
    Surfels {
        births: moved.births,
        poses: moved.poses,
        unseen: moved.unseen,
        depths: moved.depths,
        ..surfels
    }
}

/// Cells, and room for their lists.
fn empty_lists(
    g: &mut Graph,
    label: &str,
    grid: GridLayout,
    settings: &Settings,
) -> (Buffer<UVec2>, Buffer<u32>) {
    // A surfel and its bounds.
    let words = 2 * settings.slots() * u64::from(settings.grid_lists);
    (
        g.transient(&format!("{label}_cells"), u64::from(grid.cells())),
        g.transient(&format!("{label}_entries"), words),
    )
}

/// The lists of every surfel's cells.
pub(super) fn build_grid(
    g: &mut Graph,
    shape: Buffer<GridShape>,
    poses: &Buffer<SurfelPose>,
    frame: &SurfelFrame,
) -> Grid {
    let surfels = || Dispatch::Elements(poses.len());
    let (cells, entries) = empty_lists(g, "grid", frame.grid, &frame.settings);
    let per_cell = Dispatch::Elements(cells.len());
    let counts = g.zeroed("grid_counts", cells.len());
    let inputs = grid_count::Inputs {
        grid: &shape,
        poses,
        claims: None,
        counts,
    };
    let counts = g
        .add::<grid_count::GridCount>("persistent/grid_count", inputs, surfels())
        .counts;
    let (starts, _) = exclusive_scan(g, "persistent/grid_scan", &counts);
    let cursors = g.zeroed("grid_cursors", cells.len());
    let inputs = grid_scatter::Inputs {
        grid: &shape,
        poses,
        starts: &starts,
        cursors,
        entries,
    };
    let entries = g
        .add::<grid_scatter::GridScatter>("persistent/grid_scatter", inputs, surfels())
        .entries;
    let overflow = g.zeroed("grid_overflow", 1);
    let inputs = grid_order::Inputs {
        grid: &shape,
        poses,
        starts: &starts,
        counts: &counts,
        entries,
        cells,
        overflow,
    };
    let ordered = g.add::<grid_order::GridOrder>("persistent/grid_order", inputs, per_cell);
    Grid {
        shape,
        cells: ordered.cells,
        entries: ordered.entries,
        overflow: ordered.overflow,
    }
}

/// The lists without the surfels that are `gone` and with those that were born since. What does not fit counts again.
pub(super) fn inject(
    g: &mut Graph,
    grid: Grid,
    frame: &SurfelFrame,
    poses: &Buffer<SurfelPose>,
    gone: &Buffer<u32>,
    claims: &Buffer<UVec2>,
) -> Grid {
    let listed = grid.cells.len();
    let counts = g.transient("injected_counts", listed);
    let inputs = grid_leave::Inputs {
        gone,
        cells: &grid.cells,
        entries: &grid.entries,
        counts,
    };
    let cells = || Dispatch::Elements(listed);
    let places = || Dispatch::Elements(claims.len());
    let counts = g
        .add::<grid_leave::GridLeave>("apply/inject_leave", inputs, cells())
        .counts;
    let inputs = grid_count::Inputs {
        grid: &grid.shape,
        poses,
        claims: Some(claims),
        counts,
    };
    let counts = g
        .add::<grid_count::GridCount>("apply/inject_count", inputs, places())
        .counts;
    let (starts, _) = exclusive_scan(g, "apply/inject_scan", &counts);
    let (new_cells, entries) = empty_lists(g, "injected", frame.grid, &frame.settings);
    let inputs = grid_carry::Inputs {
        gone,
        old_cells: &grid.cells,
        old_entries: &grid.entries,
        starts: &starts,
        counts: &counts,
        entries,
        cells: new_cells,
        overflow: grid.overflow,
    };
    let carried = g.add::<grid_carry::GridCarry>("apply/inject_carry", inputs, cells());
    let inputs = grid_insert::Inputs {
        grid: &grid.shape,
        poses,
        claims,
        cells: &carried.cells,
        born: g.zeroed("injected", listed),
        entries: carried.entries,
    };
    let inserted = g.add::<grid_insert::GridInsert>("apply/inject_insert", inputs, places());
    let inputs = grid_merge::Inputs {
        grid: &grid.shape,
        poses,
        cells: &carried.cells,
        born: &inserted.born,
        entries: inserted.entries,
    };
    let entries = g
        .add::<grid_merge::GridMerge>("apply/inject_merge", inputs, cells())
        .entries;
    Grid {
        shape: grid.shape,
        cells: carried.cells,
        entries,
        overflow: carried.overflow,
    }
}
