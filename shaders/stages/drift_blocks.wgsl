// How far the short means of each block of surfels have left their long ones.
import package::drift_sum::{DRIFT_SUM_LANES, drift_sum_in_pairs};
import package::estimator::estimator_with_drift;
import package::invocation::invocation_group;
import package::types::{Drift, SurfelIrradiance, SurfelPose};

@group(0) @binding(0) var<storage, read> poses: array<SurfelPose>;
@group(0) @binding(1) var<storage, read> irradiance: array<SurfelIrradiance>;
@group(0) @binding(2) var<storage, read_write> blocks: array<Drift>;

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let block = invocation_group(group, groups);
    if block >= arrayLength(&blocks) {
        return;
    }
    let i = block * DRIFT_SUM_LANES + lane;
    var own = Drift();
    if i < arrayLength(&poses) && poses[i].radius > 0.0 {
        own = estimator_with_drift(own, irradiance[i]);
    }
    let sum = drift_sum_in_pairs(lane, own);
    if lane == 0u {
        blocks[block] = sum;
    }
}
