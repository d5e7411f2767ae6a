//! Surfels where they are now, and the grid over them (S3, S5).
use super::{Grid, SurfelFrame, Surfels};
use crate::data::*;
use crate::frame::SceneInputs;
use crate::shared::scan::exclusive_scan;
use crate::stages::*;
use gibs_graph::{Buffer, Dispatch, Graph};

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
            grid: shape,
            settings,
            births: &surfels.births,
            transforms: &scene.transforms,
            poses: surfels.poses,
            unseen: surfels.unseen,
            depths: surfels.depths,
        },
        Dispatch::Elements(capacity),
    );
    Surfels {
        poses: moved.poses,
        unseen: moved.unseen,
        depths: moved.depths,
        ..surfels
    }
}

/// The lists of every surfel's cells, and how many entries did not fit.
pub(super) fn build_grid(
    g: &mut Graph,
    shape: Buffer<GridShape>,
    poses: &Buffer<SurfelPose>,
    frame: &SurfelFrame,
    capacity: u64,
) -> Grid {
    let grid = Grid {
        shape,
        cells: g.transient("grid_cells", u64::from(frame.grid.cells())),
        entries: g.transient(
            "grid_entries",
            // A surfel and its bounds.
            2 * capacity * u64::from(frame.settings.grid_lists),
        ),
        overflow: g.zeroed("grid_overflow", 1),
    };
    fill_grid(g, "persistent/grid", grid, poses, capacity)
}

/// Fills the lists again, now that there are new surfels. What does not fit counts each time.
pub(super) fn fill_grid(
    g: &mut Graph,
    label: &str,
    grid: Grid,
    poses: &Buffer<SurfelPose>,
    capacity: u64,
) -> Grid {
    let cells = grid.cells.len();
    let counts = g.zeroed(&format!("{label}_counts"), cells);
    let inputs = grid_count::Inputs {
        grid: &grid.shape,
        poses,
        counts,
    };
    let counts = g
        .add::<grid_count::GridCount>(
            &format!("{label}_count"),
            inputs,
            Dispatch::Elements(capacity),
        )
        .counts;
    let (starts, _) = exclusive_scan(g, &format!("{label}_scan"), &counts);
    let cursors = g.zeroed(&format!("{label}_cursors"), cells);
    let inputs = grid_scatter::Inputs {
        grid: &grid.shape,
        poses,
        starts: &starts,
        cursors,
        entries: grid.entries,
    };
    let scattered = g.add::<grid_scatter::GridScatter>(
        &format!("{label}_scatter"),
        inputs,
        Dispatch::Elements(capacity),
    );
    let ordered = g.add::<grid_order::GridOrder>(
        &format!("{label}_order"),
        grid_order::Inputs {
            grid: &grid.shape,
            poses,
            starts: &starts,
            counts: &counts,
            entries: scattered.entries,
            cells: grid.cells,
            overflow: grid.overflow,
        },
        Dispatch::Elements(cells),
    );
    Grid {
        shape: grid.shape,
        cells: ordered.cells,
        entries: ordered.entries,
        overflow: ordered.overflow,
    }
}
