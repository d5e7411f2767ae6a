//! The end of surfels that are not needed (S9, S4).
use super::{Grid, Slots, Surfels};
use crate::data::*;
use crate::frame::SceneInputs;
use crate::shared::scan::exclusive_scan;
use crate::stages::*;
use gibs_graph::{Buffer, Dispatch, Graph};

/// Gives also which surfels went.
pub(super) fn recycle(
    g: &mut Graph,
    scene: &SceneInputs,
    grid: &Grid,
    settings: &Buffer<SurfelSettings>,
    surfels: Surfels,
    slots: Slots,
    capacity: u64,
) -> (Surfels, Slots, Buffer<u32>) {
    let gone = g.transient("recycled", capacity);
    let chosen = g.add::<recycle::Recycle>(
        "persistent/recycle",
        recycle::Inputs {
            camera: &scene.camera,
            frame: &scene.frame,
            grid: &grid.shape,
            settings,
            cells: &grid.cells,
            entries: &grid.entries,
            poses: &surfels.poses,
            depths: surfels.depths.as_ref(),
            counters: &slots.counters,
            unseen: &surfels.unseen,
            gone,
        },
        Dispatch::Elements(capacity),
    );
    let (ranks, total) = exclusive_scan(g, "persistent/recycle_rank", &chosen.gone);
    let pushed = g.add::<recycle_push::RecyclePush>(
        "persistent/recycle_push",
        recycle_push::Inputs {
            gone: &chosen.gone,
            ranks: &ranks,
            counters: &slots.counters,
            free_slots: slots.free,
            poses: surfels.poses,
            light: surfels.light,
            unseen: surfels.unseen,
        },
        Dispatch::Elements(capacity),
    );
    let inputs = recycle_commit::Inputs {
        total: &total,
        counters: slots.counters,
    };
    let committed = g.add::<recycle_commit::RecycleCommit>(
        "persistent/recycle_commit",
        inputs,
        Dispatch::Groups([1, 1, 1]),
    );
    let surfels = Surfels {
        poses: pushed.poses,
        light: pushed.light,
        unseen: pushed.unseen,
        ..surfels
    };
    let slots = Slots {
        counters: committed.counters,
        free: pushed.free_slots,
    };
    (surfels, slots, chosen.gone)
}
