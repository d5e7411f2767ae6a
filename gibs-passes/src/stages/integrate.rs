//! `filtering/temporal`: rays into irradiance (I1, I3).
use crate::data::{
    ClampedLight, Frame, GridShape, Neighbours, SurfelIrradiance, SurfelLight, SurfelPose,
    SurfelSettings,
};
use crate::shared::{estimator, grid, requests, sharing};
use crate::simd;
use gibs_graph::{Workgroup, stage};
use glam::{UVec2, Vec2, Vec4};
use std::f32::consts::PI;
use std::ops::Range;

stage! {
    /// Feeds each surfel's mean of `pi * radiance` (the estimator of irradiance under `cos / pi`) to its multiscale
    /// mean, after a share of what it knew is forgotten where the cell's light has changed. Without rays, the mean is left as
    /// it is. What is fainter than the setting `faintest` counts as nothing. That mean is what the surfel says, drawn towards
    /// what its `neighbours` have told it; where it is to ask them anew, they are [`ASKS`](sharing::ASKS). Where `clamped` is
    /// bound, it tells what the firefly clamp took.
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
            optional_read_write neighbours: Neighbours,
            optional_write clamped: ClampedLight,
        },
        cpu: kernel,
        wide: Some(wide_kernel),
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    let range = group.range(p.poses.len() as u32);
    say_of_free_slots(p, range.clone());
    integrate_each(&rays(p), range, |i| known(p, i), |i, new| set(p, i, new));
}

fn wide_kernel(p: &Views<'_>, group: Workgroup) {
    let range = group.range(p.poses.len() as u32);
    say_of_free_slots(p, range.clone());
    simd::integrate(&rays(p), range, |i| known(p, i), |i, new| set(p, i, new));
}

#[inline(always)]
fn known(p: &Views<'_>, i: usize) -> (SurfelIrradiance, Neighbours) {
    let told = match p.neighbours.is_empty() {
        true => Neighbours::default(),
        false => p.neighbours.get(i),
    };
    (p.irradiance.get(i), told)
}

fn rays<'a>(p: &Views<'a>) -> Rays<'a> {
    Rays {
        frame: p.frame,
        grid: p.grid,
        settings: p.settings,
        poses: p.poses.slice(),
        spans: p.spans.slice(),
        radiance: p.radiance.slice(),
        forget: p.forget.slice(),
    }
}

/// The clamp takes nothing from surfels that do not exist.
fn say_of_free_slots(p: &Views<'_>, range: Range<usize>) {
    if !p.clamped.is_empty() {
        for i in range.filter(|&i| p.poses[i].radius <= 0.0) {
            p.clamped.set(i, ClampedLight::default());
        }
    }
}

#[inline(always)]
fn set(p: &Views<'_>, i: usize, new: Integrated) {
    if let Some(state) = new.irradiance {
        p.irradiance.set(i, state);
    }
    p.light.set(i, new.light);
    if new.asks && !p.neighbours.is_empty() {
        p.neighbours.set(i, sharing::ASKS);
    }
    if !p.clamped.is_empty() {
        p.clamped.set(i, new.clamped);
    }
}

/// What the rays of surfels brought.
#[derive(Clone, Copy)]
pub struct Rays<'a> {
    /// The frame.
    pub frame: &'a Frame,
    /// The grid of the cells.
    pub grid: &'a GridShape,
    /// Settings.
    pub settings: &'a SurfelSettings,
    /// Where surfels are.
    pub poses: &'a [SurfelPose],
    /// The first ray of each, and how many it has.
    pub spans: &'a [UVec2],
    /// Radiance along each ray, W/(m^2 sr).
    pub radiance: &'a [Vec4],
    /// Share of what they know that the surfels of each cell are to forget, and by how much their light has changed.
    pub forget: &'a [Vec2],
}

/// What becomes of a surfel.
#[derive(Clone, Copy, Debug)]
pub struct Integrated {
    /// Its irradiance, where it had rays.
    pub irradiance: Option<SurfelIrradiance>,
    /// What it says.
    pub light: SurfelLight,
    /// Whether it is to ask its neighbours anew.
    pub asks: bool,
    /// What the clamp took.
    pub clamped: ClampedLight,
}

/// Calls `set` with each live surfel of a range and what becomes of it; `known` is what it knew and was told.
#[inline]
pub fn integrate_each(
    rays: &Rays<'_>,
    range: Range<usize>,
    known: impl Fn(usize) -> (SurfelIrradiance, Neighbours),
    mut set: impl FnMut(usize, Integrated),
) {
    let number = rays.frame.number;
    let clamp = rays.settings.clamp != 0;
    for i in range {
        let pose = &rays.poses[i];
        if pose.radius <= 0.0 {
            continue;
        }
        let (first, last) = requests::range(rays.spans[i]);
        let (mut state, told) = known(i);
        let mut clamped = ClampedLight::default();
        let change = rays.forget[grid::cell(pose.position, rays.grid) as usize];
        if first < last {
            let radiance = &rays.radiance[first as usize..last as usize];
            let sum = radiance.iter().fold(Vec4::ZERO, |sum, &ray| sum + ray);
            let mean = sum.truncate() * (PI / radiance.len() as f32);
            let sample = estimator::unless_faint(mean, rays.settings.faintest);
            state = estimator::forget(&state, change.x, change.y, number);
            if clamp {
                clamped = estimator::taken(&state, sample, last - first);
            }
            state = estimator::update(&state, sample, last - first, number, clamp);
        }
        let age = number.wrapping_sub(state.since);
        let new = Integrated {
            irradiance: (first < last).then_some(state),
            light: sharing::light(&state, age, &sharing::Said::unpack(&told)),
            asks: sharing::is_due(i as u32, &state, change.x, number),
            clamped,
        };
        set(i, new);
    }
}
