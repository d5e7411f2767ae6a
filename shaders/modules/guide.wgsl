// Ray guiding (GIBS, "Ray Guiding"): the distribution of a surfel's guide. Reads the stage's global `guides`.
import package::hash::HASH_ALMOST_ONE;
import package::octahedral::{octahedral_hemisphere_decode, octahedral_hemisphere_encode};

const GUIDE_SIDE: u32 = 6u;
const GUIDE_TEXELS: u32 = 36u;
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

/// A texel's value, in steps.
fn guide_texel(surfel: u32, index: u32) -> u32 {
    return (guides[surfel].texels[index / 4u] >> (index % 4u * 8u)) & 0xffu;
}

/// What tells a surfel's guide from that of the one that had the slot before, but for one in 64.
fn guide_tag(identity: u32) -> u32 {
    return identity & 0x3fu;
}

/// Rays that a guide of the surfel with this identity has learned from; none where it is another's.
fn guide_rays(surfel: u32, identity: u32) -> u32 {
    let scale = guides[surfel].scale;
    return select(0u, (scale & GUIDE_MOST_STEPS) * GUIDE_RAYS_STEP, ((scale >> 10u) & 0x3fu) == guide_tag(identity));
}

/// Share of the cosine lobe in a texel: whole multiples of 2^-16, so that sums of masses are exact in whatever order.
fn guide_lobe(index: u32) -> f32 {
    var shares = array<f32, 9>(
        301.0 / 65536.0, 836.0 / 65536.0, 1374.0 / 65536.0,
        836.0 / 65536.0, 2422.0 / 65536.0, 3502.0 / 65536.0,
        1374.0 / 65536.0, 3502.0 / 65536.0, 2237.0 / 65536.0,
    );
    let x = index % GUIDE_SIDE;
    let y = index / GUIDE_SIDE;
    return shares[min(y, GUIDE_SIDE - 1u - y) * 3u + min(x, GUIDE_SIDE - 1u - x)];
}

/// What a texel counts in the distribution.
fn guide_mass(surfel: u32, index: u32) -> f32 {
    return f32(guide_texel(surfel, index)) * guide_lobe(index);
}

/// Sum of the distribution; zero for a guide that knows nothing.
fn guide_total(surfel: u32) -> f32 {
    var sum = 0.0;
    for (var index = 0u; index < GUIDE_TEXELS; index++) {
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
    var squares = 0.0;
    for (var index = 0u; index < GUIDE_TEXELS; index++) {
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
    return min(u32(max(x * f32(GUIDE_SIDE), 0.0)), GUIDE_SIDE - 1u);
}

/// The texel of a direction of the surfel's frame.
fn guide_texel_of(local: vec3<f32>) -> u32 {
    let uv = octahedral_hemisphere_encode(vec3<f32>(local.x, local.y, max(local.z, 0.0)));
    return guide_index(uv.y) * GUIDE_SIDE + guide_index(uv.x);
}

/// Density per solid angle, 1/sr, of `guide_draw` in a direction of the surfel's frame.
fn guide_density(surfel: u32, total: f32, local: vec3<f32>) -> f32 {
    let s = abs(local.x) + abs(local.y) + max(local.z, 0.0);
    return guide_mass(surfel, guide_texel_of(local)) / total * (f32(GUIDE_TEXELS) * 0.5) / (s * s * s);
}

/// Mass of a texel of the mip of 3x3.
fn guide_block(surfel: u32, row: u32, column: u32) -> f32 {
    let first = row * 2u * GUIDE_SIDE + column * 2u;
    let upper = guide_mass(surfel, first) + guide_mass(surfel, first + 1u);
    let lower = guide_mass(surfel, first + GUIDE_SIDE) + guide_mass(surfel, first + GUIDE_SIDE + 1u);
    return upper + lower;
}

fn guide_line(surfel: u32, row: u32) -> f32 {
    return (guide_block(surfel, row, 0u) + guide_block(surfel, row, 1u)) + guide_block(surfel, row, 2u);
}

/// Where a walk stops, and how far within, in `[0, 1)`.
struct GuideStop {
    index: u32,
    within: f32,
}

/// Where a number in `[0, 1)` stops among masses.
fn guide_walk(u: f32, a: f32, b: f32, c: f32) -> GuideStop {
    var masses = array<f32, 3>(a, b, c);
    var left = u * ((a + b) + c);
    var stop = GuideStop(0u, 0.0);
    for (var index = 0u; index < 3u; index++) {
        let mass = masses[index];
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

/// A direction of the surfel's frame: the two numbers walk a mip of 3x3 texels first, then the four of the texel where they
/// stop, each along one axis. What is left of them places the direction.
fn guide_draw(surfel: u32, uv: vec2<f32>) -> vec3<f32> {
    let row = guide_walk(uv.y, guide_line(surfel, 0u), guide_line(surfel, 1u), guide_line(surfel, 2u));
    let column = guide_walk(
        uv.x,
        guide_block(surfel, row.index, 0u),
        guide_block(surfel, row.index, 1u),
        guide_block(surfel, row.index, 2u),
    );
    let first = row.index * 2u * GUIDE_SIDE + column.index * 2u;
    let upper = guide_mass(surfel, first) + guide_mass(surfel, first + 1u);
    let lower = guide_mass(surfel, first + GUIDE_SIDE) + guide_mass(surfel, first + GUIDE_SIDE + 1u);
    let y = guide_walk(row.within, upper, lower, 0.0);
    let second = first + y.index * GUIDE_SIDE;
    let x = guide_walk(column.within, guide_mass(surfel, second), guide_mass(surfel, second + 1u), 0.0);
    return octahedral_hemisphere_decode(vec2<f32>(
        (f32(column.index * 2u + x.index) + x.within) / f32(GUIDE_SIDE),
        (f32(row.index * 2u + y.index) + y.within) / f32(GUIDE_SIDE),
    ));
}
