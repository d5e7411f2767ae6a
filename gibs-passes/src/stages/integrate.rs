//! `filtering/temporal`: rays into irradiance (I1, I3).
use crate::data::{
    ClampedLight, Frame, GridShape, SurfelIrradiance, SurfelLight, SurfelPose, SurfelSettings,
};
use crate::shared::{estimator, grid, requests, sharing};
use crate::simd;
use gibs_graph::{Workgroup, stage};
use glam::{UVec2, Vec2, Vec3, Vec4};
use std::f32::consts::PI;

stage! {
    /// Feeds each surfel's mean of `pi * radiance` (the estimator of irradiance under `cos / pi`) to its multiscale
    /// mean, after a share of what it knew is forgotten where the cell's light has changed. Without rays, the mean is left as
    /// it is. What is fainter than the setting `faintest` counts as nothing. That mean is what the surfel says, while no neighbours know better. Where `clamped` is bound, it tells what the
    /// firefly clamp took.
    pub stage Integrate {
        wgsl: gibs_shaders::stages::INTEGRATE,
        workgroup: [64, 1, 1],
        ports: {
            uniform frame: Frame,
            uniform grid: GridShape,
            uniform settings: SurfelSettings,
            read poses: SurfelPose,
            read spans: UVec2,
            read radiance: Vec4,
            read forget: Vec2,
            read_write irradiance: SurfelIrradiance,
            write light: SurfelLight,
            optional_write clamped: ClampedLight,
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
        let pose = &p.poses[i];
        let mut clamped = ClampedLight::default();
        if pose.radius <= 0.0 {
            if !p.clamped.is_empty() {
                p.clamped.set(i, clamped);
            }
            continue;
        }
        let (first, last) = requests::range(p.spans[i]);
        let mut state = p.irradiance.get(i);
        if first < last {
            let sum = (first..last).fold(Vec3::ZERO, |sum, ray| {
                sum + p.radiance[ray as usize].truncate()
            });
            let rays = last - first;
            let sample = estimator::unless_faint(sum * (PI / rays as f32), p.settings.faintest);
            let change = p.forget[grid::cell(pose.position, p.grid) as usize];
            state = estimator::forget(&state, change.x, change.y, p.frame.number);
            clamped = estimator::taken(&state, sample, rays);
            let clamp = p.settings.clamp != 0;
            state = estimator::update(&state, sample, rays, p.frame.number, clamp);
            p.irradiance.set(i, state);
        }
        if !p.clamped.is_empty() {
            p.clamped.set(i, clamped);
        }
        let age = p.frame.number.wrapping_sub(state.since);
        p.light
            .set(i, sharing::light(&state, age, &sharing::Said::default()));
    }
}
