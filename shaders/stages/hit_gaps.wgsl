// Where rays hit what no surfel covers.
import package::grid::grid_cell;
import package::hash::{hash_hash3, hash_pcg, hash_unit};
import package::invocation::invocation_index;
import package::lookup::LOOKUP_DROPPED;
import package::surface::surface_is_surface;
import package::surfel::SURFEL_AT_HIT;
import package::types::{CROWDED, DispatchArgs, Frame, Gathered, GridShape, NONE, SurfacePoint, SurfelSettings};

@group(0) @binding(0) var<uniform> batch: DispatchArgs;
@group(0) @binding(1) var<uniform> frame: Frame;
@group(0) @binding(2) var<uniform> grid: GridShape;
@group(0) @binding(3) var<uniform> settings: SurfelSettings;
@group(0) @binding(4) var<storage, read> points: array<SurfacePoint>;
@group(0) @binding(5) var<storage, read> gathered: array<Gathered>;
@group(0) @binding(6) var<storage, read> cells: array<vec2<u32>>;
@group(0) @binding(7) var<storage, read_write> candidates: array<u32>;
@group(0) @binding(8) var<storage, read_write> flags: array<u32>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = invocation_index(group, groups, 64u, lane);
    if i >= arrayLength(&candidates) {
        return;
    }
    let rate = f32(settings.hit_births) / f32(max(batch.count, 1u));
    var candidate = NONE;
    if i < batch.count && surface_is_surface(points[i]) {
        let seed = hash_hash3(i, frame.number, frame.seed);
        if hash_unit(hash_pcg(seed)) < (1.0 - gathered[i].weight) * rate {
            let cell = cells[grid_cell(points[i].position, grid)];
            if cell.y >= settings.lookup {
                candidate = CROWDED;
            } else if cell.x != LOOKUP_DROPPED {
                candidate = SURFEL_AT_HIT | i;
            }
        }
    }
    candidates[i] = candidate;
    flags[i] = select(0u, 1u, candidate != NONE && candidate != CROWDED);
}
