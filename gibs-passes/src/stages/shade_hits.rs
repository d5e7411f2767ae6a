//! `persistent/shade_hits`: radiance that comes back along each ray, and which paths go on (I2).
use super::count_paths::PATHS_PER_WORD;
use super::gather_direct::direct_irradiance;
use crate::data::{Frame, Gathered, Path, Ray, SurfacePoint};
use crate::shared::batch::LANES;
use crate::shared::{emitter, environment, hash, mixture, octahedral, surface};
use crate::simd;
use gibs_graph::{DispatchArgs, Workgroup, stage};
use glam::Vec4;
use std::f32::consts::FRAC_1_PI;
use std::ops::Range;

stage! {
    /// Adds to each path's root: the sky for a miss; else emission, and albedo over pi times the direct irradiance and
    /// the surfels' irradiance at the hit (GIBS, "Integrating Irradiance"). Where the surfels' trusted weight is below
    /// one, the path goes on with the probability of what is missing times the albedo's largest part, so that nothing
    /// is lost on average. `goes_on` has a bit for each path, the lowest first, which is set for those that go on; where it
    /// is not bound, paths end, and take the cell's average instead. Each segment counts by the mixture that its ray was
    /// drawn from.
    pub stage ShadeHits {
        wgsl: gibs_shaders::stages::SHADE_HITS,
        workgroup: [64, 1, 1],
        ports: {
            uniform batch: DispatchArgs,
            uniform frame: Frame,
            read rays: Ray,
            read points: SurfacePoint,
            optional_read direct: Vec4,
            read gathered: Gathered,
            optional_read environment: Vec4,
            read_write paths: Path,
            read_write radiance: Vec4,
            optional_write goes_on: u32,
        },
        cpu: kernel,
        wide: Some(wide_kernel),
    }
}

fn wide_kernel(p: &Views<'_>, group: Workgroup) {
    let range = group.range(p.batch.count);
    let mut goes_on = 0;
    let set = |i, shaded| set_one(p, &mut goes_on, i, shaded);
    simd::shade_hits(&hits(p), range, |i| p.paths.get(i), set);
    set_goes_on(p, group, goes_on);
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    let range = group.range(p.batch.count);
    let mut goes_on = 0;
    let set = |i, shaded| set_one(p, &mut goes_on, i, shaded);
    shade_each(&hits(p), range, |i| p.paths.get(i), set);
    set_goes_on(p, group, goes_on);
}

#[inline]
fn set_one(p: &Views<'_>, goes_on: &mut u64, i: usize, shaded: Shaded) {
    if let Some(path) = shaded.goes_on {
        p.paths.set(i, path);
        *goes_on |= 1 << (i % LANES as usize);
    }
    let root = shaded.root as usize;
    let sum = p.radiance.get(root);
    p.radiance.set(root, sum + shaded.added);
}

/// Writes which of a workgroup's paths go on, in as many words as there are paths for.
fn set_goes_on(p: &Views<'_>, group: Workgroup, goes_on: u64) {
    if p.goes_on.is_empty() {
        return;
    }
    let range = group.range(p.batch.count);
    for (word, first) in range.step_by(PATHS_PER_WORD as usize).enumerate() {
        let bits = goes_on >> (word as u32 * PATHS_PER_WORD);
        p.goes_on.set(first / PATHS_PER_WORD as usize, bits as u32);
    }
}

fn hits<'a>(p: &Views<'a>) -> Hits<'a> {
    Hits {
        frame: p.frame,
        rays: p.rays.slice(),
        points: p.points.slice(),
        direct: p.direct.slice(),
        gathered: p.gathered.slice(),
        environment: p.environment.slice(),
        ends: p.goes_on.is_empty(),
    }
}

/// What is known where rays hit.
#[derive(Clone, Copy)]
pub struct Hits<'a> {
    /// The frame.
    pub frame: &'a Frame,
    /// The rays.
    pub rays: &'a [Ray],
    /// Where they hit.
    pub points: &'a [SurfacePoint],
    /// Direct irradiance there; empty in a frame without.
    pub direct: &'a [Vec4],
    /// Irradiance of the surfels there.
    pub gathered: &'a [Gathered],
    /// The sky; empty in a frame without.
    pub environment: &'a [Vec4],
    /// No path goes on.
    pub ends: bool,
}

/// What comes of a segment.
#[derive(Clone, Copy, Debug)]
pub struct Shaded {
    /// Ray of the surfel that the path began with.
    pub root: u32,
    /// What that one brings more; the last number is zero.
    pub added: Vec4,
    /// The path, where it goes on.
    pub goes_on: Option<Path>,
}

/// What the segment counts, by how its ray was drawn.
#[inline]
pub fn factor(frame: &Frame, path: &Path, ray: &Ray, point: &SurfacePoint) -> f32 {
    let is_emitter = surface::is_surface(point) && point.albedo_b_flags & surface::EMITTER != 0;
    let d = point.position - ray.origin;
    let distance = d.dot(d).sqrt();
    let arrives = is_emitter && distance >= ray.t_max * (1.0 - 2.0 * mixture::SLACK);
    if path.density < 0.0 && !arrives {
        return 0.0;
    }
    let mut drawn_there = 0.0;
    if is_emitter {
        let facing = -octahedral::unpack(point.geometric_normal).dot(ray.direction);
        drawn_there = emitter::density(frame, point.emission, facing, distance);
    }
    mixture::weight(path.cosine, path.density.abs(), drawn_there)
}

/// Calls `set` with each index of a range and what comes of this segment.
#[inline]
pub fn shade_each(
    hits: &Hits<'_>,
    range: Range<usize>,
    path: impl Fn(usize) -> Path,
    mut set: impl FnMut(usize, Shaded),
) {
    for i in range {
        let path = path(i);
        let (ray, point) = (&hits.rays[i], &hits.points[i]);
        let factor = factor(hits.frame, &path, ray, point);
        let mut goes_on = None;
        let added = if surface::is_surface(point) {
            let albedo = surface::albedo(point);
            let gathered = &hits.gathered[i];
            let largest = albedo.max_element();
            let seed = hash::pcg(path.seed);
            let trusted = gathered.weight * gathered.confidence;
            let mut arriving = direct_irradiance(hits.direct, i);
            if hits.ends {
                // The path ends here: all that the surfels know, and the cell's average for what they leave.
                arriving += gathered.irradiance + gathered.average * (1.0 - gathered.weight);
            } else {
                arriving += gathered.irradiance * gathered.confidence;
            }
            if !hits.ends && factor > 0.0 && hash::unit(seed) < (1.0 - trusted) * largest {
                goes_on = Some(Path {
                    throughput: path.throughput * factor * albedo / largest,
                    seed,
                    ..path
                });
            }
            point.emission + albedo * FRAC_1_PI * arriving
        } else {
            environment::radiance(hits.environment, hits.frame.environment_side, ray.direction)
        };
        set(
            i,
            Shaded {
                root: path.root,
                added: (path.throughput * factor * added).extend(0.0),
                goes_on,
            },
        );
    }
}
