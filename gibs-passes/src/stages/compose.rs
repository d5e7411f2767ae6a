//! `apply/compose`: the picture.
use super::gather_direct::direct_irradiance;
use crate::data::{Frame, Gathered, Ray, SurfacePoint};
use crate::shared::{environment, lookup, surface};
use gibs_graph::{DispatchArgs, Workgroup, stage};
use glam::Vec4;
use std::f32::consts::FRAC_1_PI;

stage! {
    /// Indirect irradiance of each pixel, the cell's average filling in what the surfels' weight leaves (GIBS, "Light
    /// Apply"), W/m^2; and its radiance: emission plus albedo over pi times all irradiance, or the sky, W/(m^2 sr).
    pub stage Compose {
        wgsl: gibs_shaders::stages::COMPOSE,
        workgroup: [64, 1, 1],
        ports: {
            uniform batch: DispatchArgs,
            uniform frame: Frame,
            read rays: Ray,
            read points: SurfacePoint,
            optional_read direct: Vec4,
            read gathered: Gathered,
            optional_read environment: Vec4,
            write irradiance: Vec4,
            write color: Vec4,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    for i in group.range(p.batch.count) {
        let point = &p.points[i];
        if !surface::is_surface(point) {
            let sky = environment::radiance(
                &p.environment,
                p.frame.environment_side,
                p.rays[i].direction,
            );
            p.irradiance.set(i, Vec4::ZERO);
            p.color.set(i, sky.extend(0.0));
            continue;
        }
        let indirect = lookup::complete(&p.gathered[i]);
        let all = indirect + direct_irradiance(&p.direct, i);
        let color = point.emission + surface::albedo(point) * FRAC_1_PI * all;
        p.irradiance.set(i, indirect.extend(p.gathered[i].weight));
        p.color.set(i, color.extend(1.0));
    }
}
