//! An engine's G-buffer, and how it is to be read.
use gibs_graph::element;
use glam::Vec2;

element! {
    /// Conventions of an engine's G-buffer, and what the engine wants back. The depth is `depth_offset + depth_scale /
    /// distance along the viewing axis`; normals are in the world's axes; albedo is linear; ids are those of scene nodes.
    pub struct HostGbuffer {
        /// See above.
        depth_scale: f32,
        /// See above.
        depth_offset: f32,
        /// Depth where nothing was drawn.
        depth_clear: f32,
        /// Distance between the values of a fixed-point depth buffer; 0 for floats.
        depth_step: f32,
        /// How far the picture was moved, pixels to the right and down.
        jitter: Vec2,
        /// Encoding of normals, see `shared::gbuffer`.
        normals: u32,
        /// 1 to get radiance, 0 to get irradiance.
        radiance: u32,
        /// Factor on what the engine gets.
        exposure: f32,
        /// Number of scene nodes, which `gibs::Gi` fills in: no surface has an id from here on.
        nodes: u32,
        /// Zero.
        pad1: u32,
        /// Zero.
        pad2: u32,
    }
}

/// What cannot be said of an engine's G-buffer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HostGbufferError {
    /// There is no such near plane.
    #[error("the near plane is at {near} m; give a finite distance above zero")]
    Near {
        /// Its distance, metres.
        near: f64,
    },
    /// There is no such far plane.
    #[error(
        "the far plane is at {far} m and the near plane at {near} m; give a far plane beyond the near one, or `None` where there is none"
    )]
    Far {
        /// Distance of the near plane, metres.
        near: f64,
        /// Distance of the far plane, metres.
        far: f64,
    },
    /// A field has a value that means nothing.
    #[error("`{field}` of the G-buffer's description is {value}; it must be {expected}")]
    Field {
        /// The field.
        field: &'static str,
        /// Its value.
        value: String,
        /// What would be right.
        expected: &'static str,
    },
}

impl HostGbuffer {
    /// Depths of a perspective projection onto `[0, 1]` with these planes, metres: `far` is `None` or infinite for one
    /// without end, `reversed` if near things have the larger depths. Plain normals, no jitter, irradiance at exposure 1.
    ///
    /// # Errors
    /// [`HostGbufferError`] for a near plane that is not at a finite distance above zero, and for a far plane that is
    /// not beyond it: planes are told apart by `f32` numbers in the end.
    pub fn perspective(
        near: f64,
        far: Option<f64>,
        reversed: bool,
    ) -> Result<Self, HostGbufferError> {
        // Below this, and above the other, the device's numbers are none.
        if !(near >= f64::from(f32::MIN_POSITIVE) && near <= f64::from(f32::MAX)) {
            return Err(HostGbufferError::Near { near });
        }
        let far = far.filter(|&far| far != f64::INFINITY);
        if let Some(far) = far.filter(|&far| far.is_nan() || far <= near) {
            return Err(HostGbufferError::Far { near, far });
        }
        let (scale, offset) = match (far, reversed) {
            (None, true) => (near, 0.0),
            (None, false) => (-near, 1.0),
            // Divided through by `far`, which may be large.
            (Some(far), true) => (near / (1.0 - near / far), -near / (far - near)),
            (Some(far), false) => (-near / (1.0 - near / far), far / (far - near)),
        };
        let host = Self {
            depth_scale: scale as f32,
            depth_offset: offset as f32,
            depth_clear: if reversed { 0.0 } else { 1.0 },
            exposure: 1.0,
            ..Self::default()
        };
        match (host.check(), far) {
            (Err(_), Some(far)) => Err(HostGbufferError::Far { near, far }),
            (checked, _) => checked.map(|()| host),
        }
    }

    /// Whether a frame can be read by this description: numbers that are finite, a depth that changes with distance, an
    /// encoding of normals that there is.
    ///
    /// # Errors
    /// [`HostGbufferError::Field`] names the field, its value and what would be right.
    pub fn check(&self) -> Result<(), HostGbufferError> {
        use crate::shared::gbuffer::{NORMALS_OCTAHEDRAL, NORMALS_SIGNED, NORMALS_UNSIGNED};
        let field = |field, value: String, expected| {
            Err(HostGbufferError::Field {
                field,
                value,
                expected,
            })
        };
        let scale = self.depth_scale;
        if !(scale.is_finite() && scale != 0.0) {
            let expected = "finite and not zero; `HostGbuffer::perspective` makes it of the planes";
            return field("depth_scale", scale.to_string(), expected);
        }
        for (name, value) in [
            ("depth_offset", self.depth_offset),
            ("depth_clear", self.depth_clear),
            ("jitter.x", self.jitter.x),
            ("jitter.y", self.jitter.y),
        ] {
            if !value.is_finite() {
                return field(name, value.to_string(), "finite");
            }
        }
        for (name, value) in [("depth_step", self.depth_step), ("exposure", self.exposure)] {
            if !(value.is_finite() && value >= 0.0) {
                return field(name, value.to_string(), "finite and not negative");
            }
        }
        if ![NORMALS_SIGNED, NORMALS_UNSIGNED, NORMALS_OCTAHEDRAL].contains(&self.normals) {
            let expected = "one of `NORMALS_SIGNED` (0), `NORMALS_UNSIGNED` (1) and `NORMALS_OCTAHEDRAL` (2) of `shared::gbuffer`";
            return field("normals", self.normals.to_string(), expected);
        }
        if self.radiance > 1 {
            let expected = "1 to get radiance or 0 to get irradiance";
            return field("radiance", self.radiance.to_string(), expected);
        }
        Ok(())
    }
}
