//! The end of surfels that are not needed (S9, S4), and the slots that are left.
use super::{Grid, Slots, Surfels};
use crate::data::*;
use crate::frame::SceneInputs;
use crate::shared::scan::exclusive_scan;
use crate::stages::*;
use gibs_graph::{Buffer, Dispatch, DispatchArgs, Graph};

/// The size of a dispatch over the slots that surfels may be in.
pub(super) fn slots_in_use(
    g: &mut Graph,
    group: &str,
    counters: &Buffer<SurfelCounters>,
) -> Buffer<DispatchArgs> {
    let batch = g.transient(&format!("{group}_slots"), 1);
    let inputs = slot_args::Inputs { counters, batch };
    let label = format!("{group}/slots_in_use");
    g.add::<slot_args::SlotArgs>(&label, inputs, Dispatch::Groups([1, 1, 1]))
        .batch
}

/// Chooses which surfels go before the next frame.
pub(super) fn choose(
    g: &mut Graph,
    scene: &SceneInputs,
    grid: &Grid,
    settings: &Buffer<SurfelSettings>,
    surfels: Surfels,
    counters: &Buffer<SurfelCounters>,
    in_use: &Buffer<DispatchArgs>,
) -> Surfels {
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
            counters,
            unseen: surfels.unseen,
        },
        Dispatch::Indirect(in_use),
    );
    Surfels {
        unseen: chosen.unseen,
        ..surfels
    }
}

/// Frees the slots of the surfels that are `gone`.
pub(super) fn free(
    g: &mut Graph,
    surfels: Surfels,
    slots: Slots,
    gone: &Buffer<u32>,
    in_use: &Buffer<DispatchArgs>,
) -> (Surfels, Slots) {
    let (ranks, total) = exclusive_scan(g, "persistent/recycle_rank", gone);
    let pushed = g.add::<recycle_push::RecyclePush>(
        "persistent/recycle_push",
        recycle_push::Inputs {
            gone,
            ranks: &ranks,
            counters: &slots.counters,
            free_slots: slots.free,
            poses: surfels.poses,
            light: surfels.light,
            unseen: surfels.unseen,
        },
        Dispatch::Indirect(in_use),
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
    (surfels, slots)
}
