// Workgroups of 64 for the slots that have ever been in use.
import package::batch::batch_args;
import package::types::{DispatchArgs, SurfelCounters};

@group(0) @binding(0) var<storage, read> counters: array<SurfelCounters>;
@group(0) @binding(1) var<storage, read_write> batch: array<DispatchArgs>;

@compute @workgroup_size(1)
fn main() {
    batch[0] = batch_args(max(counters[0].used, 1u));
}
