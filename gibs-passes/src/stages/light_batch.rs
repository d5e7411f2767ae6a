//! `*/light_batch`: the size of a dispatch over light samples from that over points.
use crate::data::Frame;
use crate::shared::batch::args;
use gibs_graph::{DispatchArgs, Workgroup, stage};

stage! {
    /// As many invocations as points times lights per point.
    pub stage LightBatch {
        wgsl: gibs_shaders::stages::LIGHT_BATCH,
        workgroup: [1, 1, 1],
        ports: {
            uniform batch: DispatchArgs,
            uniform frame: Frame,
            write lights: DispatchArgs,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, _: Workgroup) {
    p.lights
        .set(0, args(p.batch.count * p.frame.lights_per_point));
}
