//! `filtering/drift_blocks`: how far the short means of many surfels have left their long ones (I3).
use crate::data::{Drift, SurfelIrradiance, SurfelPose};
use crate::shared::estimator::Drifting;
use gibs_graph::{Workgroup, stage};

stage! {
    /// Sums the drift of each block of 256 live surfels: pairs of lanes, then pairs of those.
    pub stage DriftBlocks {
        wgsl: gibs_shaders::stages::DRIFT_BLOCKS,
        workgroup: [256, 1, 1],
        ports: {
            read poses: SurfelPose,
            read irradiance: SurfelIrradiance,
            write blocks: Drift,
        },
        cpu: kernel,
        wide: None,
    }
}

/// Surfels in a block, a lane for each.
pub const BLOCK: usize = 256;

fn kernel(p: &Views<'_>, group: Workgroup) {
    let block = group.linear() as usize;
    if block >= p.blocks.len() {
        return;
    }
    let mut sums = [Drift::default(); BLOCK];
    for (i, sum) in (block * BLOCK..).zip(&mut sums) {
        if p.poses.get(i).is_some_and(|pose| pose.radius > 0.0) {
            *sum = Drift::default().with(&p.irradiance[i]);
        }
    }
    p.blocks.set(block, in_pairs(&mut sums));
}

/// The sum of all, in pairs of lanes that are half of them apart.
pub(super) fn in_pairs(sums: &mut [Drift; BLOCK]) -> Drift {
    let mut half = BLOCK / 2;
    while half > 0 {
        for lane in 0..half {
            sums[lane] = sums[lane].plus(&sums[lane + half]);
        }
        half /= 2;
    }
    sums[0]
}
