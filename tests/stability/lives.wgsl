// The estimator over the frames of a surfel's life, with samples that are even on [0, 2 level) or all the level itself.
import package::estimator::estimator_update;
import package::hash::{hash_hash2, hash_unit};
import package::types::SurfelIrradiance;

const FRAMES: u32 = 100000u;
const RAYS: u32 = 4u;
const FULL: u32 = 65536u;
const EVERY: u32 = 100u;
const KEPT: u32 = 344u;

@group(0) @binding(0) var<storage, read> levels: array<f32>;
@group(0) @binding(1) var<storage, read> seeds: array<u32>;
@group(0) @binding(2) var<storage, read> births: array<u32>;
@group(0) @binding(3) var<storage, read_write> means: array<f32>;
@group(0) @binding(4) var<storage, read_write> unsound: array<u32>;

/// Neither negative nor infinite nor no number. Looked at as bits, since a compiler may take numbers for finite.
fn is_sound(x: f32) -> bool {
    let bits = bitcast<u32>(x);
    return bits < 0x7f800000u || bits == 0x80000000u;
}

@compute @workgroup_size(1)
fn main(@builtin(workgroup_id) group: vec3<u32>) {
    let life = group.x;
    let level = levels[life];
    let seed = seeds[life];
    var state = SurfelIrradiance();
    var place = 0u;
    var bad = 0u;
    for (var i = 0u; i < FRAMES; i++) {
        var sample = level;
        if seed != 0u {
            sample = 2.0 * level * hash_unit(hash_hash2(i, seed));
        }
        state = estimator_update(state, vec3<f32>(sample), RAYS, births[life] + i, seed == 0u);
        let sound = is_sound(state.mean.x) && is_sound(state.short_mean.x) && is_sound(state.variance) && is_sound(state.short_noise);
        if !sound {
            bad += 1u;
        }
        if i >= FULL && i % EVERY == 0u {
            means[life * KEPT + place] = state.mean.x;
            place += 1u;
        }
    }
    unsound[life] = bad;
}
