//! `persistent/shade_hits`: radiance that comes back along each ray, and which paths go on (I2).
use super::gather_direct::direct_irradiance;
use crate::data::{Frame, Gathered, Path, Ray, SurfacePoint};
use crate::shared::{emitter, environment, hash, mixture, octahedral, surface};
use gibs_graph::{DispatchArgs, Workgroup, stage};
use glam::Vec4;
use std::f32::consts::FRAC_1_PI;

stage! {
    /// Adds to each path's root: the sky for a miss; else emission, and albedo over pi times the direct irradiance and
    /// the surfels' irradiance at the hit (GIBS, "Integrating Irradiance"). Where the surfels' trusted weight is below
    /// one, the path goes on with the probability of what is missing times the albedo's largest part, so that nothing
    /// is lost on average; a path at its last segment takes the cell's average instead. `goes_on` is 1 for those that
    /// go on. Each segment counts by the mixture that its ray was drawn from.
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
            write goes_on: u32,
        },
        cpu: kernel,
        wide: None,
    }
}

/// What the segment counts, by how its ray was drawn.
#[inline]
fn factor(frame: &Frame, path: &Path, ray: &Ray, point: &SurfacePoint) -> f32 {
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

fn kernel(p: &Views<'_>, group: Workgroup) {
    for i in group.range(p.batch.count) {
        let path = p.paths.get(i);
        let point = &p.points[i];
        let factor = factor(p.frame, &path, &p.rays[i], point);
        let mut goes_on = 0;
        let added = if surface::is_surface(point) {
            let albedo = surface::albedo(point);
            let gathered = &p.gathered[i];
            let largest = albedo.max_element();
            let seed = hash::pcg(path.seed);
            let trusted = gathered.weight * gathered.confidence;
            let mut arriving = direct_irradiance(&p.direct, i);
            if path.remaining == 0 {
                // The path ends here: all that the surfels know, and the cell's average for what they leave.
                arriving += gathered.irradiance + gathered.average * (1.0 - gathered.weight);
            } else {
                arriving += gathered.irradiance * gathered.confidence;
            }
            if path.remaining != 0 && factor > 0.0 && hash::unit(seed) < (1.0 - trusted) * largest {
                goes_on = 1;
                p.paths.set(
                    i,
                    Path {
                        throughput: path.throughput * factor * albedo / largest,
                        seed,
                        ..path
                    },
                );
            }
            point.emission + albedo * FRAC_1_PI * arriving
        } else {
            environment::radiance(
                &p.environment,
                p.frame.environment_side,
                p.rays[i].direction,
            )
        };
        let root = path.root as usize;
        let sum = p.radiance.get(root);
        p.radiance
            .set(root, sum + (path.throughput * factor * added).extend(0.0));
        p.goes_on.set(i, goes_on);
    }
}
