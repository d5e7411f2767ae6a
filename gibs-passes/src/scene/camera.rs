//! The pinhole camera.
use glam::DVec3;

/// A pinhole camera; right-handed, y up by convention.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Eye, in metres.
    pub position: DVec3,
    /// A point that projects to the middle of the picture.
    pub target: DVec3,
    /// Roughly up.
    pub up: DVec3,
    /// Vertical field of view, radians.
    pub vfov: f64,
}

impl Camera {
    /// Right, up and forward, orthonormal. A degenerate camera falls back to the world's axes.
    pub fn axes(&self) -> [DVec3; 3] {
        let forward = (self.target - self.position)
            .try_normalize()
            .unwrap_or(DVec3::NEG_Z);
        let right = forward
            .cross(self.up)
            .try_normalize()
            .unwrap_or_else(|| forward.any_orthonormal_vector());
        [right, right.cross(forward), forward]
    }
}
