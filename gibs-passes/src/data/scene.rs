//! What a scene is made of.
use gibs_graph::element;
use glam::{Vec2, Vec3, Vec4};

element! {
    /// Normals and texture coordinates of a triangle's vertices.
    pub struct Corners {
        /// Packed vertex normals, in the bottom level's space.
        normals: [u32; 3],
        /// 1 where there are vertex normals.
        smooth: u32,
        /// Texture coordinates.
        uvs: [Vec2; 3],
    }

    /// A Lambertian material.
    pub struct Material {
        /// Linear base colour factor.
        base_color: Vec3,
        /// Alpha factor, times one minus transmission.
        alpha: f32,
        /// Emitted radiance, W/(m^2 sr).
        emission: Vec3,
        /// See `shared::texture`: alpha mode, two-sidedness.
        flags: u32,
        /// Map of the texture coordinates to the base colour texture's u.
        base_u: Vec3,
        /// First word of the base colour texture; `u32::MAX` for none.
        base_texels: u32,
        /// Map of the texture coordinates to the base colour texture's v.
        base_v: Vec3,
        /// Width and, from bit 16, height of the base colour texture.
        base_size: u32,
        /// Map of the texture coordinates to the emission texture's u.
        emission_u: Vec3,
        /// First word of the emission texture; `u32::MAX` for none.
        emission_texels: u32,
        /// Map of the texture coordinates to the emission texture's v.
        emission_v: Vec3,
        /// Width and, from bit 16, height of the emission texture.
        emission_size: u32,
        /// Cut-out threshold.
        cutoff: f32,
        /// Sampler bits of the base colour texture.
        base_sampler: u32,
        /// Sampler bits of the emission texture.
        emission_sampler: u32,
        /// Zero.
        pad: u32,
    }

    /// A light that is not a surface.
    pub struct Light {
        /// Position of a point or spot light.
        position: Vec3,
        /// 0 directional, 1 point, 2 spot.
        kind: u32,
        /// Radiant intensity, W/sr; irradiance, W/m^2, of a directional light.
        intensity: Vec3,
        /// Cosine of the outer half angle of a spot.
        cos_outer: f32,
        /// Direction in which it shines.
        direction: Vec3,
        /// Cosine of the inner half angle of a spot.
        cos_inner: f32,
    }

    /// An emissive triangle in the world.
    pub struct Emitter {
        /// First vertex.
        v0: Vec3,
        /// Probability that emitter sampling draws this one or one before it.
        cumulative: f32,
        /// Second vertex minus first.
        e1: Vec3,
        /// Bit 0: shines on both sides. Bit 1: its instance mirrors, so that the front is the clockwise side.
        flags: u32,
        /// Third vertex minus first.
        e2: Vec3,
        /// Zero.
        pad: u32,
        /// Emitted radiance, W/(m^2 sr).
        radiance: Vec3,
        /// Zero.
        pad1: u32,
    }

    /// Affine map of a node to the world, and back.
    pub struct Transform {
        /// Rows of the map to the world.
        to_world: [Vec4; 3],
        /// Rows of the map from the world.
        to_local: [Vec4; 3],
    }
}
