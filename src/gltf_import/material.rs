//! Materials: the diffuse, emissive and transparent part of glTF's.
use super::error::ImportError;
use super::source::Source;
use super::warnings::Warnings;
use gibs_passes::scene::{AlphaMode, Material, Sampler, TextureRef, Wrap};
use glam::{Affine2, Vec2, Vec3};
use gltf::json;
use gltf::json::texture::{Info, MagFilter, WrappingMode};
use gltf::json::validation::Checked;
use std::collections::BTreeMap;

/// The materials in use, with the images they need.
#[derive(Default)]
pub(super) struct MaterialSet {
    /// Materials; their textures number [`Self::images`].
    pub(super) materials: Vec<Material>,
    /// Images in use, each once.
    pub(super) images: Vec<json::Index<json::Image>>,
    /// Texture coordinate set per material; `None` without textures.
    pub(super) uv_sets: Vec<Option<u32>>,
    by_index: BTreeMap<Option<usize>, u32>,
    image_slots: BTreeMap<usize, u32>,
}

impl MaterialSet {
    /// Number of the given material (the default one for `None`), read at its first use.
    pub(super) fn number(
        &mut self,
        source: &Source,
        index: Option<json::Index<json::Material>>,
        owner: impl FnOnce() -> String,
        warnings: &mut Warnings,
    ) -> Result<u32, ImportError> {
        let key = index.map(|index| index.value());
        if let Some(&number) = self.by_index.get(&key) {
            return Ok(number);
        }
        let (material, uv_set) = match index {
            None => (
                Material {
                    name: "default".to_owned(),
                    ..Material::default()
                },
                None,
            ),
            Some(index) => {
                let material = source.get(&source.root.materials, "material", index, owner)?;
                self.read(source, index.value(), material, warnings)?
            }
        };
        let number = self.materials.len() as u32;
        self.materials.push(material);
        self.uv_sets.push(uv_set);
        self.by_index.insert(key, number);
        Ok(number)
    }

    fn read(
        &mut self,
        source: &Source,
        index: usize,
        material: &json::Material,
        warnings: &mut Warnings,
    ) -> Result<(Material, Option<u32>), ImportError> {
        let element = || format!("materials[{index}]");
        let extensions = material.extensions.as_ref();
        let diffuse = extensions.and_then(|e| e.pbr_specular_glossiness.as_ref());
        let (factor, base_texture) = match diffuse {
            Some(diffuse) => (diffuse.diffuse_factor.0, diffuse.diffuse_texture.as_ref()),
            None => {
                let pbr = &material.pbr_metallic_roughness;
                (pbr.base_color_factor.0, pbr.base_color_texture.as_ref())
            }
        };
        let strength = extensions
            .and_then(|e| e.emissive_strength.as_ref())
            .map_or(1.0, |e| e.emissive_strength.0);
        let emission = Vec3::from(material.emissive_factor.0) * strength;
        // Black emission stays black under any texture.
        let emission_info = material
            .emissive_texture
            .as_ref()
            .filter(|_| emission != Vec3::ZERO);
        let base_texture = self.texture(source, base_texture, &element, warnings)?;
        let emission_texture = self.texture(source, emission_info, &element, warnings)?;
        if let (Some((_, base)), Some((_, emission))) = (base_texture, emission_texture)
            && base != emission
        {
            warnings.once("emission coordinates", || {
                format!(
                    "{} reads its emission with texture coordinates {emission}, but its base colour with {base}; one \
                     set per material is supported, the base colour's",
                    element()
                )
            });
        }
        let transmission = extensions.and_then(|e| e.transmission.as_ref());
        if transmission
            .is_some_and(|t| t.transmission_texture.is_some() && t.transmission_factor.0 > 0.0)
        {
            warnings.once("transmission texture", || {
                format!("{} has a transmission texture, which is not supported; its factor is used alone", element())
            });
        }
        if material.normal_texture.is_some() {
            warnings.once("normal map", || {
                "normal maps are not supported; surfaces keep their vertex normals".to_owned()
            });
        }
        let alpha_mode = match material.alpha_mode {
            Checked::Valid(json::material::AlphaMode::Opaque) => AlphaMode::Opaque,
            Checked::Valid(json::material::AlphaMode::Mask) => {
                AlphaMode::Mask(material.alpha_cutoff.unwrap_or_default().0)
            }
            Checked::Valid(json::material::AlphaMode::Blend) => AlphaMode::Blend,
            Checked::Invalid => {
                let found = source.stated(&format!("/materials/{index}/alphaMode"));
                let problem = format!("has alphaMode {found}; it must be OPAQUE, MASK or BLEND");
                return Err(source.error(element(), problem));
            }
        };
        let [r, g, b, alpha] = factor;
        let uv_set = base_texture.or(emission_texture).map(|(_, set)| set);
        let material = Material {
            name: material.name.clone().unwrap_or_else(element),
            base_color: Vec3::new(r, g, b),
            alpha,
            base_color_texture: base_texture.map(|(texture, _)| texture),
            emission,
            emission_texture: emission_texture.map(|(texture, _)| texture),
            alpha_mode,
            transmission: transmission.map_or(0.0, |t| t.transmission_factor.0),
            double_sided: material.double_sided,
        };
        Ok((material, uv_set))
    }

    /// A use of a texture and its coordinate set; `None` without a texture that can be read.
    fn texture(
        &mut self,
        source: &Source,
        info: Option<&Info>,
        owner: &dyn Fn() -> String,
        warnings: &mut Warnings,
    ) -> Result<Option<(TextureRef, u32)>, ImportError> {
        let Some(info) = info else {
            return Ok(None);
        };
        let texture = source.get(&source.root.textures, "texture", info.index, owner)?;
        let element = || format!("textures[{}]", info.index.value());
        let stored = texture
            .extensions
            .as_ref()
            .and_then(|e| e.others.keys().next());
        // The document's type marks a texture without a plain image this way.
        if texture.source.value() == u32::MAX as usize {
            warnings.push(match stored {
                Some(kind) => format!(
                    "textures are stored as {kind} (first {}), which is not supported; convert them to PNG or JPEG, \
                     until then surfaces keep their plain factor",
                    element()
                ),
                None => format!("{} names no image; surfaces keep their plain factor", element()),
            });
            return Ok(None);
        }
        source.get(&source.root.images, "image", texture.source, element)?;
        let sampler = match texture.sampler {
            Some(index) => {
                let stored = source.get(&source.root.samplers, "sampler", index, element)?;
                if is_unknown(stored) {
                    warnings.once("sampler", || {
                        let i = index.value();
                        let found = source.stated(&format!("/samplers/{i}"));
                        format!("samplers[{i}] is {found}; what is unknown in it has no effect")
                    });
                }
                sampler(stored)
            }
            None => Sampler::default(),
        };
        let images = &mut self.images;
        let slot = *self
            .image_slots
            .entry(texture.source.value())
            .or_insert_with(|| {
                images.push(texture.source);
                images.len() as u32 - 1
            });
        let placed = info
            .extensions
            .as_ref()
            .and_then(|e| e.texture_transform.as_ref());
        let transform = placed.map_or(Affine2::IDENTITY, |t| {
            // Texture coordinates point down, so a counter-clockwise turn has the opposite sign of the usual matrix.
            Affine2::from_scale_angle_translation(
                Vec2::from(t.scale.0),
                -t.rotation.0,
                Vec2::from(t.offset.0),
            )
        });
        let set = placed.and_then(|t| t.tex_coord).unwrap_or(info.tex_coord);
        Ok(Some((
            TextureRef {
                texture: slot,
                sampler,
                transform,
            },
            set,
        )))
    }
}

/// Whether a sampler wraps or magnifies in a way that glTF does not know.
fn is_unknown(sampler: &json::texture::Sampler) -> bool {
    sampler.wrap_s == Checked::Invalid
        || sampler.wrap_t == Checked::Invalid
        || sampler.mag_filter == Some(Checked::Invalid)
}

/// Wrapping and filter. There are no mip maps, so only the magnification filter counts; unknown values are defaults.
fn sampler(sampler: &json::texture::Sampler) -> Sampler {
    let wrap = |mode| match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
        _ => Wrap::Repeat,
    };
    Sampler {
        wrap_u: wrap(sampler.wrap_s),
        wrap_v: wrap(sampler.wrap_t),
        nearest: matches!(sampler.mag_filter, Some(Checked::Valid(MagFilter::Nearest))),
    }
}
