// Ray guiding (GIBS, "Ray Guiding"): the distribution of a surfel's guide. Reads the stage's globals `guides` and
// `settings`.
import package::hash::HASH_ALMOST_ONE;
import package::octahedral::{octahedral_hemisphere_decode, octahedral_hemisphere_encode};

/// Most texels of a guide, and most texels along a side of its mip.
const GUIDE_MOST_TEXELS: u32 = 64u;
const GUIDE_MOST_BLOCKS: u32 = 4u;
/// Rays that a guide has learned from before it is used.
const GUIDE_LEAST_RAYS: u32 = 32u;
/// Rays that it has learned from when it is used in full.
const GUIDE_FULL_RAYS: f32 = 256.0;
/// Share of the rays that follow a guide in full use, of those that do not go to emitters.
const GUIDE_MOST_GUIDED: f32 = 0.5;
/// Second moment of light between texels over the square of the first, below which a guide is not used; one above, it is
/// used in full.
const GUIDE_LEAST_SPREAD: f32 = 1.25;
/// Rays in a step of the count that a guide keeps.
const GUIDE_RAYS_STEP: u32 = 4u;
/// Largest count, in steps.
const GUIDE_MOST_STEPS: u32 = 0x3ffu;

/// Texels of a guide.
fn guide_texels() -> u32 {
    return settings.guide_side * settings.guide_side;
}

/// First word of a surfel's guide, see the CPU twin.
fn guide_first(surfel: u32) -> u32 {
    return surfel * (1u + guide_texels() / 4u);
}

/// A texel's value, in steps.
fn guide_texel(surfel: u32, index: u32) -> u32 {
    return (guides[guide_first(surfel) + 1u + index / 4u] >> (index % 4u * 8u)) & 0xffu;
}

/// What tells a surfel's guide from that of the one that had the slot before, but for one in 64.
fn guide_tag(identity: u32) -> u32 {
    return identity & 0x3fu;
}

/// Rays that a guide of the surfel with this identity has learned from; none where it is another's.
fn guide_rays(surfel: u32, identity: u32) -> u32 {
    let scale = guides[guide_first(surfel)];
    return select(0u, (scale & GUIDE_MOST_STEPS) * GUIDE_RAYS_STEP, ((scale >> 10u) & 0x3fu) == guide_tag(identity));
}

/// Share of the cosine lobe in a texel: whole multiples of 2^-16, so that sums of masses are exact in whatever order.
fn guide_lobe(index: u32) -> f32 {
    // A quarter of the square with two texels along each side, then one with four, with six and with eight.
    var steps = array<u32, 30>(
        16384u,
        1457u, 4310u,
        4310u, 6307u,
        301u, 836u, 1374u,
        836u, 2422u, 3502u,
        1374u, 3502u, 2237u,
        103u, 251u, 407u, 545u,
        251u, 853u, 1418u, 1940u,
        407u, 1418u, 1597u, 1815u,
        545u, 1940u, 1815u, 1079u,
    );
    let x = index % settings.guide_side;
    let y = index / settings.guide_side;
    let last = settings.guide_side - 1u;
    let half = settings.guide_side / 2u;
    // After the squares of all smaller halves.
    let first = (half - 1u) * half * (2u * half - 1u) / 6u;
    return f32(steps[first + min(y, last - y) * half + min(x, last - x)]) * (1.0 / 65536.0);
}

/// What a texel counts in the distribution.
fn guide_mass(surfel: u32, index: u32) -> f32 {
    return f32(guide_texel(surfel, index)) * guide_lobe(index);
}

/// Sum of the distribution; zero for a guide that knows nothing.
fn guide_total(surfel: u32) -> f32 {
    let count = guide_texels();
    var sum = 0.0;
    for (var index = 0u; index < count; index++) {
        sum += guide_mass(surfel, index);
    }
    return sum;
}

/// Share of the rays of the surfel with this identity that follow the guide, of those that do not go to emitters.
fn guide_share(surfel: u32, identity: u32, total: f32) -> f32 {
    let rays = guide_rays(surfel, identity);
    if rays < GUIDE_LEAST_RAYS || total <= 0.0 {
        return 0.0;
    }
    let count = guide_texels();
    var squares = 0.0;
    for (var index = 0u; index < count; index++) {
        let value = f32(guide_texel(surfel, index));
        // The constant first: a driver may move it there.
        squares += guide_lobe(index) * (value * value);
    }
    let spread = squares / (total * total);
    let known = min(f32(rays) / GUIDE_FULL_RAYS, 1.0);
    return GUIDE_MOST_GUIDED * (clamp(spread - GUIDE_LEAST_SPREAD, 0.0, 1.0) * known);
}

/// Probability that a ray not to an emitter falls into a texel, where `share` of them follow the guide.
fn guide_probability(surfel: u32, total: f32, share: f32, index: u32) -> f32 {
    let lobe = guide_lobe(index);
    if share <= 0.0 {
        return lobe;
    }
    return lobe + (guide_mass(surfel, index) / total - lobe) * share;
}

fn guide_index(x: f32) -> u32 {
    return min(u32(max(x * f32(settings.guide_side), 0.0)), settings.guide_side - 1u);
}

/// The texel of a direction of the surfel's frame.
fn guide_texel_of(local: vec3<f32>) -> u32 {
    let uv = octahedral_hemisphere_encode(vec3<f32>(local.x, local.y, max(local.z, 0.0)));
    return guide_index(uv.y) * settings.guide_side + guide_index(uv.x);
}

/// Density per solid angle, 1/sr, of `guide_draw` in a direction of the surfel's frame.
fn guide_density(surfel: u32, total: f32, local: vec3<f32>) -> f32 {
    let s = abs(local.x) + abs(local.y) + max(local.z, 0.0);
    return guide_mass(surfel, guide_texel_of(local)) / total * (0.5 * f32(guide_texels())) / (s * s * s);
}

/// First texel of a block of 2x2.
fn guide_corner(row: u32, column: u32) -> u32 {
    return 2u * (row * settings.guide_side + column);
}

/// Mass of a block of 2x2 texels.
fn guide_block(surfel: u32, row: u32, column: u32) -> f32 {
    let first = guide_corner(row, column);
    let second = first + settings.guide_side;
    let upper = guide_mass(surfel, first) + guide_mass(surfel, first + 1u);
    let lower = guide_mass(surfel, second) + guide_mass(surfel, second + 1u);
    return upper + lower;
}

fn guide_line(surfel: u32, row: u32) -> f32 {
    let blocks = settings.guide_side / 2u;
    var sum = 0.0;
    for (var column = 0u; column < blocks; column++) {
        sum += guide_block(surfel, row, column);
    }
    return sum;
}

/// Where a walk stops, and how far within, in `[0, 1)`.
struct GuideStop {
    index: u32,
    within: f32,
}

/// Where a number in `[0, 1)` stops among masses; behind the last there are zeros.
fn guide_walk(u: f32, masses: array<f32, GUIDE_MOST_BLOCKS>) -> GuideStop {
    var all = masses;
    var left = 0.0;
    for (var index = 0u; index < GUIDE_MOST_BLOCKS; index++) {
        left += all[index];
    }
    left *= u;
    var stop = GuideStop(0u, 0.0);
    for (var index = 0u; index < GUIDE_MOST_BLOCKS; index++) {
        let mass = all[index];
        if mass > 0.0 {
            stop = GuideStop(index, min(left / mass, HASH_ALMOST_ONE));
            if left < mass {
                break;
            }
        }
        left -= mass;
    }
    return stop;
}

/// A direction of the surfel's frame: the two numbers walk a mip of 2x2 texels first, then the four of the block where they
/// stop, each along one axis. What is left of them places the direction.
fn guide_draw(surfel: u32, uv: vec2<f32>) -> vec3<f32> {
    let side = settings.guide_side;
    let blocks = side / 2u;
    var masses: array<f32, GUIDE_MOST_BLOCKS>;
    for (var index = 0u; index < blocks; index++) {
        masses[index] = guide_line(surfel, index);
    }
    let row = guide_walk(uv.y, masses);
    for (var index = 0u; index < blocks; index++) {
        masses[index] = guide_block(surfel, row.index, index);
    }
    let column = guide_walk(uv.x, masses);
    let first = guide_corner(row.index, column.index);
    let upper = guide_mass(surfel, first) + guide_mass(surfel, first + 1u);
    let lower = guide_mass(surfel, first + side) + guide_mass(surfel, first + side + 1u);
    let y = guide_walk(row.within, array<f32, GUIDE_MOST_BLOCKS>(upper, lower, 0.0, 0.0));
    let second = first + y.index * side;
    let left = guide_mass(surfel, second);
    let right = guide_mass(surfel, second + 1u);
    let x = guide_walk(column.within, array<f32, GUIDE_MOST_BLOCKS>(left, right, 0.0, 0.0));
    return octahedral_hemisphere_decode(vec2<f32>(
        (f32(column.index * 2u + x.index) + x.within) / f32(side),
        (f32(row.index * 2u + y.index) + y.within) / f32(side),
    ));
}
