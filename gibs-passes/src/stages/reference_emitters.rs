//! `reference/sample_emitters`: a point on an emissive triangle or of the sky, and the shadow ray towards it.
use crate::data::{Emitter, Frame, LightSample, Ray, ReferencePath, SurfacePoint};
use crate::shared::{emitter, environment, hash, octahedral, sampling};
use gibs_graph::{Workgroup, stage};
use glam::{Vec3, Vec4};
use std::f32::consts::FRAC_1_PI;

stage! {
    /// Draws one emitter or sky direction for the vertex of each live path, weighted against the cosine-distributed
    /// ray by the balance heuristic (Veach 1997). The sample is the irradiance it adds if nothing stands between, W/m^2.
    pub stage ReferenceEmitters {
        wgsl: gibs_shaders::stages::REFERENCE_EMITTERS,
        workgroup: [64, 1, 1],
        ports: {
            uniform frame: Frame,
            read vertices: SurfacePoint,
            read paths: ReferencePath,
            read emitters: Emitter,
            read environment: Vec4,
            read sky_cumulative: f32,
            write rays: Ray,
            write samples: LightSample,
        },
        cpu: kernel,
        wide: None,
    }
}

/// Index of the first element of an increasing table that is above `x`; the last one at most.
#[inline]
pub fn find(len: u32, x: f32, at: impl Fn(u32) -> f32) -> u32 {
    let (mut low, mut high) = (0, len - 1);
    while low < high {
        let middle = (low + high) / 2;
        if at(middle) > x {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    low
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    for i in group.range(p.paths.len() as u32) {
        let path = &p.paths[i];
        let mut ray = Ray {
            origin: Vec3::ZERO,
            t_min: 0.0,
            direction: Vec3::Z,
            t_max: 0.0,
        };
        let mut irradiance = Vec3::ZERO;
        let share = emitter::sky_share(p.frame);
        if path.segment != 0 && share >= 0.0 {
            let vertex = &p.vertices[i];
            let normal = octahedral::unpack(vertex.shading_normal);
            let mut seed = hash::hash2(path.seed, 0x656d_6974);
            let mut random = || {
                seed = hash::pcg(seed);
                hash::unit(seed)
            };
            let (which, a, b, c) = (random(), random(), random(), random());
            let (direction, distance, radiance, density) = if which < share {
                let texel = find(p.sky_cumulative.len() as u32, a, |k| {
                    p.sky_cumulative[k as usize]
                });
                let side = p.frame.environment_side;
                let direction = environment::direction(side, texel % side, texel / side, b, c);
                let map = p.environment[texel as usize];
                let density = share * map.w / environment::solid_angle_per_area(direction);
                (direction, f32::MAX, map.truncate(), density)
            } else {
                let index = find(p.emitters.len() as u32, a, |k| {
                    p.emitters[k as usize].cumulative
                });
                let chosen = &p.emitters[index as usize];
                let (u, v) = emitter::triangle_point(b, c);
                let d = chosen.v0 + chosen.e1 * u + chosen.e2 * v - vertex.position;
                let distance = d.dot(d).sqrt();
                let direction = d / distance.max(1e-30);
                let density = (1.0 - share)
                    * emitter::density(
                        p.frame,
                        chosen.radiance,
                        emitter::facing(chosen, direction),
                        distance,
                    );
                (
                    direction,
                    distance * emitter::REACH,
                    emitter::radiance(chosen, direction),
                    density,
                )
            };
            let cosine = normal.dot(direction);
            if cosine > 0.0 && density > 0.0 {
                irradiance = radiance * (cosine / (density + cosine * FRAC_1_PI));
                let geometric = octahedral::unpack(vertex.geometric_normal);
                let origin =
                    sampling::start(vertex.position, geometric, vertex.offset, 0.0, direction);
                ray = Ray {
                    origin,
                    t_min: 0.0,
                    direction,
                    t_max: distance,
                };
            }
        }
        p.rays.set(i, ray);
        p.samples.set(i, LightSample { irradiance, pad: 0 });
    }
}
