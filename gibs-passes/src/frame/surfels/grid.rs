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
        },
        Dispatch::Elements(capacity),
    );
    Surfels {
        poses: moved.poses,
        unseen: moved.unseen,
        ..surfels
    }
}

pub(super) fn build_grid(
    g: &mut Graph,
    shape: Buffer<GridShape>,
    surfels: &Surfels,
    frame: &SurfelFrame,
    capacity: u64,
) -> (Grid, Buffer<u32>) {
    let cells = u64::from(frame.grid.cells());
    let counts = g.zeroed("grid_counts", cells);
    let inputs = grid_count::Inputs {
        grid: &shape,
        poses: &surfels.poses,
        counts,
    };
    let counts = g
        .add::<grid_count::GridCount>(
            "persistent/grid_count",
            inputs,
            Dispatch::Elements(capacity),
        )
        .counts;
    let (starts, _) = exclusive_scan(g, "persistent/grid_scan", &counts);
    let cursors = g.zeroed("grid_cursors", cells);
    let entries = g.transient(
        "grid_entries",
        capacity * u64::from(frame.settings.grid_lists),
    );
    let inputs = grid_scatter::Inputs {
        grid: &shape,
        poses: &surfels.poses,
        starts: &starts,
        cursors,
        entries,
    };
    let scattered = g.add::<grid_scatter::GridScatter>(
        "persistent/grid_scatter",
        inputs,
        Dispatch::Elements(capacity),
    );
    let listed = g.transient("grid_cells", cells);
    let overflow = g.zeroed("grid_overflow", 1);
    let ordered = g.add::<grid_order::GridOrder>(
        "persistent/grid_order",
        grid_order::Inputs {
            poses: &surfels.poses,
            starts: &starts,
            counts: &counts,
            entries: scattered.entries,
            cells: listed,
            overflow,
        },
        Dispatch::Elements(cells),
    );
    (
        Grid {
            shape,
            cells: ordered.cells,
            entries: ordered.entries,
        },
        ordered.overflow,
    )
}
