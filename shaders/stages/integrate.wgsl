// Rays into the irradiance of the surfels that they began on, and what the surfels say while no neighbours know better.
import package::estimator::{estimator_forget, estimator_taken, estimator_unless_faint, estimator_update};
import package::grid::grid_cell;
import package::invocation::invocation_index;
@if(neighbours) import package::sharing::{SHARING_ASKS, sharing_is_due, sharing_unpack};
import package::sharing::{SharingSaid, sharing_light};
import package::types::{
    ClampedLight, Frame, GridShape, Neighbours, SurfelIrradiance, SurfelLight, SurfelPose, SurfelSettings
};

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> grid: GridShape;
@group(0) @binding(2) var<uniform> settings: SurfelSettings;
@group(0) @binding(3) var<storage, read> poses: array<SurfelPose>;
@group(0) @binding(4) var<storage, read> spans: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read> radiance: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read> forget: array<vec2<f32>>;
@group(0) @binding(7) var<storage, read_write> irradiance: array<SurfelIrradiance>;
@group(0) @binding(8) var<storage, read_write> light: array<SurfelLight>;
@if(neighbours) @group(0) @binding(9) var<storage, read_write> neighbours: array<Neighbours>;
@if(clamped) @group(0) @binding(10) var<storage, read_write> clamped: array<ClampedLight>;

const PI: f32 = 3.1415927;

@if(clamped)
fn report_clamped(surfel: u32, light: ClampedLight) {
    clamped[surfel] = light;
}
@else
fn report_clamped(surfel: u32, light: ClampedLight) {
}

@if(neighbours)
fn told(surfel: u32) -> SharingSaid {
    return sharing_unpack(neighbours[surfel]);
}
@else
fn told(surfel: u32) -> SharingSaid {
    return SharingSaid();
}

/// Whether the surfel is to ask its neighbours anew.
@if(neighbours)
fn ask_where_due(surfel: u32, state: SurfelIrradiance, forgets: f32) {
    if sharing_is_due(surfel, state, forgets, frame.number) {
        neighbours[surfel] = Neighbours(vec3<f32>(0.0), SHARING_ASKS);
    }
}
@else
fn ask_where_due(surfel: u32, state: SurfelIrradiance, forgets: f32) {}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = invocation_index(group, groups, 64u, lane);
    if i >= arrayLength(&poses) {
        return;
    }
    let pose = poses[i];
    var taken = ClampedLight();
    if pose.radius <= 0.0 {
        report_clamped(i, taken);
        return;
    }
    let span = spans[i];
    var state = irradiance[i];
    let change = forget[grid_cell(pose.position, grid)];
    if span.y > 0u {
        var sum = vec3<f32>(0.0);
        for (var ray = span.x; ray < span.x + span.y; ray++) {
            sum += radiance[ray].xyz;
        }
        let count = span.y;
        let mean_of_rays = estimator_unless_faint(sum * (PI / f32(count)), settings.faintest);
        state = estimator_forget(state, change.x, change.y, frame.number);
        taken = estimator_taken(state, mean_of_rays, count);
        state = estimator_update(state, mean_of_rays, count, frame.number, settings.clamp != 0u);
        irradiance[i] = state;
    }
    report_clamped(i, taken);
    light[i] = sharing_light(state, frame.number - state.since, told(i));
    ask_where_due(i, state, change.x);
}
