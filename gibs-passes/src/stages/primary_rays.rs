//! `gbuffer/primary_rays`: a ray through the centre of every pixel.
use crate::data::{Camera, Ray};
use gibs_graph::{Workgroup, stage};

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
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    let camera = p.camera;
    for i in group.range(camera.width * camera.height) {
        let x = (i as u32 % camera.width) as f32 + 0.5;
        let y = (i as u32 / camera.width) as f32 + 0.5;
        let across = x / camera.width as f32 * 2.0 - 1.0;
        let upwards = 1.0 - y / camera.height as f32 * 2.0;
        let direction = (camera.forward + camera.right * across + camera.up * upwards).normalize();
        p.rays.set(
            i,
            Ray {
                origin: camera.eye,
                t_min: -0.0,
                direction,
                t_max: f32::MAX,
            },
        );
    }
}
