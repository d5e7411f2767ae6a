//! Materials and textures. Every surface is Lambertian with its base colour.
use glam::{Affine2, Vec3};

/// How alpha acts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum AlphaMode {
    /// Alpha is ignored.
    #[default]
    Opaque,
    /// Cut out where alpha is below the value.
    Mask(f32),
    /// Alpha is coverage: light passes with probability `1 - alpha`.
    Blend,
}

/// A Lambertian material.
#[derive(Clone, Debug)]
pub struct Material {
    /// Name for reports; may be empty.
    pub name: String,
    /// Linear base colour factor (albedo), 0..1.
    pub base_color: Vec3,
    /// Alpha factor, multiplied with the texture's alpha.
    pub alpha: f32,
    /// Base colour texture: sRGB, alpha linear.
    pub base_color_texture: Option<TextureRef>,
    /// Emitted radiance, W/(m^2 sr): factor times strength.
    pub emission: Vec3,
    /// Texture that multiplies `emission`: sRGB.
    pub emission_texture: Option<TextureRef>,
    /// How alpha acts.
    pub alpha_mode: AlphaMode,
    /// Share of light that passes through (KHR_materials_transmission), 0..1; coverage is `alpha * (1 - transmission)`.
    pub transmission: f32,
    /// Emission leaves both sides. Reflection always does.
    pub double_sided: bool,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: Vec3::ONE,
            alpha: 1.0,
            base_color_texture: None,
            emission: Vec3::ZERO,
            emission_texture: None,
            alpha_mode: AlphaMode::Opaque,
            transmission: 0.0,
            double_sided: false,
        }
    }
}

/// A use of a texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureRef {
    /// Index into [`super::Scene::textures`].
    pub texture: u32,
    /// How coordinates outside the unit square and between texels are read.
    pub sampler: Sampler,
    /// Map from the mesh's texture coordinates to the ones used (KHR_texture_transform).
    pub transform: Affine2,
}

/// How a texture is read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sampler {
    /// Horizontal wrap.
    pub wrap_u: Wrap,
    /// Vertical wrap.
    pub wrap_v: Wrap,
    /// Nearest texel instead of bilinear.
    pub nearest: bool,
}

/// What lies outside the unit square.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Wrap {
    /// The texture again.
    #[default]
    Repeat,
    /// The texture mirrored.
    Mirror,
    /// The edge texel.
    Clamp,
}

/// A decoded image, 8 bits per channel, row by row from the top.
#[derive(Clone, Debug, Default)]
pub struct Texture {
    /// Name for reports; may be empty.
    pub name: String,
    /// Width in texels, at least 1.
    pub width: u32,
    /// Height in texels, at least 1.
    pub height: u32,
    /// `width * height` texels: sRGB colour, linear alpha.
    pub texels: Vec<[u8; 4]>,
}
