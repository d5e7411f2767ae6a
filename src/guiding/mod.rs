//! The test bed for where rays go (GIBS, "Ray Guiding"): irradiance probes under an environment map, and how far they are
//! off after so many rays, over the cosine lobe and guided.
mod environments;
mod plot;
#[cfg(test)]
mod tests;
mod truth;

pub use environments::{built_in, names};
pub use plot::plot;
pub use truth::irradiance;

use crate::channels::read_output;
use crate::renderer::{RenderError, compile};
use gibs_graph::{Backend, Graph};
use gibs_passes::data::SurfelIrradiance;
use gibs_passes::device::EnvironmentTable;
use gibs_passes::frame::{ProbeFrame, Settings, probe_frame, upload_probe_frame, upload_probes};
use gibs_passes::scene::{Environment, EnvironmentMap};
use gibs_passes::shared::estimator::luminance;
use glam::Vec3;
use serde::Serialize;
use std::sync::Arc;

/// What to measure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Probes, whose normals are spread over the sphere; at least 1.
    pub probes: u32,
    /// Independent repetitions, for the intervals; at least 2. `seeds * probes` is at most [`gibs_passes::frame::MOST_PLACES`].
    pub seeds: u32,
    /// Probes at one place, which learn from each other; guides need at least 2.
    pub per_place: u32,
    /// Rays of a probe in a frame; at least 1.
    pub rays_per_frame: u32,
    /// Rays of a probe in all.
    pub rays: u32,
    /// Texels along each side of a guide: 2, 4, 6 or 8.
    pub guide_side: u32,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            probes: 32,
            seeds: 16,
            per_place: 9,
            rays_per_frame: 8,
            rays: 1024,
            guide_side: 6,
        }
    }
}

/// How far the probes are off.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Error {
    /// Mean over probes and seeds of |E - truth| / truth, of luminance.
    pub error: f64,
    /// Two standard errors of it, from seed to seed.
    pub plus_minus: f64,
    /// Mean of (E - truth) / truth.
    pub bias: f64,
    /// Two standard errors of that.
    pub bias_plus_minus: f64,
}

/// Errors after so many rays.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Rays of a probe so far.
    pub rays: u32,
    /// Over the cosine lobe.
    pub cosine: Error,
    /// Guided.
    pub guided: Error,
}

/// Errors under one environment: a row for each power of two of frames, and the last one.
///
/// # Errors
/// [`RenderError::Graph`] and [`RenderError::Backend`]; [`RenderError::Setting`] of a guide's size.
pub fn measure(
    backend: &dyn Backend,
    environment: &EnvironmentMap,
    options: &Options,
) -> Result<Vec<Row>, RenderError> {
    let settings = Settings {
        guide_side: options.guide_side,
        ..Settings::default()
    };
    settings.check()?;
    let sky = EnvironmentTable::build(&Environment::Map(environment.clone()));
    let normals = sphere(options.probes);
    let truths: Vec<f64> = normals.iter().map(|&n| irradiance(&sky, n)).collect();
    let run = |guided| run(backend, &sky, &normals, &truths, options, guided);
    let (cosine, guided) = (run(false)?, run(true)?);
    let rows = cosine.into_iter().zip(guided);
    Ok(rows
        .map(|((rays, cosine), (_, guided))| Row {
            rays,
            cosine,
            guided,
        })
        .collect())
}

/// Unit vectors spread over the sphere: a Fibonacci lattice.
fn sphere(count: u32) -> Vec<Vec3> {
    use std::f64::consts::TAU;
    let golden = (5f64.sqrt() - 1.0) / 2.0;
    (0..count)
        .map(|i| {
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
            let r = (1.0 - z * z).sqrt();
            let (sin, cos) = (TAU * golden * f64::from(i)).sin_cos();
            glam::DVec3::new(r * cos, z, r * sin).as_vec3()
        })
        .collect()
}

fn run(
    backend: &dyn Backend,
    sky: &EnvironmentTable,
    normals: &[Vec3],
    truths: &[f64],
    options: &Options,
    guided: bool,
) -> Result<Vec<(u32, Error)>, RenderError> {
    let frame = ProbeFrame {
        normals: (0..options.seeds).flat_map(|_| normals.to_vec()).collect(),
        per_place: options.per_place,
        rays: options.rays_per_frame,
        guide_side: guided.then_some(options.guide_side),
    };
    let mut g = Graph::new("probes");
    probe_frame(&mut g, &frame, sky);
    let mut exec = backend.prepare(Arc::new(compile(g)?))?;
    upload_probes(exec.as_mut(), &frame, sky)?;
    let frames = options.rays.div_ceil(options.rays_per_frame).max(1);
    let mut rows = Vec::new();
    for number in 0..frames {
        upload_probe_frame(exec.as_mut(), sky, number, 0)?;
        exec.run()?;
        let done = number + 1;
        if done.is_power_of_two() || done == frames {
            let states: Vec<SurfelIrradiance> = read_output(exec.as_mut(), "irradiance")?;
            rows.push((
                done * options.rays_per_frame,
                error(&states, truths, options),
            ));
        }
    }
    Ok(rows)
}

/// `states` has all probes of a seed one after the other. Probes that no light reaches are left out.
fn error(states: &[SurfelIrradiance], truths: &[f64], options: &Options) -> Error {
    let per_place = options.per_place as usize;
    let (mut errors, mut biases) = (Vec::new(), Vec::new());
    for seed in states.chunks(truths.len() * per_place) {
        let relative = seed
            .iter()
            .zip(
                truths
                    .iter()
                    .flat_map(|truth| std::iter::repeat_n(truth, per_place)),
            )
            .filter(|(_, truth)| **truth > 0.0)
            .map(|(state, truth)| f64::from(luminance(state.mean)) / truth - 1.0);
        let relative: Vec<f64> = relative.collect();
        let count = relative.len().max(1) as f64;
        errors.push(relative.iter().map(|e| e.abs()).sum::<f64>() / count);
        biases.push(relative.iter().sum::<f64>() / count);
    }
    let (error, plus_minus) = interval(&errors);
    let (bias, bias_plus_minus) = interval(&biases);
    Error {
        error,
        plus_minus,
        bias,
        bias_plus_minus,
    }
}

/// Mean, and two standard errors of it.
fn interval(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
    let variance = squares / (n - 1.0).max(1.0);
    (mean, 2.0 * (variance / n).sqrt())
}
