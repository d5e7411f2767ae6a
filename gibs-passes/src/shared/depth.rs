//! The depth function of a surfel, and the share of its light that it lets through (GIBS, "Radial Gaussian Depth").
use super::octahedral::hemisphere_encode;
use super::sampling::to_local;
use super::surface;
use crate::data::SurfelPose;
use glam::{Vec2, Vec3};

/// Least variance of the depth function, squared surfel diameters: the quantization of the moments.
pub const LEAST_VARIANCE: f32 = 1e-4;

/// Chebyshev bounds below this count as none: the bound is not tight, and a bright room shines through it.
pub const CHEBYSHEV_FLOOR: f32 = 0.6;

/// One step of a moment.
pub const MOMENT_SCALE: f32 = 1.0 / 65_535.0;

/// The farthest distance that a ray teaches, in diameters: one step below one, so that a texel that has learned from a ray
/// differs from [`UNKNOWN`].
pub const FARTHEST: f32 = 65_534.0 / 65_535.0;

/// A texel that no ray has reached, nor one beside it that found something close: both moments one, so that it hides nothing.
pub const UNKNOWN: u32 = u32::MAX;

/// A surfel's radius as a first moment, in steps.
pub const RADIUS_STEPS: u32 = 0x8000;

/// The depth functions of all surfels: texels over the hemisphere, row by row, one surfel's after the other's. A texel has the first
/// and the second moment of distance over the surfel's diameter, 16 bits each.
#[derive(Clone, Copy, Debug, Default)]
pub struct Depths<'a> {
    texels: &'a [u32],
    side: u32,
}

/// The depth function of a surfel.
#[derive(Clone, Copy, Debug)]
pub struct Depth<'a> {
    /// Texels, row by row.
    pub texels: &'a [u32],
    /// Texels along each side.
    pub side: u32,
}

impl<'a> Depths<'a> {
    /// Of so many texels along each side; without texels where a frame has no depth functions.
    #[inline]
    pub fn new(texels: &'a [u32], side: u32) -> Self {
        Self { texels, side }
    }

    /// Whether there are none.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.texels.is_empty()
    }

    /// Texels along each side.
    #[inline]
    pub fn side(&self) -> u32 {
        self.side
    }

    /// The texels of all surfels.
    #[inline]
    pub fn texels(&self) -> &'a [u32] {
        self.texels
    }

    /// First texel of a surfel.
    #[inline]
    pub fn first(&self, surfel: usize) -> usize {
        surfel * count(self.side)
    }

    /// That of a surfel; `None` in a frame without.
    #[inline]
    pub fn get(&self, surfel: usize) -> Option<Depth<'a>> {
        let texels = self
            .texels
            .get(self.first(surfel)..self.first(surfel + 1))?;
        (!texels.is_empty()).then_some(Depth {
            texels,
            side: self.side,
        })
    }
}

/// Texels of a depth function with so many along each side.
#[inline]
pub fn count(side: u32) -> usize {
    side as usize * side as usize
}

/// Whether a depth function of these texels hides nothing within the radius: in no direction is the mean distance shorter.
#[inline]
pub fn is_open(texels: impl Iterator<Item = u32>) -> bool {
    let mut texels = texels;
    texels.all(|texel| texel & 0xffff >= RADIUS_STEPS)
}

/// By how many steps the mean distance in a texel may lack a radius, in the mean over all of them, before surfaces count as close: a
/// thirty-second of the radius.
const CLOSE: u32 = RADIUS_STEPS / 32;

/// Whether a surfel has learned that surfaces are so close that its irradiance says little of places a radius away (Ward,
/// Rubinstein and Clear 1988: irradiance changes over the distance to what is around). Only what is nearer than a radius
/// counts; of a surfel that has more than doubled since it learned, that is everything. Summed in whole steps; what no ray has
/// reached is far.
#[inline]
pub fn is_crowded(texels: impl Iterator<Item = u32>) -> bool {
    let (count, lacks) = texels.fold((0, 0), |(count, lacks), texel| {
        let distance = match is_known(texel) {
            true => texel & 0xffff,
            false => RADIUS_STEPS,
        };
        (count + 1, lacks + RADIUS_STEPS.saturating_sub(distance))
    });
    lacks > count * CLOSE
}

/// Whether a ray has reached a texel. What none has reached is [`UNKNOWN`] or a [`guess`].
#[inline]
pub fn is_known(texel: u32) -> bool {
    texel != UNKNOWN && texel >> 16 != 0
}

/// Least moments of a texel that a ray has reached.
pub const KNOWN: Vec2 = Vec2::new(0.0, MOMENT_SCALE);

/// A texel that no ray has reached beside one whose mean distance, in steps, is this: as near, if that is nearer than the radius,
/// and without variance, for light that leaks shows more than light that lacks. Its second moment is zero, which tells it from
/// what a ray has taught.
#[inline]
pub fn guess(nearest: u32) -> u32 {
    match nearest < RADIUS_STEPS {
        true => nearest,
        false => UNKNOWN,
    }
}

/// The first and second moment in a texel, in steps of [`MOMENT_SCALE`].
#[inline]
fn steps(texel: u32) -> Vec2 {
    Vec2::new((texel & 0xffff) as f32, (texel >> 16) as f32)
}

/// The first and second moment in a texel.
#[inline]
pub fn moments(texel: u32) -> Vec2 {
    steps(texel) * MOMENT_SCALE
}

/// Moments in a texel, each in `[0, 1]`.
#[inline]
pub fn pack_moments(m: Vec2) -> u32 {
    surface::unorm16(m.x) | (surface::unorm16(m.y) << 16)
}

/// A texel of a depth function over another diameter, which is that of before over `shrinks`. Where the surfel has grown, nothing
/// is known beyond the diameter of before, and what was open to there counts as hidden beyond until rays tell.
#[inline]
pub fn rescaled(texel: u32, shrinks: f32) -> u32 {
    let squared = shrinks * shrinks;
    if texel == UNKNOWN {
        return UNKNOWN;
    }
    let m = moments(texel);
    let least = if is_known(texel) { KNOWN.y } else { 0.0 };
    pack_moments(Vec2::new(
        (m.x * shrinks).min(FARTHEST),
        (m.y * squared).max(least).min(FARTHEST),
    ))
}

/// Row or column of a texel, of so many along each side, for a coordinate in `[0, 1]`.
#[inline]
pub fn index(coordinate: f32, side: u32) -> u32 {
    ((coordinate * side as f32) as u32).min(side - 1)
}

/// Moments of the depth function in a direction of the surfel's frame, bilinear.
#[inline]
pub fn depth_moments(depth: Depth<'_>, local: Vec3) -> Vec2 {
    let side = depth.side as f32;
    let uv = hemisphere_encode(local) * side - 0.5;
    let low = uv.floor();
    let f = uv - low;
    let at = |dx: f32, dy: f32| {
        let x = (low.x + dx).clamp(0.0, side - 1.0) as usize;
        let y = (low.y + dy).clamp(0.0, side - 1.0) as usize;
        steps(depth.texels[y * depth.side as usize + x])
    };
    let top = at(0.0, 0.0) * (1.0 - f.x) + at(1.0, 0.0) * f.x;
    let bottom = at(0.0, 1.0) * (1.0 - f.x) + at(1.0, 1.0) * f.x;
    (top * (1.0 - f.y) + bottom * f.y) * MOMENT_SCALE
}

/// Bound on the share of the light around a surfel that reaches distance `t` (over the diameter), from moments of the
/// depth there: Chebyshev's inequality, 1 up to the mean (Donnelly and Lauritzen 2006), cubed because it is only an upper
/// bound (as Majercik et al. 2019 do).
#[inline]
pub fn chebyshev(m: Vec2, t: f32) -> f32 {
    if t <= m.x {
        return 1.0;
    }
    let variance = (m.y - m.x * m.x).max(LEAST_VARIANCE);
    let d = t - m.x;
    let bound = variance / (variance + d * d);
    let tight = ((bound - CHEBYSHEV_FLOOR) / (1.0 - CHEBYSHEV_FLOOR)).max(0.0);
    tight * tight * tight
}

/// Share of a surfel's light that reaches a point at `d` from it, by its depth function. It falls to nothing beyond the
/// diameter, of which that knows nothing.
#[inline]
pub fn visibility(depth: Depth<'_>, pose: &SurfelPose, d: Vec3) -> f32 {
    visibility_within(f32::MAX, depth, pose, d)
}

/// [`visibility`] of a point beyond the diameter too: what is open up to there counts as open.
#[inline]
pub fn openness(depth: Depth<'_>, pose: &SurfelPose, d: Vec3) -> f32 {
    visibility_within(1.0, depth, pose, d)
}

/// [`visibility`] of what is at most so many diameters away; what is farther, as if it were there.
#[inline]
pub fn visibility_within(most: f32, depth: Depth<'_>, pose: &SurfelPose, d: Vec3) -> f32 {
    let distance = d.length();
    // Nothing fits between a surfel's centre and a point this close.
    if distance < 0.02 * pose.radius {
        return 1.0;
    }
    let local = to_local(d / distance, pose.normal);
    let clamped = Vec3::new(local.x, local.y, local.z.max(0.0));
    chebyshev(
        depth_moments(depth, clamped),
        (distance / (2.0 * pose.radius)).min(most),
    )
}

#[cfg(test)]
mod tests;
