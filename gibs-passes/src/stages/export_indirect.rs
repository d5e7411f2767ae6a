//! `apply/export`: indirect light as an image of the engine's.
use crate::data::{Camera, Gathered, HostGbuffer, SurfacePoint};
use crate::shared::{lookup, surface};
use gibs_graph::{Rgba16Float, Workgroup, stage};
use glam::{Vec3, Vec4};
use std::f32::consts::FRAC_1_PI;

stage! {
    /// Indirect irradiance of each pixel, W/m^2, or, where the engine asks for it, the radiance that the surface makes
    /// of it, W/(m^2 sr); times the engine's exposure. The last component is the summed weight of the surfels, 0 where
    /// there is no surface.
    pub stage ExportIndirect {
        wgsl: gibs_shaders::stages::EXPORT_INDIRECT,
        workgroup: [8, 8, 1],
        ports: {
            uniform camera: Camera,
            uniform host: HostGbuffer,
            read points: SurfacePoint,
            read gathered: Gathered,
            stored indirect: Rgba16Float,
        },
        cpu: kernel,
        wide: None,
    }
}

/// The largest finite 16-bit float.
const MOST: f32 = 65_504.0;

/// Side of a workgroup, texels.
pub const TILE: u32 = 8;

fn kernel(p: &Views<'_>, group: Workgroup) {
    for lane in 0..TILE * TILE {
        let x = group.id[0] * TILE + lane % TILE;
        let y = group.id[1] * TILE + lane / TILE;
        if x >= p.camera.width || y >= p.camera.height {
            continue;
        }
        let i = (y * p.camera.width + x) as usize;
        let point = &p.points[i];
        let value = if surface::is_surface(point) {
            let factor = if p.host.radiance != 0 {
                surface::albedo(point) * FRAC_1_PI
            } else {
                Vec3::ONE
            };
            let light = lookup::complete(&p.gathered[i]) * factor;
            // Light beyond the largest 16-bit float stays that; infinity would spread through the engine's filters.
            (light * p.host.exposure)
                .min(Vec3::splat(MOST))
                .extend(p.gathered[i].weight)
        } else {
            Vec4::ZERO
        };
        p.indirect.store(x, y, value);
    }
}
