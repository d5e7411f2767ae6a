//! Where rays from surfaces go: over the cosine lobe, or to points on emissive triangles. Each ray is one sample of the
//! mixture of both, weighted by the balance heuristic (Veach 1997, section 9.2.2): what can be found in either way has
//! the summed density.
use super::{emitter, hash, sampling};
use crate::data::Emitter;
use crate::stages::reference_emitters::find;
use glam::Vec3;
use std::f32::consts::FRAC_1_PI;

/// Share of the rays that go to emitters, in a scene that has some.
pub const TO_EMITTERS: f32 = 1.0 / 3.0;

/// A ray to an emitter ends this share of its length beyond it, so that it arrives whatever the rounding, and counts as
/// arrived where it comes as close as this share before it.
pub const SLACK: f32 = 1.0 / 4096.0;

/// Whether ray `index` of a surfel goes to an emitter: [`TO_EMITTERS`] of any run of indices, by the golden ratio's sequence.
#[inline]
pub fn goes_to_emitter(index: u32, shift: u32) -> bool {
    let place = index.wrapping_mul(0x9e37_79b9).wrapping_add(shift);
    place < (TO_EMITTERS * 4_294_967_296.0) as u32
}

/// Density of the rays over the lobe at this cosine, 1/sr, with or without emitters to share with.
#[inline]
pub fn lobe_density(cosine: f32, emitters: bool) -> f32 {
    // One constant, because compilers join two.
    let scale = if emitters {
        FRAC_1_PI * (1.0 - TO_EMITTERS)
    } else {
        FRAC_1_PI
    };
    cosine.max(0.0) * scale
}

/// The density of the lobe where `guided` of its rays follow a guide with density `guide` there.
#[inline]
pub fn guided_density(cosine: f32, guide: f32, guided: f32, emitters: bool) -> f32 {
    let share = if emitters { 1.0 - TO_EMITTERS } else { 1.0 };
    let lobe = cosine.max(0.0) * FRAC_1_PI;
    (lobe + (guide - lobe) * guided) * share
}

/// Whether a ray follows the guide, which `guided` of the rays do, and what is left of `u` in `[0, 1)`, which decides it: one
/// sequence serves guide and lobe, so that its points lie evenly in both.
#[inline]
pub fn follow_guide(u: f32, guided: f32) -> (bool, f32) {
    if u < guided {
        return (true, (u / guided).min(hash::ALMOST_ONE));
    }
    let left = (u - guided) / (1.0 - guided);
    (false, left.min(hash::ALMOST_ONE))
}

/// What a sample counts: the cosine lobe's density over that of the mixture. `lobe` is [`lobe_density`] there, `emitter`
/// the density per solid angle with which emitter sampling draws the point that was hit, zero for any other.
#[inline]
pub fn weight(cosine: f32, lobe: f32, emitter: f32) -> f32 {
    let density = lobe + TO_EMITTERS * emitter;
    if density > 0.0 {
        cosine.max(0.0) * FRAC_1_PI / density
    } else {
        0.0
    }
}

/// Where a ray goes.
#[derive(Clone, Copy, Debug)]
pub struct Drawn {
    /// Unit direction.
    pub direction: Vec3,
    /// End of the ray.
    pub t_max: f32,
    /// Cosine with the normal.
    pub cosine: f32,
    /// As [`Path::density`](crate::data::Path::density).
    pub density: f32,
}

/// A ray over the lobe about `normal`, from two numbers in `[0, 1)`.
#[inline(always)]
pub fn over_the_lobe(normal: Vec3, (u, v): (f32, f32), emitters: bool) -> Drawn {
    let local = sampling::cosine_hemisphere(u, v);
    Drawn {
        direction: sampling::to_world(local, normal),
        t_max: f32::MAX,
        cosine: local.z,
        density: lobe_density(local.z, emitters),
    }
}

/// A ray to a point of an emitter; one without length where it does not face the surface.
#[inline(always)]
pub fn to_emitter(
    emitters: &[Emitter],
    position: Vec3,
    normal: Vec3,
    (u, v): (f32, f32),
    seed: u32,
) -> Drawn {
    let which = hash::unit(hash::hash2(seed, 0x656d_6974));
    let index = find(emitters.len() as u32, which, |k| {
        emitters[k as usize].cumulative
    });
    let chosen = &emitters[index as usize];
    let (b, c) = emitter::triangle_point(u, v);
    let d = chosen.v0 + chosen.e1 * b + chosen.e2 * c - position;
    let distance = d.dot(d).sqrt();
    let direction = d / distance.max(1e-30);
    let cosine = normal.dot(direction);
    if cosine <= 0.0 || emitter::facing(chosen, direction) <= 0.0 {
        return Drawn {
            direction: normal,
            t_max: 0.0,
            cosine: 0.0,
            density: -1.0,
        };
    }
    Drawn {
        direction,
        t_max: distance * (1.0 + SLACK),
        cosine,
        density: -lobe_density(cosine, true),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_third_of_any_run_goes_to_emitters() {
        for shift in [0, 0x1234_5678, u32::MAX] {
            for first in [0, 1000, u32::MAX - 50] {
                let hits = (0..99).filter(|i| goes_to_emitter(first.wrapping_add(*i), shift));
                let count = hits.count();
                assert!((31..=35).contains(&count), "{count}");
            }
        }
    }

    /// A lamp that covers a share `c` of the lobe: the mixture's mean is what the cosine lobe alone integrates to, and
    /// without emitters the weight is one.
    #[test]
    fn the_mixture_integrates_to_the_same() {
        for cosine in [0.1f32, 0.5, 1.0] {
            assert!((weight(cosine, lobe_density(cosine, false), 0.0) - 1.0).abs() < 1e-6);
            for emitter in [0.01f32, 1.0, 100.0] {
                // Density of the mixture times the weight is the lobe's own density, where both can draw.
                let lobe = lobe_density(cosine, true);
                let density = lobe + TO_EMITTERS * emitter;
                let got = density * weight(cosine, lobe, emitter);
                assert!((got / (cosine * FRAC_1_PI) - 1.0).abs() < 1e-6);
            }
        }
    }
}
