//! `persistent/generate_rays`: rays over each surfel's cosine lobe (I1), by its guide (I6), and to emitters (L6).
use crate::data::{
    Emitter, Frame, Path, Ray, SurfelBirth, SurfelIrradiance, SurfelPose, SurfelSettings,
};
use crate::shared::guide::{self, Guides};
use crate::shared::{hash, lengths, mark, mixture, plane, requests, sampling};
use crate::simd;
use gibs_graph::{Workgroup, stage};
use glam::{UVec2, Vec3};
use std::ops::Range;

stage! {
    /// Draws each surfel's rays with density `cos / pi` (GIBS, "Importance Sampling the BRDF") from its own shifted
    /// low-discrepancy sequence, which goes on from frame to frame. In a scene with emissive triangles, a share of them
    /// goes to points on those, drawn by power. A surfel
    /// whose guide has learned enough draws a share of the rest from it (GIBS, "Ray Guiding").
    pub stage GenerateRays {
        wgsl: gibs_shaders::stages::GENERATE_RAYS,
        workgroup: [64, 1, 1],
        ports: {
            uniform frame: Frame,
            uniform settings: SurfelSettings,
            read poses: SurfelPose,
            read births: SurfelBirth,
            read irradiance: SurfelIrradiance,
            read spans: UVec2,
            optional_read emitters: Emitter,
            optional_read guides: u32,
            write rays: Ray,
            write paths: Path,
        },
        cpu: kernel,
        wide: Some(wide_kernel),
    }
}

fn wide_kernel(p: &Views<'_>, group: Workgroup) {
    let range = group.range(p.settings.capacity);
    simd::generate_rays(&surfels(p), range, setter(p));
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    let range = group.range(p.settings.capacity);
    generate_each(&surfels(p), range, setter(p));
}

fn setter(p: &Views<'_>) -> impl FnMut(usize, Ray, Path) {
    move |i, ray, path| {
        p.rays.set(i, ray);
        p.paths.set(i, path);
    }
}

fn surfels<'a>(p: &Views<'a>) -> Surfels<'a> {
    Surfels {
        frame: p.frame,
        poses: p.poses.slice(),
        births: p.births.slice(),
        irradiance: p.irradiance.slice(),
        spans: p.spans.slice(),
        emitters: p.emitters.slice(),
        guides: Guides::new(p.guides.slice(), p.settings.guide_side),
    }
}

/// What rays are drawn from.
#[derive(Clone, Copy)]
pub struct Surfels<'a> {
    /// The frame.
    pub frame: &'a Frame,
    /// Where surfels are.
    pub poses: &'a [SurfelPose],
    /// As they were born.
    pub births: &'a [SurfelBirth],
    /// How many rays each has drawn.
    pub irradiance: &'a [SurfelIrradiance],
    /// First ray of each, and how many.
    pub spans: &'a [UVec2],
    /// Emissive triangles; empty in a frame without.
    pub emitters: &'a [Emitter],
    /// Guides; empty in a frame without.
    pub guides: Guides<'a>,
}

/// A guide in use.
struct Guide<'a> {
    of: guide::Guide<'a>,
    total: f32,
    /// Of the rays that do not go to emitters.
    share: f32,
}

impl<'a> Guide<'a> {
    fn new(of: guide::Guide<'a>, identity: u32) -> Option<Self> {
        let total = of.total();
        let share = of.share(identity, total);
        (share > 0.0).then_some(Self { of, total, share })
    }

    fn density(&self, local: Vec3, cosine: f32, emitters: bool) -> f32 {
        let density = self.of.density(self.total, local);
        mixture::guided_density(cosine, density, self.share, emitters)
    }
}

/// Calls `set` with the rays of a range of surfels, by their index, and the path that each begins.
#[inline(always)]
pub fn generate_each(p: &Surfels<'_>, range: Range<usize>, mut set: impl FnMut(usize, Ray, Path)) {
    let emitters = !p.emitters.is_empty();
    for i in range {
        let (first, last) = requests::range(p.spans[i]);
        let pose = &p.poses[i];
        let surfel = hash::hash2(mark::identity(pose.mark), p.frame.seed);
        let shift = (hash::hash2(surfel, 0), hash::hash2(surfel, 1));
        let guide = match first < last {
            true => p
                .guides
                .get(i)
                .and_then(|of| Guide::new(of, mark::identity(pose.mark))),
            false => None,
        };
        let offset = lengths::up(p.births[i].lengths);
        // What goes below the surface, where the normal leans away from it, would meet that at once from above.
        let across = plane::unpack(pose.mark).normalize();
        for ray in first..last {
            let index = p.irradiance[i].drawn.wrapping_add(ray - first);
            let seed = hash::hash3(surfel, p.frame.number, ray - first);
            let uv = sampling::r2(index, shift);
            let drawn = if emitters && mixture::goes_to_emitter(index, hash::hash2(surfel, 2)) {
                let drawn = mixture::to_emitter(p.emitters, pose.position, pose.normal, uv, seed);
                match &guide {
                    Some(guide) if drawn.cosine > 0.0 => mixture::Drawn {
                        density: -guide.density(
                            sampling::to_local(drawn.direction, pose.normal),
                            drawn.cosine,
                            emitters,
                        ),
                        ..drawn
                    },
                    _ => drawn,
                }
            } else if let Some(guide) = &guide {
                let (follows, u) = mixture::follow_guide(uv.0, guide.share);
                let local = match follows {
                    true => guide.of.draw((u, uv.1)),
                    false => sampling::cosine_hemisphere(u, uv.1),
                };
                mixture::Drawn {
                    direction: sampling::to_world(local, pose.normal),
                    t_max: f32::MAX,
                    cosine: local.z,
                    density: guide.density(local, local.z, emitters),
                }
            } else {
                mixture::over_the_lobe(pose.normal, uv, emitters)
            };
            let direction = drawn.direction;
            let origin = sampling::start(pose.position, across, offset, plane::OFF, direction);
            set(
                ray as usize,
                Ray {
                    origin,
                    t_min: 0.0,
                    direction,
                    t_max: drawn.t_max,
                },
                Path {
                    throughput: Vec3::ONE,
                    root: ray,
                    seed,
                    surfel: i as u32,
                    cosine: drawn.cosine,
                    density: drawn.density,
                },
            );
        }
    }
}

#[cfg(test)]
mod tests;
