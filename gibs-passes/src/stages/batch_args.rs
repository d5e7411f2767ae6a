//! `*/batch`: the size of an indirect dispatch from a count.
use crate::shared::batch::args;
use gibs_graph::{DispatchArgs, Workgroup, stage};

stage! {
    /// Workgroups of 64 for a count that the device computed.
    pub stage BatchArgs {
        wgsl: gibs_shaders::stages::BATCH_ARGS,
        workgroup: [1, 1, 1],
        ports: {
            read count: u32,
            write batch: DispatchArgs,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, _: Workgroup) {
    p.batch.set(0, args(p.count[0]));
}
