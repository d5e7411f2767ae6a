//! `reference/scatter`: the next segment of each pixel's path.
use crate::data::{Frame, Ray, ReferencePath, SurfacePoint};
use crate::shared::{hash, octahedral, sampling, surface};
use gibs_graph::{Workgroup, stage};
use glam::Vec3;

stage! {
    /// Starts a new path at the primary surface where the last one has ended and samples are left; then draws a ray
    /// with density `cos / pi` about the interpolated normal of the surface where the path is. A pixel without work
    /// gets a ray of no length.
    pub stage ReferenceScatter {
        wgsl: gibs_shaders::stages::REFERENCE_SCATTER,
        workgroup: [64, 1, 1],
        ports: {
            uniform frame: Frame,
            read primary: SurfacePoint,
            read_write vertices: SurfacePoint,
            read_write paths: ReferencePath,
            write rays: Ray,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    for i in group.range(p.primary.len() as u32) {
        let mut path = p.paths.get(i);
        let mut ray = Ray {
            origin: Vec3::ZERO,
            t_min: 0.0,
            direction: Vec3::Z,
            t_max: 0.0,
        };
        if path.segment == 0 && path.done < p.frame.samples && surface::is_surface(&p.primary[i]) {
            p.vertices.set(i, p.primary[i]);
            path.scale = Vec3::ONE;
            path.sample = Vec3::ZERO;
            path.segment = 1;
            path.seed = hash::hash3(i as u32, path.done, p.frame.seed);
        }
        if path.segment != 0 {
            let vertex = p.vertices.get(i);
            let first = hash::pcg(path.seed);
            let second = hash::pcg(first);
            path.seed = second;
            let normal = octahedral::unpack(vertex.shading_normal);
            let local = sampling::cosine_hemisphere(hash::unit(first), hash::unit(second));
            let direction = sampling::to_world(local, normal);
            let geometric = octahedral::unpack(vertex.geometric_normal);
            let origin = sampling::start(vertex.position, geometric, vertex.offset, 0.0, direction);
            ray = Ray {
                origin,
                t_min: 0.0,
                direction,
                t_max: f32::MAX,
            };
        }
        p.paths.set(i, path);
        p.rays.set(i, ray);
    }
}
