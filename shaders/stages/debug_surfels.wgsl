// What a debug view shows of each surfel.
import package::debug::{
    DEBUG_VIEW_LIFE, DEBUG_VIEW_RADIUS, DEBUG_VIEW_RAY_COUNT, DEBUG_VIEW_SURFELS, DEBUG_VIEW_UNSEEN, DEBUG_VIEW_VARIANCE
};
import package::estimator::{ESTIMATOR_FULL_CONFIDENCE, estimator_luminance};
import package::invocation::invocation_index;
import package::types::{Camera, Frame, SurfelBirth, SurfelIrradiance, SurfelPose, SurfelSettings};
import package::vector::vector_length;

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> frame: Frame;
@group(0) @binding(2) var<uniform> settings: SurfelSettings;
@group(0) @binding(3) var<storage, read> poses: array<SurfelPose>;
@if(births) @group(0) @binding(4) var<storage, read> births: array<SurfelBirth>;
@if(irradiance) @group(0) @binding(5) var<storage, read> irradiance: array<SurfelIrradiance>;
@if(spans) @group(0) @binding(6) var<storage, read> spans: array<vec2<u32>>;
@if(unseen) @group(0) @binding(7) var<storage, read> unseen: array<u32>;
@group(0) @binding(8) var<storage, read_write> values: array<f32>;

/// Of a surfel at the eye itself, for a radius that is a number.
const LEAST_DISTANCE: f32 = 1e-20;

@if(births)
fn born(i: u32) -> u32 {
    return births[i].frame;
}
@else
fn born(i: u32) -> u32 {
    return 0u;
}

/// Rays have been integrated, which only some views ask.
@if(irradiance)
fn has_light(i: u32) -> bool {
    return irradiance[i].samples > 0u;
}
@else
fn has_light(i: u32) -> bool {
    return true;
}

/// Standard deviation of what so many rays bring that the estimator is fully confident, over the mean.
@if(irradiance)
fn deviation(i: u32) -> f32 {
    let state = irradiance[i];
    let level = max(estimator_luminance(state.mean), estimator_luminance(state.short_mean));
    if level <= 0.0 {
        return 0.0;
    }
    return sqrt(state.variance / ESTIMATOR_FULL_CONFIDENCE) / level;
}
@else
fn deviation(i: u32) -> f32 {
    return 0.0;
}

@if(spans)
fn rays_of(i: u32) -> u32 {
    return spans[i].y;
}
@else
fn rays_of(i: u32) -> u32 {
    return 0u;
}

@if(unseen)
fn frames_unseen(i: u32) -> u32 {
    return unseen[i];
}
@else
fn frames_unseen(i: u32) -> u32 {
    return 0u;
}

fn value(i: u32, pose: SurfelPose) -> f32 {
    switch settings.debug {
        case DEBUG_VIEW_SURFELS: {
            return f32(i);
        }
        case DEBUG_VIEW_RADIUS: {
            let distance = max(vector_length(pose.position - camera.eye), LEAST_DISTANCE);
            return pose.radius / (camera.pixel_angle * distance);
        }
        case DEBUG_VIEW_VARIANCE: {
            return deviation(i);
        }
        case DEBUG_VIEW_RAY_COUNT: {
            return f32(rays_of(i));
        }
        case DEBUG_VIEW_LIFE: {
            return f32(frame.number - born(i));
        }
        case DEBUG_VIEW_UNSEEN: {
            return f32(frames_unseen(i));
        }
        default: {
            return 1.0;
        }
    }
}

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
    if pose.radius <= 0.0 || !has_light(i) {
        values[i] = -1.0;
        return;
    }
    values[i] = value(i, pose);
}
