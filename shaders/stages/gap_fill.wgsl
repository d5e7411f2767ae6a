// The least covered texel of each tile, and whether a surfel will be born there; beside small surfels, of each quarter of
// a tile. A workgroup has one tile of 16x16 texels, or several smaller ones.
import package::coverage::lookup_coverage;
import package::grid::grid_cell;
import package::hash::{hash_hash2, hash_hash3, hash_unit};
import package::invocation::invocation_group;
import package::lookup::LOOKUP_DROPPED;
import package::octahedral::octahedral_unpack;
import package::surface::surface_is_surface;
import package::surfel::surfel_radius_at;
import package::upsample::upsample_pixel_of;
import package::vector::vector_dot;
import package::types::{CROWDED, Camera, F32_MAX, Frame, GridShape, NONE, SurfacePoint, SurfelPose, SurfelSettings};

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> frame: Frame;
@group(0) @binding(2) var<uniform> grid: GridShape;
@group(0) @binding(3) var<uniform> settings: SurfelSettings;
@group(0) @binding(4) var<storage, read> points: array<SurfacePoint>;
@group(0) @binding(5) var<storage, read> cells: array<vec2<u32>>;
@group(0) @binding(6) var<storage, read> entries: array<u32>;
@group(0) @binding(7) var<storage, read> poses: array<SurfelPose>;
@if(depths) @group(0) @binding(8) var<storage, read> depths: array<u32>;
@group(0) @binding(9) var<storage, read_write> unseen: array<atomic<u32>>;
@group(0) @binding(10) var<storage, read_write> candidates: array<u32>;
@group(0) @binding(11) var<storage, read_write> flags: array<u32>;

/// Side of a workgroup, texels: that of the largest tile.
const GROUP: u32 = 16u;

/// Coverage, over that at which spawning stops, below which a birth is certain.
const HOLE: f32 = 0.5;

/// Coverage, over that at which spawning stops, below which a texel may have a gap at another pixel.
const AMPLE: f32 = 2.0;

/// Radius of surfels, over what it would be in the open, beside which a tile's other quarters get one as well.
const FINE: f32 = 0.5;

/// Per quarter of a tile: coverage over twice the wanted one in bits 16-31, a hash that breaks ties in bits 10-15, which of the texel's pixels
/// in bits 8-9, the lane in bits 0-7.
var<workgroup> least: array<atomic<u32>, 256>;

/// Per quarter of a tile: a crowded cell has a hole there.
var<workgroup> crowded: array<atomic<u32>, 256>;

/// A pixel sees a surfel.
fn coverage_seen(id: u32) {
    if atomicLoad(&unseen[id]) != 0u {
        atomicStore(&unseen[id], 0u);
    }
}

/// The texel of a lane.
fn texel(group: vec3<u32>, lane: u32) -> vec2<u32> {
    return group.xy * GROUP + vec2<u32>(lane % GROUP, lane / GROUP);
}

/// Which of a texel's pixels stands for it: the first of this frame, or one of the others.
fn pixel(here: vec2<u32>, turn: u32) -> vec2<u32> {
    let size = vec2<u32>(camera.width, camera.height);
    return upsample_pixel_of(here, settings.stride, frame.number + turn, size);
}

/// Holds a pixel of a texel against the least covered one of its quarter of a tile, the `within`th of the workgroup. Whether it is
/// covered amply.
fn look(here: vec2<u32>, lane: u32, turn: u32, within: u32, part: u32) -> bool {
    if any(here * settings.stride >= vec2<u32>(camera.width, camera.height)) {
        return true;
    }
    let at = pixel(here, turn);
    let point = points[at.y * camera.width + at.x];
    if !surface_is_surface(point) {
        return false;
    }
    let normal = octahedral_unpack(point.shading_normal);
    let coverage = lookup_coverage(point.position, normal);
    let share = min(coverage / (AMPLE * settings.coverage), 1.0);
    // What is covered amply bears none.
    if share >= 1.0 {
        return true;
    }
    // A cell is full whose list is as long as a lookup, or did not fit.
    let cell = cells[grid_cell(point.position, grid)];
    let is_crowded = cell.y >= settings.lookup;
    if is_crowded && share * AMPLE < HOLE {
        atomicStore(&crowded[within], 1u);
    }
    if is_crowded || cell.x == LOOKUP_DROPPED {
        return false;
    }
    let place = (turn << 8u) | lane;
    let tie = hash_hash3(part, hash_hash2(frame.number, frame.seed), place) & 0x3fu;
    atomicMin(&least[within], (u32(share * 65534.0) << 16u) | (tie << 10u) | place);
    return false;
}

/// Where one of the candidates is, a pixel.
fn pixel_at(group: vec3<u32>, candidate: u32) -> u32 {
    let at = pixel(texel(group, candidate & 0xffu), (candidate >> 8u) & 3u);
    return at.y * camera.width + at.x;
}

fn share_of(candidate: u32) -> f32 {
    return f32(candidate >> 16u) * (AMPLE / 65534.0);
}

/// Whether a surfel within reach of a point, as far as it would be in the open, is smaller than that by `FINE`.
fn is_fine(point: vec3<f32>) -> bool {
    let open = surfel_radius_at(point, F32_MAX, camera, grid, settings);
    let at = grid_cell(point, grid);
    let cell = cells[at];
    for (var i = 0u; i < min(cell.y, settings.lookup); i++) {
        let pose = poses[entries[cell.x + i]];
        let d = pose.position - point;
        let is_small = pose.radius < FINE * open;
        if is_small && vector_dot(d, d) < open * open {
            return true;
        }
    }
    return false;
}

@compute @workgroup_size(16, 16)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    // As many quarters of tiles as there is room for: two, four, eight or sixteen along each side.
    let parts = arrayLength(&candidates) / (groups.x * groups.y);
    let across = select(select(select(2u, 4u, parts >= 16u), 8u, parts >= 64u), 16u, parts >= 256u);
    let side = GROUP / across;
    let first = invocation_group(group, groups) * across * across;
    atomicStore(&least[lane], NONE);
    atomicStore(&crowded[lane], 0u);
    workgroupBarrier();
    let here = texel(group, lane);
    let within = lane / GROUP / side * across + lane % GROUP / side;
    // The other pixels of a texel only where its first one is not covered amply. Compilers inline calls, and a lookup is large:
    // there is one.
    var turns = 1u;
    for (var turn = 0u; turn < turns; turn++) {
        let is_ample = look(here, lane, turn, within, first + within);
        if turn == 0u && !is_ample {
            turns = settings.stride * settings.stride;
        }
    }
    workgroupBarrier();
    if lane >= across * across {
        return;
    }
    let corner = (lane / across & ~1u) * across + (lane % across & ~1u);
    let above = min(atomicLoad(&least[corner]), atomicLoad(&least[corner + 1u]));
    let below = min(atomicLoad(&least[corner + across]), atomicLoad(&least[corner + across + 1u]));
    let chosen = min(above, below);
    let own = atomicLoad(&least[lane]);
    var is_wanted = false;
    if own != NONE {
        if own == chosen {
            let random = hash_unit(hash_hash3(frame.number, first + corner, frame.seed));
            is_wanted = random * (1.0 - HOLE) < 1.0 - share_of(own);
        } else if share_of(own) < HOLE {
            is_wanted = is_fine(points[pixel_at(group, chosen)].position);
        }
    }
    let refused = select(NONE, CROWDED, atomicLoad(&crowded[lane]) != 0u);
    candidates[first + lane] = select(refused, pixel_at(group, own), is_wanted);
    flags[first + lane] = select(0u, 1u, is_wanted);
}
