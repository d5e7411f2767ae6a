// Ray guiding (GIBS, "Ray Guiding"): the distribution of a surfel's guide. Reads the stage's global `guides`.
import package::octahedral::{octahedral_hemisphere_decode, octahedral_hemisphere_encode};

const GUIDE_SIDE: u32 = 6u;
const GUIDE_TEXELS: u32 = 36u;
/// Rays that a guide has learned from before it is used.
const GUIDE_LEAST_RAYS: u32 = 32u;
/// Rays that it has learned from when it is used in full.
const GUIDE_FULL_RAYS: f32 = 256.0;
/// Share of the rays that follow a guide in full use, of those that do not go to emitters.
const GUIDE_MOST_GUIDED: f32 = 0.5;
/// The largest number below one.
const GUIDE_ALMOST_ONE: f32 = 1.0 - 1.0 / 16777216.0;

/// A texel's value, in steps.
fn guide_texel(surfel: u32, index: u32) -> u32 {
    return (guides[surfel].texels[index / 4u] >> (index % 4u * 8u)) & 0xffu;
}

/// Integral of the cosine over a texel.
fn guide_cosine_integral(index: u32) -> f32 {
    var cosines = array<f32, 9>(
        0.0144223, 0.040069, 0.0658834, 0.040069, 0.1161117, 0.1678548, 0.0658834, 0.1678548, 0.1072498
    );
    let x = index % GUIDE_SIDE;
    let y = index / GUIDE_SIDE;
    return cosines[min(y, GUIDE_SIDE - 1u - y) * 3u + min(x, GUIDE_SIDE - 1u - x)];
}

/// What a texel counts in the distribution.
fn guide_mass(surfel: u32, index: u32) -> f32 {
    return f32(guide_texel(surfel, index)) * guide_cosine_integral(index);
}

/// Sum of the distribution; zero for a guide that knows nothing.
fn guide_total(surfel: u32) -> f32 {
    var sum = 0.0;
    for (var index = 0u; index < GUIDE_TEXELS; index++) {
        sum += guide_mass(surfel, index);
    }
    return sum;
}

/// Share of the rays that follow the guide, of those that do not go to emitters.
fn guide_share(surfel: u32, total: f32) -> f32 {
    let rays = guides[surfel].scale & 0xffffu;
    if rays < GUIDE_LEAST_RAYS || total <= 0.0 {
        return 0.0;
    }
    return min(f32(rays) / GUIDE_FULL_RAYS, 1.0) * GUIDE_MOST_GUIDED;
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

/// A direction of the surfel's frame: the first number walks the texels, and what is left of it places the direction
/// within the one where it stops.
fn guide_draw(surfel: u32, total: f32, uv: vec2<f32>) -> vec3<f32> {
    var left = uv.x * total;
    var chosen = 0u;
    var within = 0.0;
    for (var index = 0u; index < GUIDE_TEXELS; index++) {
        let mass = guide_mass(surfel, index);
        if mass > 0.0 {
            chosen = index;
            within = min(left / mass, GUIDE_ALMOST_ONE);
            if left < mass {
                break;
            }
        }
        left -= mass;
    }
    let x = f32(chosen % GUIDE_SIDE);
    let y = f32(chosen / GUIDE_SIDE);
    return octahedral_hemisphere_decode(vec2<f32>((x + within) / f32(GUIDE_SIDE), (y + uv.y) / f32(GUIDE_SIDE)));
}
