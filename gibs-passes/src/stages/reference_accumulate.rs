//! `reference/accumulate`: what a segment found, and whether its path goes on.
use super::gather_direct::direct_irradiance;
use crate::data::{Frame, LightSample, NONE, Ray, ReferencePath, SurfacePoint};
use crate::shared::{emitter, environment, estimator, hash, octahedral, surface};
use gibs_graph::{Workgroup, stage};
use glam::{Vec3, Vec4};
use std::f32::consts::{FRAC_1_PI, PI};

stage! {
    /// Adds the irradiance of lights (not at the first vertex: that is direct light) and of the emitter sample at the
    /// path's vertex, and the emission or sky that the segment met, each weighted by the balance heuristic. Russian
    /// roulette by the largest albedo decides whether the path goes on at the surface it met; a finished path is one
    /// sample of its pixel.
    pub stage ReferenceAccumulate {
        wgsl: gibs_shaders::stages::REFERENCE_ACCUMULATE,
        workgroup: [64, 1, 1],
        ports: {
            uniform frame: Frame,
            read rays: Ray,
            read points: SurfacePoint,
            optional_read direct: Vec4,
            read emitter_samples: LightSample,
            read emitter_visible: u32,
            read environment: Vec4,
            read_write vertices: SurfacePoint,
            read_write paths: ReferencePath,
        },
        cpu: kernel,
        wide: None,
    }
}

/// Largest probability of going on: bounds the length of paths between white walls. In a closed room, a path that goes on less
/// often than light does counts more with each segment, and beyond an albedo of the root of this its variance has no bound.
pub const MOST_SURVIVAL: f32 = 0.99;

fn kernel(p: &Views<'_>, group: Workgroup) {
    for i in group.range(p.paths.len() as u32) {
        let mut path = p.paths.get(i);
        if path.segment == 0 {
            continue;
        }
        let frame = p.frame;
        let vertex = p.vertices.get(i);
        // `scale` turns irradiance at this vertex into irradiance at the pixel.
        let mut arriving = Vec3::ZERO;
        if p.emitter_visible[i] != 0 {
            arriving += p.emitter_samples[i].irradiance;
        }
        if path.segment > 1 {
            arriving += direct_irradiance(&p.direct, i);
        }
        let direction = p.rays[i].direction;
        let point = &p.points[i];
        let cosine = octahedral::unpack(vertex.shading_normal)
            .dot(direction)
            .max(0.0);
        let own = cosine * FRAC_1_PI;
        let share = emitter::sky_share(frame);
        let met;
        let density;
        if surface::is_surface(point) {
            met = point.emission;
            density = if point.albedo_b_flags & surface::EMITTER != 0 && share >= 0.0 {
                let d = point.position - vertex.position;
                let facing = -octahedral::unpack(point.geometric_normal).dot(direction);
                (1.0 - share) * emitter::density(frame, point.emission, facing, d.dot(d).sqrt())
            } else {
                0.0
            };
        } else {
            let texel = environment::texel(&p.environment, frame.environment_side, direction);
            met = texel.truncate();
            density = share.max(0.0) * texel.w / environment::solid_angle_per_area(direction);
        }
        let weight = if own > 0.0 {
            own / (own + density)
        } else {
            1.0
        };
        path.sample += path.scale * (arriving + met * (PI * weight));
        path.segment += 1;
        path.segments += 1;
        let mut ends = true;
        if surface::is_surface(point) {
            let albedo = surface::albedo(point);
            let survival = albedo.max_element().min(MOST_SURVIVAL);
            path.seed = hash::pcg(path.seed);
            if hash::unit(path.seed) < survival {
                // The ray's own factor is pi (irradiance over radiance); the surface's is albedo over pi.
                path.scale = path.scale * albedo / survival;
                p.vertices.set(i, *point);
                ends = false;
            }
        }
        if ends {
            let luminance = estimator::luminance(path.sample);
            path.sum += path.sample;
            path.sum_squared += luminance * luminance;
            path.largest = path.largest.max(luminance);
            path.segment = 0;
            path.done += 1;
        }
        p.paths.set(i, path);
    }
}

/// A pixel whose path has nothing left to do.
pub fn finished(path: &ReferencePath, primary: &SurfacePoint, samples: u32) -> bool {
    primary.transform_id == NONE || (path.segment == 0 && path.done >= samples)
}
