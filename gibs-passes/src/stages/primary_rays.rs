//! `gbuffer/primary_rays`: a ray through the centre of every pixel.
use crate::data::{Camera, Ray};
use crate::simd;
use gibs_graph::{Workgroup, stage};
use std::ops::Range;

stage! {
    /// Starts a ray at the eye through each pixel's centre. Blended surfaces are invisible to it.
    pub stage PrimaryRays {
        wgsl: gibs_shaders::stages::PRIMARY_RAYS,
        workgroup: [64, 1, 1],
        ports: {
            uniform camera: Camera,
            write rays: Ray,
        },
        cpu: kernel,
        wide: Some(wide_kernel),
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    let range = group.range(p.camera.width * p.camera.height);
    primary_each(p.camera, range, |i, ray| p.rays.set(i, ray));
}

fn wide_kernel(p: &Views<'_>, group: Workgroup) {
    let range = group.range(p.camera.width * p.camera.height);
    simd::primary_rays(p.camera, range, |i, ray| p.rays.set(i, ray));
}

/// Calls `set` with each pixel of a range, row by row from the top left, and the ray through its centre.
#[inline]
pub fn primary_each(camera: &Camera, range: Range<usize>, mut set: impl FnMut(usize, Ray)) {
    for i in range {
        let x = (i as u32 % camera.width) as f32 + 0.5;
        let y = (i as u32 / camera.width) as f32 + 0.5;
        let across = x / camera.width as f32 * 2.0 - 1.0;
        let upwards = 1.0 - y / camera.height as f32 * 2.0;
        let direction = (camera.forward + camera.right * across + camera.up * upwards).normalize();
        let ray = Ray {
            origin: camera.eye,
            t_min: -0.0,
            direction,
            t_max: f32::MAX,
        };
        set(i, ray);
    }
}
