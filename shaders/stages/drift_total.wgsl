// How far all short means have left the long ones.
import package::drift_sum::{DRIFT_SUM_LANES, drift_sum_in_pairs};
import package::estimator::estimator_plus_drift;
import package::types::Drift;

@group(0) @binding(0) var<storage, read> blocks: array<Drift>;
@group(0) @binding(1) var<storage, read_write> total: array<Drift>;

@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) lane: u32) {
    var own = Drift();
    for (var i = lane; i < arrayLength(&blocks); i += DRIFT_SUM_LANES) {
        own = estimator_plus_drift(own, blocks[i]);
    }
    let sum = drift_sum_in_pairs(lane, own);
    if lane == 0u {
        total[0] = sum;
    }
}
