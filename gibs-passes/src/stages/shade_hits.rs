//! `persistent/shade_hits`: radiance that comes back along each ray, and which paths go on (I2).
use super::gather_direct::direct_irradiance;
use crate::data::{Frame, Gathered, Path, Ray, SurfacePoint};
use crate::shared::{environment, hash, surface};
use gibs_graph::{DispatchArgs, Workgroup, stage};
use glam::Vec4;
use std::f32::consts::FRAC_1_PI;

stage! {
    /// Adds to each path's root: the sky for a miss; else emission, and albedo over pi times the direct irradiance and
    /// the surfels' irradiance at the hit (GIBS, "Integrating Irradiance"). Where the surfels' trusted weight is below
    /// one, the path goes on with the probability of what is missing times the albedo's largest part, so that nothing
    /// is lost on average; a path at its last segment takes the cell's average instead. `goes_on` is 1 for those that
    /// go on.
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

fn kernel(p: &Views<'_>, group: Workgroup) {
    for i in group.range(p.batch.count) {
        let path = p.paths.get(i);
        let point = &p.points[i];
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
            if path.remaining != 0 && hash::unit(seed) < (1.0 - trusted) * largest {
                goes_on = 1;
                p.paths.set(
                    i,
                    Path {
                        throughput: path.throughput * albedo / largest,
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
            .set(root, sum + (path.throughput * added).extend(0.0));
        p.goes_on.set(i, goes_on);
    }
}
