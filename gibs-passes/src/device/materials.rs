//! Materials and textures into packed storage.
use crate::data::{Material, NONE};
use crate::scene::{self, AlphaMode, Sampler, SceneDataError, Sound, Texture, TextureRef, Wrap};
use crate::shared::texture;
use glam::Vec3;
use std::collections::HashMap;

/// Most texels of all textures together: kernels know them by signed indices.
const MOST_TEXELS: u64 = i32::MAX as u64;

/// Device materials, and the texels of all textures that they use.
///
/// # Errors
/// [`SceneDataError::Value`] of textures with more texels than kernels can tell apart.
pub(super) fn pack(scene: &Sound<'_>) -> Result<(Vec<Material>, Vec<u32>), SceneDataError> {
    let sizes = scene.textures.iter();
    let sizes = sizes.map(|t| u64::from(t.width) * u64::from(t.height));
    let all = sizes.fold(texture::srgb_table().len() as u64, u64::saturating_add);
    if all > MOST_TEXELS {
        return Err(SceneDataError::Value {
            element: format!("all {} textures", scene.textures.len()),
            what: "number of texels".into(),
            value: all.to_string(),
            expected: "below 2^31; make some smaller, or leave them out",
        });
    }
    let mut texels = texture::srgb_table().to_vec();
    let mut placed: HashMap<u32, u32> = HashMap::new();
    let materials = scene
        .materials
        .iter()
        .map(|m| material(scene.textures, m, &mut texels, &mut placed))
        .collect();
    Ok((materials, texels))
}

fn material(
    textures: &[Texture],
    material: &scene::Material,
    texels: &mut Vec<u32>,
    placed: &mut HashMap<u32, u32>,
) -> Material {
    let (mut flags, mut cutoff) = match material.alpha_mode {
        AlphaMode::Opaque => (0, 0.0),
        AlphaMode::Mask(cutoff) => (texture::MASK, cutoff),
        AlphaMode::Blend => (texture::BLEND, 0.0),
    };
    let opaque = material.alpha_mode == AlphaMode::Opaque;
    let mut alpha = if opaque { 1.0 } else { material.alpha };
    // Transmission leaves its share of the coverage; with a cut-out, what is not cut out.
    if material.transmission > 0.0 {
        flags = texture::BLEND;
        cutoff = 0.0;
        alpha *= 1.0 - material.transmission;
    }
    if material.double_sided {
        flags |= texture::DOUBLE_SIDED;
    }
    let mut packed = Material {
        base_color: material.base_color,
        alpha,
        emission: material.emission,
        flags,
        base_texels: NONE,
        emission_texels: NONE,
        cutoff,
        ..Material::default()
    };
    if let Some(used) = &material.base_color_texture {
        let slot = slot(textures, used, texels, placed);
        (packed.base_texels, packed.base_size, packed.base_sampler) =
            (slot.first, slot.size, slot.sampler);
        (packed.base_u, packed.base_v) = (slot.u, slot.v);
    }
    if let Some(used) = material
        .emission_texture
        .as_ref()
        .filter(|_| material.emission != Vec3::ZERO)
    {
        let slot = slot(textures, used, texels, placed);
        (
            packed.emission_texels,
            packed.emission_size,
            packed.emission_sampler,
        ) = (slot.first, slot.size, slot.sampler);
        (packed.emission_u, packed.emission_v) = (slot.u, slot.v);
    }
    packed
}

struct Slot {
    first: u32,
    size: u32,
    sampler: u32,
    u: Vec3,
    v: Vec3,
}

fn slot(
    textures: &[Texture],
    used: &TextureRef,
    texels: &mut Vec<u32>,
    placed: &mut HashMap<u32, u32>,
) -> Slot {
    let source = &textures[used.texture as usize];
    let first = *placed.entry(used.texture).or_insert_with(|| {
        let first = texels.len() as u32;
        texels.extend(source.texels.iter().map(|&t| u32::from_le_bytes(t)));
        first
    });
    let m = used.transform;
    Slot {
        first,
        size: source.width | (source.height << 16),
        sampler: sampler_bits(&used.sampler),
        u: Vec3::new(m.matrix2.x_axis.x, m.matrix2.y_axis.x, m.translation.x),
        v: Vec3::new(m.matrix2.x_axis.y, m.matrix2.y_axis.y, m.translation.y),
    }
}

fn sampler_bits(sampler: &Sampler) -> u32 {
    let wrap = |w: Wrap| match w {
        Wrap::Repeat => 0,
        Wrap::Mirror => 1,
        Wrap::Clamp => 2,
    };
    let nearest = if sampler.nearest { texture::NEAREST } else { 0 };
    wrap(sampler.wrap_u) | (wrap(sampler.wrap_v) << 2) | nearest
}
