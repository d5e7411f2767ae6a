//! Closed boxes of high albedo, where light that is lost or gained at a bounce comes back a hundred times over. tests/furnace.rs
//! has albedos up to 0.8, tests/long_run.rs ten thousand frames at 0.95.
use super::common::{self, all_backends};
use super::measure::{U, go_on, levels, mean};
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

/// Mean and standard deviation of a path of the reference in a furnace of emission 1, over pi: a path goes on with probability
/// `s = min(albedo, 0.98)`, after which it counts `q = albedo / s` as much, so that n segments bring `1 + q + .. + q^(n-1)`.
///
/// At albedo 0.99, `s q^2` is above one, and the variance of an endless path has no bound. A path longer than 1200 segments
/// comes once in `0.98^-1200 = 3e10`; of those up to that length the moments are finite.
fn path(albedo: f64) -> (f64, f64) {
    let survival = albedo.min(0.98);
    let (mut ends, mut counts, mut brings) = (1.0 - survival, 1.0, 1.0);
    let (mut mean, mut square) = (0.0, 0.0);
    for _ in 0..1200 {
        mean += ends * brings;
        square += ends * brings * brings;
        ends *= survival;
        counts *= albedo / survival;
        brings += counts;
    }
    (mean, (square - mean * mean).sqrt())
}

/// Every point receives `pi e / (1 - a)`. Without emitter sampling each path is the sum of [`path`], so that the mean over n
/// of them has the standard error that it gives: the bound is 5 of those.
#[test]
fn the_reference_reaches_albedo_0_99() {
    for backend in all_backends() {
        let name = backend.name();
        for albedo in [0.9f32, 0.99] {
            let (scene, view) = builtin::furnace(albedo, 1.0);
            let options = ReferenceOptions {
                size: [64, 64],
                samples: 6,
                seed: 1,
                emitters: false,
            };
            let (picture, _) =
                reference(backend.as_ref(), &scene, &view, &options, |_, _| {}).expect("renders");
            super::measure::assert_finite(&picture, name);
            let a = f64::from(albedo);
            let want = PI / (1.0 - a);
            let (of_path, deviation) = path(a);
            assert!((of_path * (1.0 - a) - 1.0).abs() < 1e-3, "{of_path}");
            let paths = f64::from(options.size[0] * options.size[1] * options.samples);
            let bound = 5.0 * deviation / of_path / paths.sqrt();
            let off = mean(&levels(&picture, "E")) / want - 1.0;
            println!(
                "{name}: reference at albedo {albedo}: {:+.3} % (bound {:.3} %)",
                off * 100.0,
                bound * 100.0
            );
            assert!(off.abs() <= bound, "{name}: {albedo}: {off}");
        }
    }
}

/// Share of the closed form that a box of surfels of one age lacks after so many frames of `rays` rays each: a ray ends at a
/// surfel with the probability of its trust, where what that lacks comes back times the albedo; else it goes on, up to
/// `CONTINUATIONS` times, and each segment lacks the less. What rays bring goes through the estimator itself, as noisy ones,
/// which forget the slowest.
///
/// That bounds what is lacking from above: a longer list of segments, walls without surfels, quiet means and surfels born later,
/// into a box that is brighter by then, all lack less.
fn lacks(albedo: f64, frames: u32, rays: u32) -> f64 {
    let mut state = SurfelIrradiance::default();
    let mut lacking = 1.0;
    for frame in 0..frames {
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

/// E is between `(1 - lacks) * pi e / (1 - a)` and the closed form, but for noise: [`lacks`] says how the number of frames bounds
/// the error. By its power law, albedo 0.99 would take more than 10^20 frames to come within 1 %: it is the bound on what is
/// lacking that is held there, and that nothing is gained.
///
/// Noise: rays that find the same radiance everywhere differ by how long their path was, by the closed form at most; over
/// all rays of the last 32 frames that is `1 / sqrt(32 * 8192) = 0.2 %`; the bound is 5 of those, 1 %.
#[test]
fn surfels_lack_no_more_than_their_estimator_does() {
    for backend in all_backends() {
        let name = backend.name();
        for albedo in [0.9f32, 0.99] {
            let (scene, view) = builtin::furnace(albedo, 1.0);
            let mut renderer =
                Renderer::new(backend.as_ref(), &scene, &view, [48, 27], &settings(), 1)
                    .expect("prepares");
            let mut drawn = 0;
            for frames in [32, 128] {
                let picture = go_on(&mut renderer, frames - drawn, name);
                drawn = frames;
                let counters = renderer.counters().expect("reads");
                let rays = (counters.rays / counters.live.max(1)).max(1);
                let share = mean(&levels(&picture, "E")) * (1.0 - f64::from(albedo)) / PI;
                let least = 1.0 - lacks(f64::from(albedo), frames, rays);
                println!(
                    "{name}: surfels at albedo {albedo}, {frames} frames of {rays} rays each: {:.2} % of the closed form \
                     (bounds {:.2} % to 100 %, 1 % for noise)",
                    share * 100.0,
                    least * 100.0
                );
                assert!(share >= least - 0.01, "{name}: {albedo}: {share}");
                assert!(share <= 1.01, "{name}: {albedo}: {share}");
                let lack = |e: f64| 1.0 - e * (1.0 - f64::from(albedo)) / PI;
                let errors: Vec<f64> = levels(&picture, "E").into_iter().map(lack).collect();
                let case = format!("white-walls-{albedo}-{frames}");
                pictures::errors(&case, name, &picture, &errors, 0.5);
            }
        }
    }
}

/// At albedo 1 light never ends and there is no closed form; what a frame can add is bounded: a ray has at most 17 segments,
/// each of which adds the emission, and ends at a surfel of the frame before. So no surfel has more than
/// `frames * 17 * pi e`, and what it has grows from frame to frame by no more than that. Without emitter sampling every ray weighs 1,
/// within the rounding of each of the segments' products.
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
        for frame in 1..=48 {
            let picture = go_on(&mut renderer, 1, name);
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
