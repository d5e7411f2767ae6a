//! `filtering/temporal`: rays into irradiance (I1, I3).
use crate::data::{
    Frame, Neighbours, SurfelBirth, SurfelIrradiance, SurfelLight, SurfelPose, SurfelSettings,
};
use crate::shared::{estimator, sharing};
use crate::simd;
use gibs_graph::{Workgroup, stage};
use glam::{Vec3, Vec4};
use std::f32::consts::PI;

stage! {
    /// Feeds each surfel's mean of `pi * radiance` (the estimator of irradiance under `cos / pi`) to its multiscale
    /// mean, and finds what the surfel says: that mean, and what its neighbours know better. Without rays, the mean is
    /// left as it is.
    pub stage Integrate {
        wgsl: gibs_shaders::stages::INTEGRATE,
        workgroup: [64, 1, 1],
        ports: {
            uniform frame: Frame,
            uniform settings: SurfelSettings,
            read poses: SurfelPose,
            read births: SurfelBirth,
            read offsets: u32,
            read radiance: Vec4,
            optional_read neighbours: Neighbours,
            read_write irradiance: SurfelIrradiance,
            write light: SurfelLight,
        },
        cpu: kernel,
        wide: Some(wide_kernel),
    }
}

fn wide_kernel(p: &Views<'_>, group: Workgroup) {
    simd::run(
        #[inline(always)]
        || kernel(p, group),
    );
}

#[inline(always)]
fn kernel(p: &Views<'_>, group: Workgroup) {
    for i in group.range(p.poses.len() as u32) {
        if p.poses[i].radius <= 0.0 {
            continue;
        }
        let (first, last) = (p.offsets[i] as usize, p.offsets[i + 1] as usize);
        let mut state = p.irradiance.get(i);
        if first < last {
            let sum = (first..last).fold(Vec3::ZERO, |sum, ray| sum + p.radiance[ray].truncate());
            let rays = (last - first) as u32;
            let sample = sum * (PI / rays as f32);
            state = estimator::update(&state, sample, rays, p.settings.clamp != 0);
            p.irradiance.set(i, state);
        }
        let age = p.frame.number.wrapping_sub(p.births[i].frame);
        let neighbours = p.neighbours.get(i).copied().unwrap_or_default();
        p.light.set(i, sharing::light(&state, age, &neighbours));
    }
}
