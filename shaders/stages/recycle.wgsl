// Which surfels give up their slots.
import package::coverage::lookup_coverage;
import package::hash::{hash_hash3, hash_unit};
import package::invocation::invocation_index;
import package::lookup::LOOKUP_PEAK;
import package::mark::mark_identity;
import package::recycling::{RECYCLING_CHOSEN, recycling_chance, recycling_looks};
import package::types::{Camera, Frame, GridShape, SurfelCounters, SurfelPose, SurfelSettings};
import package::vector::vector_length;

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> frame: Frame;
@group(0) @binding(2) var<uniform> grid: GridShape;
@group(0) @binding(3) var<uniform> settings: SurfelSettings;
@group(0) @binding(4) var<storage, read> cells: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read> entries: array<u32>;
@group(0) @binding(6) var<storage, read> poses: array<SurfelPose>;
@if(depths) @group(0) @binding(7) var<storage, read> depths: array<u32>;
@group(0) @binding(8) var<storage, read> counters: array<SurfelCounters>;
@group(0) @binding(9) var<storage, read_write> unseen: array<u32>;

/// The surfel that looks around, and what it adds to the coverage of its place: in a long list a lookup may not visit it.
var<private> looking: u32;
var<private> own_weight: f32;

fn coverage_seen(id: u32) {
    if id == looking {
        own_weight = LOOKUP_PEAK;
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
    if pose.radius <= 0.0 {
        return;
    }
    let used = f32(counters[0].live) / f32(max(settings.capacity, 1u));
    var others = 0.0;
    if recycling_looks(mark_identity(pose.mark), frame.number) {
        looking = i;
        own_weight = 0.0;
        others = lookup_coverage(pose.position, pose.normal);
        others -= own_weight;
    }
    let distance = vector_length(pose.position - camera.eye) / grid.half;
    let chance = recycling_chance(used, unseen[i], distance, others / settings.coverage);
    let random = hash_unit(hash_hash3(mark_identity(pose.mark), frame.number, frame.seed));
    if random < chance {
        unseen[i] = RECYCLING_CHOSEN;
    }
}
