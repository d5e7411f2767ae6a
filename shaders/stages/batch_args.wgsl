// Workgroups of 64 for a count that the device computed.
import package::batch::batch_args;
import package::types::DispatchArgs;

@group(0) @binding(0) var<storage, read> count: array<u32>;
@group(0) @binding(1) var<storage, read_write> batch: array<DispatchArgs>;

@compute @workgroup_size(1)
fn main() {
    batch[0] = batch_args(count[0]);
}
