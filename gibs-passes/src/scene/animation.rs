//! Animation clips: keyframes per node.
use super::NodeId;
use glam::{DQuat, DVec3};

/// One clip.
#[derive(Clone, Debug, Default)]
pub struct Animation {
    /// Name for reports; may be empty.
    pub name: String,
    /// What it moves.
    pub channels: Vec<Channel>,
}

/// Keyframes of one property of one node.
#[derive(Clone, Debug)]
pub struct Channel {
    /// Node that moves.
    pub node: NodeId,
    /// Times in seconds, increasing, never empty.
    pub times: Vec<f32>,
    /// Values; as many as `times`, or three times as many for cubic splines (in-tangent, value, out-tangent).
    pub keyframes: Keyframes,
    /// How values between keyframes are found.
    pub interpolation: Interpolation,
}

/// Values of a channel.
#[derive(Clone, Debug)]
pub enum Keyframes {
    /// Translations, metres.
    Translation(Vec<DVec3>),
    /// Unit quaternions.
    Rotation(Vec<DQuat>),
    /// Scales.
    Scale(Vec<DVec3>),
}

/// Interpolation between keyframes (glTF 2.0, appendix C).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// Straight line; great circle for rotations.
    #[default]
    Linear,
    /// Hold.
    Step,
    /// Hermite spline.
    CubicSpline,
}
