// Share of what they know that the surfels of each cell should forget.
import package::estimator::{ESTIMATOR_DRIFT_OF, estimator_to_forget, estimator_with_drift};
import package::invocation::invocation_index;
import package::types::{Drift, SurfelIrradiance};

@group(0) @binding(0) var<storage, read> cells: array<vec2<u32>>;
@group(0) @binding(1) var<storage, read> entries: array<u32>;
@group(0) @binding(2) var<storage, read> irradiance: array<SurfelIrradiance>;
@group(0) @binding(3) var<storage, read> total: array<Drift>;
@group(0) @binding(4) var<storage, read_write> forget: array<vec2<f32>>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = invocation_index(group, groups, 64u, lane);
    if i >= arrayLength(&cells) {
        return;
    }
    let cell = cells[i];
    var drift = Drift();
    for (var entry = cell.x; entry < cell.x + min(cell.y, ESTIMATOR_DRIFT_OF); entry++) {
        drift = estimator_with_drift(drift, irradiance[entries[entry]]);
    }
    forget[i] = estimator_to_forget(drift, total[0]);
}
