//! `filtering/drift_total`: how far all short means have left the long ones (I3).
use super::drift_blocks::{BLOCK, in_pairs};
use crate::data::Drift;
use crate::shared::estimator::Drifting;
use gibs_graph::{Workgroup, stage};

stage! {
    /// Sums the drift of all blocks: each of the workgroup's lanes every 256th block, then pairs of lanes.
    pub stage DriftTotal {
        wgsl: gibs_shaders::stages::DRIFT_TOTAL,
        workgroup: [256, 1, 1],
        ports: {
            read blocks: Drift,
            write total: Drift,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, _: Workgroup) {
    let mut sums = [Drift::default(); BLOCK];
    for (lane, sum) in sums.iter_mut().enumerate() {
        let own = p.blocks.iter().skip(lane).step_by(BLOCK);
        *sum = own.fold(Drift::default(), |sum, block| sum.plus(block));
    }
    p.total.set(0, in_pairs(&mut sums));
}
