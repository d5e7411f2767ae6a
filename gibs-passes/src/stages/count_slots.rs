//! `check/count_slots`: slots that are lost or given twice (S4).
use crate::data::SurfelSettings;
use gibs_graph::{Workgroup, stage};

stage! {
    /// Counts the slots that are marked other than once: never, which is a leak, or more often, which is a slot that is
    /// free twice or both free and in use.
    pub stage CountSlots {
        wgsl: gibs_shaders::stages::COUNT_SLOTS,
        workgroup: [64, 1, 1],
        ports: {
            uniform settings: SurfelSettings,
            read marks: u32,
            atomic errors: u32,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    for i in group.range(p.settings.capacity) {
        if p.marks[i] != 1 {
            p.errors.add(0, 1);
        }
    }
}
