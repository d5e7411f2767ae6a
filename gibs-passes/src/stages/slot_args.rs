//! `*/slots_in_use`: the size of a dispatch over the slots that surfels may be in.
use crate::data::SurfelCounters;
use crate::shared::batch::args;
use gibs_graph::{DispatchArgs, Workgroup, stage};

stage! {
    /// Workgroups of 64 for the slots that have ever been in use; at least one, so that the stages run that write for all.
    pub stage SlotArgs {
        wgsl: gibs_shaders::stages::SLOT_ARGS,
        workgroup: [1, 1, 1],
        ports: {
            read counters: SurfelCounters,
            write batch: DispatchArgs,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, _: Workgroup) {
    p.batch.set(0, args(p.counters[0].used.max(1)));
}
