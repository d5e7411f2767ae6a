//! Closed boxes of high albedo, where light that is lost or gained at a bounce comes back a hundred times over.
//! tests/furnace.rs has albedos up to 0.8, tests/long_run.rs ten thousand frames at 0.95.
use super::common::{self, all_backends};
use super::measure::{Noise, U, assert_finite, go_on, levels, mean};
use super::pictures;
use gibs::passes::data::SurfelIrradiance;
use gibs::passes::frame::Settings;
use gibs::passes::shared::{estimator, lookup};
use gibs::reference::{ReferenceOptions, reference};
use gibs::{Renderer, builtin};
use glam::Vec3;
use std::f64::consts::PI;

const CONTINUATIONS: u32 = 16;

fn settings() -> Settings {
    Settings {
        surfels: 2048,
        rays: 8192,
        continuations: CONTINUATIONS,
        ..Settings::default()
    }
}

/// Every point receives `pi e / (1 - a)`. A path goes on with the probability a, up to 0.99, and without emitter sampling
/// brings as much as it has segments: `1 / (1 - a)` on average, with the standard deviation `sqrt(a) / (1 - a)` of a geometric
/// distribution. Over n paths that is a relative standard error of `sqrt(a / n)`; the bound is 5 of those.
#[test]
fn the_reference_reaches_albedo_0_99() {
    for backend in all_backends() {
        let name = backend.name();
        let albedo = 0.99f32;
        let (scene, view) = builtin::furnace(albedo, 1.0);
        let options = ReferenceOptions {
            size: [64, 64],
            samples: 4,
            seed: 1,
            emitters: false,
        };
        let (picture, _) =
            reference(backend.as_ref(), &scene, &view, &options, |_, _| {}).expect("renders");
        assert_finite(&picture, name);
        let a = f64::from(albedo);
        let paths = f64::from(options.size[0] * options.size[1] * options.samples);
        let bound = 5.0 * (a / paths).sqrt();
        let off = mean(&levels(&picture, "E")) * (1.0 - a) / PI - 1.0;
        println!(
            "{name}: reference at albedo {albedo}: {:+.3} % (bound {:.3} %)",
            off * 100.0,
            bound * 100.0
        );
        assert!(off.abs() <= bound, "{name}: {albedo}: {off}");
    }
}

/// Share of the closed form that a box of surfels of one age lacks after frames in which each had so many rays. A ray ends at a
/// surfel with the probability of its trust, where what that lacks comes back times the albedo; else it goes on, up to
/// `CONTINUATIONS` times, and lacks the less. What rays bring goes through the estimator itself, as noisy ones, which forget
/// the slowest.
///
/// Walls without surfels, quiet means, and surfels that are born later, into a box that is brighter by then, lack less.
fn lacks(albedo: f64, rays: &[u32]) -> f64 {
    let mut state = SurfelIrradiance::default();
    let mut lacking = 1.0;
    for (frame, &rays) in (0..).zip(rays) {
        let trust = match frame {
            0 => 0.0,
            age => f64::from(lookup::trust(age - 1)),
        };
        let last = albedo * lacking;
        let of_ray = (0..CONTINUATIONS).fold(last, |beyond, _| {
            albedo * (trust * lacking + (1.0 - trust) * beyond)
        });
        let sample = Vec3::splat((1.0 - of_ray) as f32);
        state = estimator::update(&state, sample, rays, frame, false);
        // Noisy: a quiet mean goes on forgetting its first frames twice as fast.
        state.variance = 1.0;
        lacking = 1.0 - f64::from(state.mean.x);
    }
    lacking
}

/// E lies between `(1 - lacks) pi e / (1 - a)` and the closed form: [`lacks`] says how the frames bound the error. It falls
/// with the power `-2 (1 - a)` of their number. At albedo 0.99, to come from what 64 frames lack to 1 % takes `60^50` times as
/// many; so what is held there is that surfels lack no more than their estimator does, and gain nothing.
///
/// Both ends are for expectations. Chance adds 5 standard deviations of the mean, of [`Noise`] after the first 32 frames.
#[test]
fn surfels_lack_no_more_than_their_estimator_does() {
    for albedo in [0.9f32, 0.99] {
        let (scene, view) = builtin::furnace(albedo, 1.0);
        let size = [48, 27];
        let scene = (scene, view);
        let noise = 5.0 * Noise::of(&scene, size, 32, &settings()).of_mean;
        for backend in all_backends() {
            let name = backend.name();
            let (scene, view) = &scene;
            let mut renderer = Renderer::new(backend.as_ref(), scene, view, size, &settings(), 1)
                .expect("prepares");
            let mut rays = Vec::new();
            for frames in [32, 64] {
                while rays.len() < frames {
                    renderer.frame().expect("renders");
                    let counters = renderer.counters().expect("reads");
                    rays.push((counters.rays / counters.live.max(1)).max(1));
                }
                let picture = renderer.picture().expect("a picture");
                assert_finite(&picture, name);
                let lack = |e: &f64| 1.0 - e * (1.0 - f64::from(albedo)) / PI;
                let errors: Vec<f64> = levels(&picture, "E").iter().map(lack).collect();
                let (lacking, most) = (mean(&errors), lacks(f64::from(albedo), &rays));
                println!(
                    "{name}: surfels at albedo {albedo}, {frames} frames: {:.2} % lacking (bounds 0 % and {:.2} %, and \
                     {:.2} % for chance)",
                    lacking * 100.0,
                    most * 100.0,
                    noise * 100.0
                );
                assert!(lacking <= most + noise, "{name}: {albedo}: {lacking}");
                assert!(lacking >= -noise, "{name}: {albedo}: {lacking}");
                let case = format!("white-walls-{albedo}-{frames}");
                pictures::errors(&case, name, &picture, &errors, 0.5);
            }
        }
    }
}

/// At albedo 1 light never ends and there is no closed form; what a frame can add is bounded: a ray has at most 17 segments,
/// each of which adds the emission, and ends at a surfel of the frame before. So no surfel has more than `frames * 17 * pi e`,
/// and what it has grows from frame to frame by no more than that. Without emitter sampling every ray weighs 1, within the
/// rounding of each of the segments' products.
#[test]
fn white_walls_grow_no_faster_than_their_rays_bring() {
    let settings = Settings {
        emitters: false,
        ..settings()
    };
    let (scene, view) = builtin::furnace(1.0, 1.0);
    for backend in all_backends() {
        let name = backend.name();
        let mut renderer = Renderer::new(backend.as_ref(), &scene, &view, [48, 27], &settings, 1)
            .expect("prepares");
        let mut worst = 0f64;
        for frame in (4..=24).step_by(4) {
            let picture = go_on(&mut renderer, 4, name);
            let most = levels(&picture, "E").into_iter().fold(0.0, f64::max);
            let bound = f64::from(frame * (CONTINUATIONS + 1)) * PI * (1.0 + 64.0 * U);
            assert!(most <= bound, "{name}: frame {frame}: {most} of {bound}");
            worst = worst.max(most / bound);
        }
        println!("{name}: albedo 1: E is at most {worst:.3} of what 17 segments a frame bring");
    }
}

/// At albedo 0 only emission arrives: E is `pi e` at every pixel, whatever is drawn. Without emitter sampling every ray brings
/// 1 times pi; means of those are off by their roundings, at most 2 per frame and 1024 in a lookup: `2 (24 + 1024) U` at worst.
#[test]
fn black_walls_have_the_emission_alone() {
    let settings = Settings {
        emitters: false,
        ..settings()
    };
    let scene = builtin::furnace(0.0, 1.0);
    for backend in all_backends() {
        let name = backend.name();
        let picture = common::render(backend.as_ref(), &scene, [48, 27], 24, &settings, 1);
        let errors: Vec<f64> = levels(&picture, "E")
            .into_iter()
            .map(|e| (e / PI - 1.0).abs())
            .collect();
        let worst = errors.iter().fold(0f64, |a, &b| a.max(b));
        let bound = 2.0 * (24.0 + 1024.0) * U;
        println!("{name}: albedo 0: E is off by {worst:.2e} (bound {bound:.2e})");
        assert!(worst <= bound, "{name}: {worst}");
        pictures::errors("black-walls", name, &picture, &errors, bound);
    }
}
