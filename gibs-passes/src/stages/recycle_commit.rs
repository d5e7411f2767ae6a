//! `persistent/recycle_commit`: the free stack after this frame's deaths.
use crate::data::SurfelCounters;
use gibs_graph::{Workgroup, stage};

stage! {
    /// Counts the slots that were pushed.
    pub stage RecycleCommit {
        wgsl: gibs_shaders::stages::RECYCLE_COMMIT,
        workgroup: [1, 1, 1],
        ports: {
            read total: u32,
            read_write counters: SurfelCounters,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, _: Workgroup) {
    let mut counters = p.counters.get(0);
    counters.live -= p.total[0];
    counters.recycled = counters.recycled.wrapping_add(p.total[0]);
    p.counters.set(0, counters);
}
