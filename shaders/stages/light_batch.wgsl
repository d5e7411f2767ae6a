// As many invocations as points times lights per point.
import package::batch::batch_args;
import package::types::{DispatchArgs, Frame};

@group(0) @binding(0) var<uniform> batch: DispatchArgs;
@group(0) @binding(1) var<uniform> frame: Frame;
@group(0) @binding(2) var<storage, read_write> lights: array<DispatchArgs>;

@compute @workgroup_size(1)
fn main() {
    lights[0] = batch_args(batch.count * frame.lights_per_point);
}
