//! `*/sample_lights`: lights for each point, and the shadow rays towards them (L1).
use crate::data::{Frame, Light, LightSample, Ray, SurfacePoint};
use crate::shared::{hash, octahedral, sampling, surface};
use crate::simd;
use gibs_graph::{DispatchArgs, Workgroup, stage};
use glam::Vec3;
use std::ops::Range;

stage! {
    /// Chooses `lights_per_point` lights for each point: all of them where that many suffice, else one at random from
    /// each of as many equal strata of the list. One invocation per point and choice.
    pub stage SampleLights {
        wgsl: gibs_shaders::stages::SAMPLE_LIGHTS,
        workgroup: [64, 1, 1],
        ports: {
            uniform batch: DispatchArgs,
            uniform frame: Frame,
            read points: SurfacePoint,
            read lights: Light,
            write rays: Ray,
            write samples: LightSample,
        },
        cpu: kernel,
        wide: Some(wide_kernel),
    }
}

/// Share of the distance to a light that a shadow ray covers; the rest is a margin for rounding.
pub const REACH: f32 = 1.0 - 1.0 / 65_536.0;

/// Irradiance of a light on a surface at `position` with normal `n` that nothing shadows, W/m^2; the unit direction to
/// the light; and its distance.
pub fn unshadowed(light: &Light, position: Vec3, n: Vec3) -> (Vec3, Vec3, f32) {
    if light.kind == 0 {
        let to = -light.direction;
        return (light.intensity * n.dot(to).max(0.0), to, f32::MAX);
    }
    let d = light.position - position;
    let squared = d.dot(d);
    if squared <= 0.0 {
        return (Vec3::ZERO, n, 0.0);
    }
    let distance = squared.sqrt();
    let to = d / distance;
    let mut falloff = n.dot(to).max(0.0) / squared;
    if light.kind == 2 {
        // KHR_lights_punctual: smooth between the cones, squared.
        let width = (light.cos_inner - light.cos_outer).max(1e-7);
        let share = ((-light.direction.dot(to) - light.cos_outer) / width).clamp(0.0, 1.0);
        falloff *= share * share;
    }
    (light.intensity * falloff, to, distance)
}

fn wide_kernel(p: &Views<'_>, group: Workgroup) {
    let (range, set) = (group.range(p.batch.count), setter(p));
    simd::sample_lights(p.frame, &p.points, &p.lights, range, set);
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    let (range, set) = (group.range(p.batch.count), setter(p));
    sample_each(p.frame, &p.points, &p.lights, range, set);
}

fn setter(p: &Views<'_>) -> impl FnMut(usize, Ray, LightSample) {
    move |i, ray, sample| {
        p.rays.set(i, ray);
        p.samples.set(i, sample);
    }
}

/// Calls `set` with each index of a range, the shadow ray of this point and choice, and what it brings unshadowed.
#[inline]
pub fn sample_each(
    frame: &Frame,
    points: &[SurfacePoint],
    lights: &[Light],
    range: Range<usize>,
    mut set: impl FnMut(usize, Ray, LightSample),
) {
    let each = frame.lights_per_point.max(1);
    for i in range {
        let point = &points[i / each as usize];
        let choice = i as u32 % each;
        let mut ray = Ray {
            origin: Vec3::ZERO,
            t_min: 0.0,
            direction: Vec3::Z,
            t_max: 0.0,
        };
        let mut irradiance = Vec3::ZERO;
        if surface::is_surface(point) && choice < frame.lights {
            let (index, weight) = if frame.lights <= each {
                (choice, 1.0)
            } else {
                let x = hash::hash3(
                    point.position.x.to_bits(),
                    point.position.y.to_bits(),
                    point.position.z.to_bits(),
                );
                let u = hash::unit(hash::hash3(
                    x,
                    hash::hash2(frame.number, frame.seed),
                    choice,
                ));
                let stratum = (choice as f32 + u) / each as f32 * frame.lights as f32;
                (
                    (stratum as u32).min(frame.lights - 1),
                    frame.lights as f32 / each as f32,
                )
            };
            let n = octahedral::unpack(point.shading_normal);
            let (unshadowed, to, distance) = unshadowed(&lights[index as usize], point.position, n);
            if unshadowed.max_element() > 0.0 {
                let geometric = octahedral::unpack(point.geometric_normal);
                let origin = sampling::start(point.position, geometric, point.offset, 0.0, to);
                ray = Ray {
                    origin,
                    t_min: 0.0,
                    direction: to,
                    t_max: distance * REACH,
                };
                irradiance = unshadowed * weight;
            }
        }
        set(i, ray, LightSample { irradiance, pad: 0 });
    }
}
