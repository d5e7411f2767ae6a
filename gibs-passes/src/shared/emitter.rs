//! Emitter sampling: emissive triangles by power, the sky by its map.
use super::estimator::luminance;
use crate::data::{Emitter, Frame};
use glam::Vec3;

/// Share of the distance to a point on an emitter that a shadow ray covers, so that it ends before the emitter.
pub const REACH: f32 = 1.0 - 1.0 / 4096.0;

/// Probability of drawing the sky rather than a triangle: one half where both can be; negative where neither can.
#[inline]
pub fn sky_share(frame: &Frame) -> f32 {
    match (frame.sky_sampled != 0, frame.emitter_power > 0.0) {
        (true, true) => 0.5,
        (true, false) => 1.0,
        (false, true) => 0.0,
        (false, false) => -1.0,
    }
}

/// Barycentric weights of the second and third vertex, uniform over a triangle.
#[inline]
pub fn triangle_point(a: f32, b: f32) -> (f32, f32) {
    let root = a.sqrt();
    (root * (1.0 - b), root * b)
}

/// Cosine at the emitter between its normal and the way back to the viewer, positive on the side that shines; zero or
/// less on the dark side.
#[inline]
pub fn facing(emitter: &Emitter, direction: Vec3) -> f32 {
    let normal = emitter.e1.cross(emitter.e2);
    let length = normal.dot(normal).sqrt();
    if length <= 0.0 {
        return 0.0;
    }
    let front = if emitter.flags & 2 != 0 { 1.0 } else { -1.0 };
    let cosine = normal.dot(direction) / length * front;
    if emitter.flags & 1 != 0 {
        cosine.abs()
    } else {
        cosine
    }
}

/// Radiance that an emitter sends against `direction`, W/(m^2 sr).
#[inline]
pub fn radiance(emitter: &Emitter, direction: Vec3) -> Vec3 {
    if facing(emitter, direction) > 0.0 {
        emitter.radiance
    } else {
        Vec3::ZERO
    }
}

/// Density per solid angle, 1/sr, with which sampling by power draws the point of a surface with this radiance that a
/// viewer sees at this distance under this cosine: luminance over the power of all emitters is the density per area.
#[inline]
pub fn density(frame: &Frame, radiance: Vec3, cosine: f32, distance: f32) -> f32 {
    if cosine <= 0.0 || frame.emitter_power <= 0.0 {
        return 0.0;
    }
    luminance(radiance) / frame.emitter_power * distance * distance / cosine
}
