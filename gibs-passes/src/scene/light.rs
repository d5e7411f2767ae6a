//! Lights that are not surfaces: punctual lights, the sun, the sky.
use super::NodeId;
use glam::{DVec3, Vec3};

/// A punctual light in a node: at the node's origin, shining along the node's -z (KHR_lights_punctual).
#[derive(Clone, Debug)]
pub struct Light {
    /// Node that carries it.
    pub node: NodeId,
    /// Shape.
    pub kind: LightKind,
    /// Point and spot: radiant intensity, W/sr. Directional: irradiance, W/m^2.
    pub intensity: Vec3,
}

/// Most that a light, a surface or a sky may give in any channel, in the unit of each. Estimators square sums of a
/// million radiances, which must still fit an `f32`.
pub const MOST_RADIANCE: f32 = 1e13;

/// What an infinite radiance of an image becomes: the largest number of half precision, as in most files.
const LARGEST_TEXEL: f32 = 65_504.0;

/// The nearest radiance that a sky may have, for texels of images: negative ones and those that are not numbers become
/// 0, infinite ones 65504, the largest number of half precision; nothing exceeds [`MOST_RADIANCE`].
pub fn clamp_radiance(texel: Vec3) -> Vec3 {
    texel.map(|channel| match channel {
        v if v.is_nan() || v < 0.0 => 0.0,
        f32::INFINITY => LARGEST_TEXEL,
        v => v.min(MOST_RADIANCE),
    })
}

/// Shape of a punctual light.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum LightKind {
    /// From infinitely far.
    Directional,
    /// All directions.
    Point,
    /// A cone; half angles in radians.
    Spot {
        /// Full intensity within.
        inner: f32,
        /// None beyond.
        outer: f32,
    },
}

/// The sun of a view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// Direction in which its light travels, of any length but zero.
    pub direction: DVec3,
    /// W/m^2 on a surface that faces it.
    pub irradiance: Vec3,
}

/// What a ray sees that leaves the scene.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Environment {
    /// The same radiance from everywhere, W/(m^2 sr).
    Constant(Vec3),
    /// A latitude-longitude map.
    Map(EnvironmentMap),
}

impl Default for Environment {
    fn default() -> Self {
        Self::Constant(Vec3::ZERO)
    }
}

/// A latitude-longitude radiance map. The left edge is -z, a quarter of the way is +x, the middle is +z; the top row
/// is +y: direction d is read at u = atan2(d.x, -d.z) / 2 pi (mod 1), v = acos(d.y) / pi.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentMap {
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// `width * height` radiances, scale already applied, W/(m^2 sr). Those that are negative, not finite or above
    /// [`MOST_RADIANCE`] are clamped on the way to the device, with a warning.
    pub texels: Vec<Vec3>,
    /// Rotation of the map about +y, radians.
    pub rotation_y: f64,
}
