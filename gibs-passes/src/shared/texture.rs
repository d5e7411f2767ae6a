//! Textures in packed storage, filtered alike on every backend: bilinear, no mip maps, sRGB decoded before filtering.
use super::hash;
use crate::data::{Material, NONE, Ray};
use glam::{Vec2, Vec3, Vec4};

/// Words at the start of the texel buffer that map an sRGB byte to linear, as bits of `f32`.
pub const LUT: usize = 256;

/// Bits of [`Material::flags`]: alpha mode.
pub const ALPHA_MODE: u32 = 3;
/// Alpha mode: cut out below the threshold.
pub const MASK: u32 = 1;
/// Alpha mode: alpha is coverage.
pub const BLEND: u32 = 2;
/// Bit of [`Material::flags`]: emission leaves both sides.
pub const DOUBLE_SIDED: u32 = 4;

/// Sampler bits: wrap of u in bits 0-1, of v in bits 2-3 (0 repeat, 1 mirror, 2 clamp), nearest in bit 4.
pub const NEAREST: u32 = 16;

/// The table of sRGB bytes (IEC 61966-2-1).
pub fn srgb_table() -> [u32; LUT] {
    std::array::from_fn(|i| {
        let c = i as f64 / 255.0;
        let linear = if c <= 0.04045 {
            c / 12.92
        } else {
            ((c + 0.055) / 1.055).powf(2.4)
        };
        (linear as f32).to_bits()
    })
}

/// The texel that stands for texel `i` of an axis, for `i` from `-size` to `2 * size`, where [`sample`] stays. No
/// division: four of them would cost more than the rest of a sample.
#[inline(always)]
fn wrap(i: i32, size: i32, mode: u32) -> i32 {
    match mode & 3 {
        0 => {
            let j = if i < 0 { i + size } else { i };
            let k = if j >= size { j - size } else { j };
            if k >= size { k - size } else { k }
        }
        1 => {
            let period = 2 * size;
            let j = if i < 0 { i + period } else { i };
            let k = if j >= period { j - period } else { j };
            if k < size { k } else { period - 1 - k }
        }
        _ => i.clamp(0, size - 1),
    }
}

/// Linear colour and alpha of a texel.
#[inline(always)]
fn texel(texels: &[u32], index: usize) -> Vec4 {
    let word = texels[index];
    let linear = |byte: u32| f32::from_bits(texels[(byte & 0xff) as usize]);
    Vec4::new(
        linear(word),
        linear(word >> 8),
        linear(word >> 16),
        (word >> 24) as f32 / 255.0,
    )
}

/// Texture coordinates in texels of a picture of a size. Far coordinates are folded first, so that the conversion to an
/// integer is exact.
#[inline(always)]
fn scaled(uv: Vec2, size: (i32, i32), sampler: u32) -> (f32, f32) {
    let fold = |x: f32, mode: u32| {
        if mode & 3 == 2 {
            x.clamp(-1.0, 2.0)
        } else {
            x - (x * 0.5).floor() * 2.0
        }
    };
    (
        fold(uv.x, sampler) * size.0 as f32,
        fold(uv.y, sampler >> 2) * size.1 as f32,
    )
}

#[inline(always)]
fn unpacked(size: u32) -> (i32, i32) {
    ((size & 0xffff) as i32, (size >> 16) as i32)
}

/// Linear colour and alpha at texture coordinates `uv`, texel centres at half-integers.
#[inline(always)]
pub fn sample(texels: &[u32], first: u32, packed_size: u32, sampler: u32, uv: Vec2) -> Vec4 {
    let size = unpacked(packed_size);
    let (x, y) = scaled(uv, size, sampler);
    let column = |i: f32| wrap(i as i32, size.0, sampler);
    let row = |i: f32| first as i32 + wrap(i as i32, size.1, sampler >> 2) * size.0;
    if sampler & NEAREST != 0 {
        return texel(texels, (row(y.floor()) + column(x.floor())) as usize);
    }
    let (x, y) = (x - 0.5, y - 0.5);
    let (x0, y0) = (x.floor(), y.floor());
    let (fx, fy) = (x - x0, y - y0);
    let columns = [column(x0), column(x0 + 1.0)];
    let rows = [row(y0), row(y0 + 1.0)];
    let at = |i: usize, j: usize| texel(texels, (rows[j] + columns[i]) as usize);
    let top = at(0, 0) * (1.0 - fx) + at(1, 0) * fx;
    let bottom = at(0, 1) * (1.0 - fx) + at(1, 1) * fx;
    top * (1.0 - fy) + bottom * fy
}

#[inline]
fn mapped(row: Vec3, uv: Vec2) -> f32 {
    row.x * uv.x + (row.y * uv.y + row.z)
}

/// Albedo and coverage of a material.
#[inline(always)]
pub fn base_color(material: &Material, texels: &[u32], uv: Vec2) -> Vec4 {
    let factor = material.base_color.extend(material.alpha);
    if material.base_texels == NONE {
        return factor;
    }
    let uv = Vec2::new(mapped(material.base_u, uv), mapped(material.base_v, uv));
    factor
        * sample(
            texels,
            material.base_texels,
            material.base_size,
            material.base_sampler,
            uv,
        )
}

/// Emitted radiance of a material, W/(m^2 sr).
#[inline(always)]
pub fn emission(material: &Material, texels: &[u32], uv: Vec2) -> Vec3 {
    if material.emission_texels == NONE {
        return material.emission;
    }
    let uv = Vec2::new(
        mapped(material.emission_u, uv),
        mapped(material.emission_v, uv),
    );
    let sampled = sample(
        texels,
        material.emission_texels,
        material.emission_size,
        material.emission_sampler,
        uv,
    );
    material.emission * Vec3::new(sampled.x, sampled.y, sampled.z)
}

/// Emitter sampling covers the material: its light has no texture, and all of its surface is there.
#[inline]
pub fn is_sampled_emitter(material: &Material) -> bool {
    material.emission_texels == NONE && material.flags & ALPHA_MODE == 0
}

/// A surface with coverage stops this ray. Cut-outs compare with the threshold; blended surfaces stop a ray with the
/// probability of their coverage, by a hash of ray and triangle.
#[inline]
pub fn stops(material: &Material, texels: &[u32], uv: Vec2, ray: &Ray, triangle: u32) -> bool {
    match material.flags & ALPHA_MODE {
        MASK => base_color(material, texels, uv).w >= material.cutoff,
        BLEND => {
            if ray.t_min.is_sign_negative() {
                return false;
            }
            let (o, d) = (ray.origin, ray.direction);
            let start = hash::hash3(o.x.to_bits(), o.y.to_bits(), o.z.to_bits());
            let way = hash::hash3(d.x.to_bits(), d.y.to_bits(), d.z.to_bits());
            hash::unit(hash::hash3(start, way, triangle)) < base_color(material, texels, uv).w
        }
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrapping_is_that_of_gl() {
        for size in 1..20i32 {
            for i in -size..=2 * size {
                assert_eq!(wrap(i, size, 0), i.rem_euclid(size));
                let j = i.rem_euclid(2 * size);
                assert_eq!(
                    wrap(i, size, 1),
                    if j < size { j } else { 2 * size - 1 - j }
                );
                assert_eq!(wrap(i, size, 2), i.clamp(0, size - 1));
            }
        }
    }

    /// Repeated and mirrored pictures are sampled alike a whole number of periods away, far negative coordinates
    /// included; a sample in the middle of a texel is that texel.
    #[test]
    fn samples_repeat() {
        let mut texels = srgb_table().to_vec();
        let first = texels.len() as u32;
        texels.extend((0..12u32).map(|i| i | (i << 8) | 0xff00_0000));
        let size = 4 | (3 << 16);
        for sampler in [0, 1 | (1 << 2), NEAREST] {
            let period = if sampler & 3 == 1 { 2.0 } else { 1.0 };
            for i in 0..12 {
                let uv =
                    Vec2::new((i % 4) as f32 + 0.5, (i / 4) as f32 + 0.5) / Vec2::new(4.0, 3.0);
                let here = sample(&texels, first, size, sampler, uv);
                let expected = f32::from_bits(texels[i]);
                assert!((here.x - expected).abs() <= 1e-6 && here.w == 1.0);
                for periods in [-1000.0, -1.0, 1.0, 7.0] {
                    let there = sample(&texels, first, size, sampler, uv + period * periods);
                    // The coordinate has lost ten bits, and so has the weight.
                    assert!(
                        (there - here).abs().max_element() < 1e-6,
                        "{i} {sampler} {periods}"
                    );
                }
            }
        }
    }
}
