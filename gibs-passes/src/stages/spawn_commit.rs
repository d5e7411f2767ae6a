//! `spawn/spawn_commit`: the free stack after this frame's births.
use crate::data::{SurfelCounters, SurfelSettings};
use gibs_graph::{Workgroup, stage};

stage! {
    /// Takes the claimed slots off the stack, and counts births and those that found no slot.
    pub stage SpawnCommit {
        wgsl: gibs_shaders::stages::SPAWN_COMMIT,
        workgroup: [1, 1, 1],
        ports: {
            uniform settings: SurfelSettings,
            read total: u32,
            read_write counters: SurfelCounters,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, _: Workgroup) {
    let mut counters = p.counters.get(0);
    let wanted = p.total[0];
    let born = wanted.min(p.settings.capacity - counters.live);
    counters.live += born;
    counters.used = counters.used.max(counters.live);
    counters.born = counters.born.wrapping_add(born);
    counters.starved = counters.starved.wrapping_add(wanted - born);
    p.counters.set(0, counters);
}
