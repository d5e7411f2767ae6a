//! Surfels where they are now, and the grid over them (S3, S5).
use super::{Grid, SurfelFrame, Surfels};
use crate::data::*;
use crate::frame::SceneInputs;
use crate::shared::scan::exclusive_scan;
use crate::stages::*;
use gibs_graph::{Buffer, Dispatch, DispatchArgs, Graph};
use glam::UVec2;

/// Gives also which surfels go.
pub(super) fn update_positions(
    g: &mut Graph,
    scene: &SceneInputs,
    shape: &Buffer<GridShape>,
    settings: &Buffer<SurfelSettings>,
    surfels: Surfels,
    in_use: &Buffer<DispatchArgs>,
) -> (Surfels, Buffer<u32>) {
    let gone = g.zeroed("gone", surfels.poses.len());
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
            gone,
        },
        Dispatch::Indirect(in_use),
    );
    let surfels = Surfels {
        births: moved.births,
        poses: moved.poses,
        unseen: moved.unseen,
        depths: moved.depths,
        ..surfels
    };
    (surfels, moved.gone)
}

/// The lists of every surfel's cells.
pub(super) fn build_grid(
    g: &mut Graph,
    shape: Buffer<GridShape>,
    poses: &Buffer<SurfelPose>,
    frame: &SurfelFrame,
    in_use: &Buffer<DispatchArgs>,
) -> Grid {
    let surfels = || Dispatch::Indirect(in_use);
    let cells = g.transient("grid_cells", u64::from(frame.grid.cells()));
    // A surfel and its bounds, in the half of the lists that are built and in that of those that new surfels join.
    let words = 2 * 2 * frame.settings.slots() * u64::from(frame.settings.grid_lists);
    let entries = g.transient("grid_entries", words);
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

/// The lists with those that were born since, which are of the `claims`. What does not fit counts; of a list that did
/// not fit before, those that are born.
pub(super) fn inject(
    g: &mut Graph,
    grid: Grid,
    poses: &Buffer<SurfelPose>,
    claims: &Buffer<UVec2>,
) -> Grid {
    let listed = grid.cells.len();
    let cells = || Dispatch::Elements(listed);
    let places = || Dispatch::Elements(claims.len());
    let inputs = grid_count::Inputs {
        grid: &grid.shape,
        poses,
        claims: Some(claims),
        counts: g.zeroed("born_counts", listed),
    };
    let born = g
        .add::<grid_count::GridCount>("apply/inject_count", inputs, places())
        .counts;
    let inputs = grid_room::Inputs {
        born: &born,
        cells: &grid.cells,
        counts: g.transient("injected_counts", listed),
    };
    let counts = g
        .add::<grid_room::GridRoom>("apply/inject_room", inputs, cells())
        .counts;
    let (starts, _) = exclusive_scan(g, "apply/inject_scan", &counts);
    let inputs = grid_carry::Inputs {
        starts: &starts,
        counts: &counts,
        entries: grid.entries,
        cells: grid.cells,
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
