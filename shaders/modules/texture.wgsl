// Textures in packed storage, filtered alike on every backend: bilinear, no mip maps, sRGB decoded before filtering.
// Reads the stage's globals `materials` and, where the stage binds it, `texels`, whose first 256 words map an sRGB byte
// to linear; where it does not, no material has a texture.
import package::hash::{hash_hash3, hash_unit};
import package::types::{Corners, NONE, Ray};

/// Bits of a material's flags: alpha mode.
const TEXTURE_ALPHA_MODE: u32 = 3u;
/// Alpha mode: cut out below the threshold.
const TEXTURE_MASK: u32 = 1u;
/// Alpha mode: alpha is coverage.
const TEXTURE_BLEND: u32 = 2u;
/// Bit of a material's flags: emission leaves both sides.
const TEXTURE_DOUBLE_SIDED: u32 = 4u;
/// Sampler bits: wrap of u in bits 0-1, of v in bits 2-3 (0 repeat, 1 mirror, 2 clamp), nearest in bit 4.
const TEXTURE_NEAREST: u32 = 16u;

/// A texture as a material names it.
struct TextureView {
    first: u32,
    size: vec2<i32>,
    wrapping: u32,
}

/// The texel that stands for texel `i` of an axis, for `i` from `-size` to `2 * size`, where a sample stays.
fn texture_wrap(i: i32, size: i32, mode: u32) -> i32 {
    switch mode & 3u {
        case 0u: {
            let j = select(i, i + size, i < 0);
            let k = select(j, j - size, j >= size);
            return select(k, k - size, k >= size);
        }
        case 1u: {
            let period = 2 * size;
            let j = select(i, i + period, i < 0);
            let k = select(j, j - period, j >= period);
            return select(period - 1 - k, k, k < size);
        }
        default: {
            return clamp(i, 0, size - 1);
        }
    }
}

@if(texels)
fn texture_linear(byte: u32) -> f32 {
    return bitcast<f32>(texels[byte & 0xffu]);
}

@if(texels)
fn texture_texel(view: TextureView, x: i32, y: i32) -> vec4<f32> {
    let column = texture_wrap(x, view.size.x, view.wrapping);
    let row = texture_wrap(y, view.size.y, view.wrapping >> 2u);
    let word = texels[u32(i32(view.first) + row * view.size.x + column)];
    let alpha = f32(word >> 24u) / 255.0;
    return vec4<f32>(texture_linear(word), texture_linear(word >> 8u), texture_linear(word >> 16u), alpha);
}

/// Far coordinates are folded first, so that the integer conversion is exact.
fn texture_fold(x: f32, mode: u32) -> f32 {
    if (mode & 3u) == 2u {
        return clamp(x, -1.0, 2.0);
    }
    return x - floor(x * 0.5) * 2.0;
}

/// Linear colour and alpha at texture coordinates `uv`, texel centres at half-integers.
@if(texels)
fn texture_sample(first: u32, packed_size: u32, wrapping: u32, uv: vec2<f32>) -> vec4<f32> {
    let size = vec2<i32>(i32(packed_size & 0xffffu), i32(packed_size >> 16u));
    let view = TextureView(first, size, wrapping);
    let p = vec2<f32>(texture_fold(uv.x, wrapping), texture_fold(uv.y, wrapping >> 2u)) * vec2<f32>(size);
    if (wrapping & TEXTURE_NEAREST) != 0u {
        let nearest = vec2<i32>(floor(p));
        return texture_texel(view, nearest.x, nearest.y);
    }
    let q = p - 0.5;
    let low = floor(q);
    let f = q - low;
    let at = vec2<i32>(low);
    let top = texture_texel(view, at.x, at.y) * (1.0 - f.x) + texture_texel(view, at.x + 1, at.y) * f.x;
    let bottom =
        texture_texel(view, at.x, at.y + 1) * (1.0 - f.x) + texture_texel(view, at.x + 1, at.y + 1) * f.x;
    return top * (1.0 - f.y) + bottom * f.y;
}
@else
fn texture_sample(first: u32, packed_size: u32, wrapping: u32, uv: vec2<f32>) -> vec4<f32> {
    return vec4<f32>(1.0);
}

/// The inner sum is the one that compilers make of either grouping, so that all backends round alike.
fn texture_mapped(row: vec3<f32>, uv: vec2<f32>) -> f32 {
    return row.x * uv.x + (row.y * uv.y + row.z);
}

/// Texture coordinates of a point on a triangle.
fn texture_uv_at(uvs: array<vec2<f32>, 3>, u: f32, v: f32) -> vec2<f32> {
    return uvs[0] * (1.0 - u - v) + uvs[1] * u + uvs[2] * v;
}

/// Albedo and coverage of a material.
fn texture_base_color(index: u32, uv: vec2<f32>) -> vec4<f32> {
    let material = &materials[index];
    let factor = vec4<f32>((*material).base_color, (*material).alpha);
    let first = (*material).base_texels;
    if first == NONE {
        return factor;
    }
    let at = vec2<f32>(texture_mapped((*material).base_u, uv), texture_mapped((*material).base_v, uv));
    return factor * texture_sample(first, (*material).base_size, (*material).base_sampler, at);
}

/// Emitted radiance of a material, W/(m^2 sr).
fn texture_emission(index: u32, uv: vec2<f32>) -> vec3<f32> {
    let material = &materials[index];
    let first = (*material).emission_texels;
    if first == NONE {
        return (*material).emission;
    }
    let at = vec2<f32>(texture_mapped((*material).emission_u, uv), texture_mapped((*material).emission_v, uv));
    let sampled = texture_sample(first, (*material).emission_size, (*material).emission_sampler, at);
    return (*material).emission * sampled.xyz;
}

/// Emitter sampling covers the material: its light has no texture, and all of its surface is there.
fn texture_is_sampled_emitter(index: u32) -> bool {
    return materials[index].emission_texels == NONE && (materials[index].flags & TEXTURE_ALPHA_MODE) == 0u;
}

/// A surface with coverage stops this ray. Cut-outs compare with the threshold; blended surfaces stop a ray with the
/// probability of their coverage, by a hash of ray and triangle, and no ray whose `t_min` has its sign bit set.
fn texture_stops(index: u32, uv: vec2<f32>, ray: Ray, triangle: u32) -> bool {
    switch materials[index].flags & TEXTURE_ALPHA_MODE {
        case TEXTURE_MASK: {
            return texture_base_color(index, uv).w >= materials[index].cutoff;
        }
        case TEXTURE_BLEND: {
            if (bitcast<u32>(ray.t_min) >> 31u) != 0u {
                return false;
            }
            let o = bitcast<vec3<u32>>(ray.origin);
            let d = bitcast<vec3<u32>>(ray.direction);
            let chance = hash_unit(hash_hash3(hash_hash3(o.x, o.y, o.z), hash_hash3(d.x, d.y, d.z), triangle));
            return chance < texture_base_color(index, uv).w;
        }
        default: {
            return true;
        }
    }
}
