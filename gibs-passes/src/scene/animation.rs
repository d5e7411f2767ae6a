//! Animation clips: keyframes per node.
use super::{NodeId, unit_rotation};
use glam::{DQuat, DVec3, DVec4};

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
#[non_exhaustive]
pub enum Keyframes {
    /// Translations, metres.
    Translation(Vec<DVec3>),
    /// Quaternions of any length; see [`super::LocalTransform::Parts`].
    Rotation(Vec<DQuat>),
    /// Scales.
    Scale(Vec<DVec3>),
}

/// Interpolation between keyframes (glTF 2.0, appendix C).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Interpolation {
    /// Straight line; great circle for rotations.
    #[default]
    Linear,
    /// Hold.
    Step,
    /// Hermite spline.
    CubicSpline,
}

/// Value of a channel at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sample {
    /// Translation, metres.
    Translation(DVec3),
    /// Unit quaternion.
    Rotation(DQuat),
    /// Scale per axis.
    Scale(DVec3),
}

impl Channel {
    /// Value at `time` seconds, held before the first and after the last keyframe (glTF 2.0, appendix C).
    ///
    /// `None` where the channel holds no keyframe, or fewer values than its times ask for.
    pub fn sample(&self, time: f64) -> Option<Sample> {
        let span = self.span(time)?;
        Some(match &self.keyframes {
            Keyframes::Translation(values) => Sample::Translation(self.vector(values, span)?),
            Keyframes::Scale(values) => Sample::Scale(self.vector(values, span)?),
            Keyframes::Rotation(values) => Sample::Rotation(self.rotation(values, span)?),
        })
    }

    /// The keyframes around `time`. A time that is not a number counts as the start.
    fn span(&self, time: f64) -> Option<Span> {
        let (first, last) = (
            f64::from(*self.times.first()?),
            f64::from(*self.times.last()?),
        );
        let time = if time >= first { time.min(last) } else { first };
        // Never 0, since the first time is not after the clamped one.
        let next = self.times.partition_point(|&t| f64::from(t) <= time);
        let from = next.saturating_sub(1);
        let to = next.min(self.times.len() - 1);
        let (start, end) = (f64::from(self.times[from]), f64::from(self.times[to]));
        let length = end - start;
        let t = if length > 0.0 {
            (time - start) / length
        } else {
            0.0
        };
        Some(Span {
            from,
            to,
            t,
            length,
        })
    }

    fn vector(&self, values: &[DVec3], span: Span) -> Option<DVec3> {
        let Span { from, to, t, .. } = span;
        Some(match self.interpolation {
            Interpolation::Step => *values.get(from)?,
            Interpolation::Linear => values.get(from)?.lerp(*values.get(to)?, t),
            Interpolation::CubicSpline => {
                let [p0, m0, m1, p1] = spline_points(values, span)?;
                let [h0, h1, h2, h3] = hermite(span);
                p0 * h0 + m0 * h1 + m1 * h2 + p1 * h3
            }
        })
    }

    fn rotation(&self, values: &[DQuat], span: Span) -> Option<DQuat> {
        let Span { from, to, t, .. } = span;
        Some(match self.interpolation {
            Interpolation::Step => unit_rotation(*values.get(from)?),
            Interpolation::Linear => slerp(
                unit_rotation(*values.get(from)?),
                unit_rotation(*values.get(to)?),
                t,
            ),
            Interpolation::CubicSpline => {
                let [p0, m0, m1, p1] = spline_points(values, span)?;
                let (p0, p1) = (unit_rotation(p0), unit_rotation(p1));
                let [h0, h1, h2, h3] = hermite(span);
                let sum = DVec4::from(p0) * h0
                    + DVec4::from(m0) * h1
                    + DVec4::from(m1) * h2
                    + DVec4::from(p1) * h3;
                // Opposite rotations may cancel; then the keyframe stays.
                sum.try_normalize().map_or(p0, DQuat::from_vec4)
            }
        })
    }
}

/// A place between two keyframes.
#[derive(Clone, Copy)]
struct Span {
    from: usize,
    to: usize,
    /// 0 at `from`, 1 at `to`.
    t: f64,
    /// Seconds between the two.
    length: f64,
}

/// Value and out-tangent of the span's start, in-tangent and value of its end.
fn spline_points<T: Copy>(values: &[T], span: Span) -> Option<[T; 4]> {
    Some([
        *values.get(3 * span.from + 1)?,
        *values.get(3 * span.from + 2)?,
        *values.get(3 * span.to)?,
        *values.get(3 * span.to + 1)?,
    ])
}

/// Weights of the points of [`spline_points`] (glTF 2.0, appendix C.4; tangents are per second).
fn hermite(span: Span) -> [f64; 4] {
    let t = span.t;
    let (t2, t3) = (t * t, t * t * t);
    [
        2.0 * t3 - 3.0 * t2 + 1.0,
        span.length * (t3 - 2.0 * t2 + t),
        span.length * (t3 - t2),
        3.0 * t2 - 2.0 * t3,
    ]
}

/// Constant angular speed along the shorter great circle (glTF 2.0, appendix C.3).
///
/// The angle comes from chord lengths, which stays exact for nearly equal and nearly opposite quaternions.
fn slerp(from: DQuat, to: DQuat, t: f64) -> DQuat {
    let a = DVec4::from(from);
    let b = if from.dot(to) < 0.0 {
        -DVec4::from(to)
    } else {
        DVec4::from(to)
    };
    let angle = 2.0 * (b - a).length().atan2((b + a).length());
    let sine = angle.sin();
    let blend = if sine > 1e-9 {
        a * (((1.0 - t) * angle).sin() / sine) + b * ((t * angle).sin() / sine)
    } else {
        a.lerp(b, t)
    };
    blend.try_normalize().map_or(from, DQuat::from_vec4)
}
