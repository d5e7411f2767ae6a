//! What the surfels around a point say: weights, coverage and the gather (GIBS, "Light Apply", "Radial Gaussian
//! Depth").
mod several;
#[cfg(test)]
mod tests;

pub use several::{
    AT_A_TIME, Owns, Points, at_points, at_surfels, coverages, crowds, gathers, neighbours,
};

use super::depth::{openness, visibility};
use super::lists::{List, Surfels};
use super::{mark, octahedral, plane};
use crate::data::{Gathered, SurfacePoint, SurfelLight, SurfelPose};
use glam::Vec3;

/// Distances off a surfel's plane count this many times: a Mahalanobis distance with a flat ellipsoid.
pub const SQUASH: f32 = 4.0;

/// Weight of a surfel at its own centre: a point is covered (weight 1) by one surfel up to 0.71 of its radius. With 2, up to
/// 0.54, a quarter more surfels make the same error.
pub const PEAK: f32 = 4.0;

/// Surfels of less weight do not count for anything: their product with dim light would underflow, so that scaling all light
/// would not scale it exactly.
pub const LEAST_WEIGHT: f32 = 1e-12;

/// Surfels of a cell that its average takes in: the first ones, which are an unbiased subset.
pub const AVERAGE_OF: usize = 8;

/// Summed weight below which a cell's average is not made up to a full one: where next to nothing of the cell is
/// visible from a point, the little that shines through is a leak, and dividing by its weight would undo the depth
/// functions.
pub const AVERAGE_LEAST: f32 = 0.25;

/// Summed weight at which a lookup at a ray's hit ends: the surfels of a list come in no order, so that its first ones are
/// a random subset, and what that adds in noise is little beside that of the ray. At a pixel it would show. One that ends the
/// lookup keeps smaller ones, which would count for more, from being found.
pub const ENOUGH_AT_HITS: f32 = 2.0;

/// Age, in frames, at which a surfel's irradiance is fully trusted as the light of further bounces. Younger, it lacks
/// the light that its neighbours had not found yet, and a long mean would keep that lack: in a white box of albedo a,
/// the error falls with time only as t^(-2 (1 - a)).
pub const TRUSTED_AFTER: f32 = 32.0;

/// Irradiance where surfels cover a point in part: their weighted mean, and the cell's average for what their weight leaves.
#[inline]
pub fn complete(g: &Gathered) -> Vec3 {
    g.irradiance + g.average * (1.0 - g.weight)
}

/// A cell's average, of irradiance that was summed with these weights; `beyond` fills it up to the least of them.
#[inline]
pub fn average(sum: Vec3, weights: f32, beyond: Vec3) -> Vec3 {
    let lacking = (AVERAGE_LEAST - weights).max(0.0);
    (sum + beyond * lacking) / weights.max(AVERAGE_LEAST)
}

/// How far to trust a surfel that was born so many frames ago and has integrated rays, in `(0, 1]`.
#[inline]
pub fn trust(age: u32) -> f32 {
    ((age as f32 + 1.0) / TRUSTED_AFTER).min(1.0)
}

/// Nearness of a point to a surfel's centre: 1 there, 0 at the radius, one less the square of the distance over it.
/// The ellipsoid is flat along the surface's own normal: along that of shading, which may lean away, a surfel would miss most of
/// what is beside it.
#[inline]
pub fn nearness(d: Vec3, pose: &SurfelPose) -> f32 {
    let across = plane::unpack(pose.mark);
    let h = d.dot(across);
    let whole = across.dot(across);
    let squared = (d.dot(d) * whole + (SQUASH * SQUASH - 1.0) * h * h)
        / (whole * (pose.radius * pose.radius));
    (1.0 - squared).max(0.0)
}

/// Distance factor: [`PEAK`] at the centre, 0 at the radius, smooth at both.
#[inline]
pub fn falloff(d: Vec3, pose: &SurfelPose) -> f32 {
    let k = nearness(d, pose);
    PEAK * k * k
}

/// Normal factor of a surfel for a point: the eighth power of the cosine, which falls to a half at 24 degrees. A square, as
/// others take, lets light around round edges: on the atrium of Sponza it makes the error of converged irradiance 7 %
/// larger.
#[inline]
pub fn alignment(normal: Vec3, pose: &SurfelPose) -> f32 {
    let c = normal.dot(pose.normal).max(0.0);
    let squared = c * c;
    let fourth = squared * squared;
    fourth * fourth
}

/// Normal factor of a surfel for a cell's average, which takes what there is where nothing fits: with [`alignment`] foliage,
/// whose normals go anywhere, would find nothing, and be dark.
#[inline]
pub fn leaning(normal: Vec3, pose: &SurfelPose) -> f32 {
    let c = normal.dot(pose.normal).max(0.0);
    c * c
}

/// A point that is looked up.
#[derive(Clone, Copy)]
pub struct Place<'a> {
    /// Position, metres.
    pub position: Vec3,
    /// Normal.
    pub normal: Vec3,
    /// Surfels that the lookup visits: those [`around`](Surfels::around) it.
    pub list: List<'a>,
}

impl<'a> Place<'a> {
    /// A point on a surface.
    #[inline]
    pub fn new(point: &SurfacePoint, s: &Surfels<'a>) -> Self {
        Self {
            position: point.position,
            normal: octahedral::unpack(point.shading_normal),
            list: s.around(point.position),
        }
    }
}

/// Share of a surfel's light that its depth function lets through to a point within its radius, at `d` from it.
#[inline]
pub fn share(s: &Surfels<'_>, id: usize, d: Vec3) -> f32 {
    let pose = &s.poses[id];
    match s.depths.get(id) {
        Some(depth) if !mark::is_open(pose.mark) => visibility(depth, pose, d),
        _ => 1.0,
    }
}

/// Summed weight of the surfels at a point: the same weights as [`gather`]. Calls `seen` with each surfel that has any.
#[inline]
pub fn coverage(place: &Place<'_>, s: &Surfels<'_>, mut seen: impl FnMut(usize)) -> f32 {
    let mut sum = 0.0;
    for &id in place.list.ids {
        let id = id as usize;
        let pose = &s.poses[id];
        let d = place.position - pose.position;
        let mut weight = falloff(d, pose) * alignment(place.normal, pose);
        if weight > 0.0 {
            weight *= share(s, id, d);
        }
        sum += weight;
        if weight > 0.0 {
            seen(id);
        }
    }
    sum
}

/// Irradiance at a point from the surfels in its cell that have integrated any rays, up to the one with which the summed
/// weight is `enough`, at least one. The cell's average, with normal and depth weights only, is found where the summed
/// weight is below one, where it is wanted: `beyond` is what fills it up where little of the cell is visible.
#[inline]
pub fn gather(
    place: &Place<'_>,
    enough: f32,
    beyond: Option<Vec3>,
    s: &Surfels<'_>,
    light: &[SurfelLight],
) -> Gathered {
    let Place {
        position: point,
        normal,
        list,
    } = *place;
    let mut g = Gathered::default();
    let mut total = 0.0;
    let mut first = 0.0;
    for &id in list.ids {
        let id = id as usize;
        let pose = &s.poses[id];
        let d = point - pose.position;
        let mut weight = falloff(d, pose) * alignment(normal, pose);
        if weight <= 0.0 || light[id].trust == 0.0 {
            continue;
        }
        weight *= share(s, id, d);
        if weight < LEAST_WEIGHT {
            continue;
        }
        if total == 0.0 {
            first = pose.radius;
        }
        // Its kernel is spread over its disc: where small ones were needed, a large one says less. Over the first one's, so
        // that sizes of scenes do not matter.
        let shrinks = first / pose.radius;
        let dense = weight * (shrinks * shrinks);
        g.irradiance += light[id].irradiance * dense;
        g.weight += weight;
        total += dense;
        g.confidence += dense * light[id].trust;
        if g.weight >= enough {
            break;
        }
    }
    if g.weight > 0.0 {
        g.weight = g.weight.min(1.0);
        g.irradiance *= g.weight / total;
        g.confidence /= total;
    }
    let Some(beyond) = beyond.filter(|_| g.weight < 1.0) else {
        return g;
    };
    let mut average_weight = 0.0;
    for &id in &list.ids[..list.ids.len().min(AVERAGE_OF)] {
        let id = id as usize;
        let pose = &s.poses[id];
        let mut weight = leaning(normal, pose);
        if weight <= 0.0 || light[id].trust == 0.0 {
            continue;
        }
        if let Some(depth) = s.depths.get(id) {
            weight *= openness(depth, pose, point - pose.position);
        }
        if weight < LEAST_WEIGHT {
            continue;
        }
        g.average += light[id].irradiance * weight;
        average_weight += weight;
    }
    g.average = average(g.average, average_weight, beyond);
    g
}
