//! What the firefly clamp takes is counted.
mod common;

use common::{all_backends, mean, settings};
use gibs::graph::Graph;
use gibs::passes::data::ClampedLight;
use gibs::passes::frame::{Settings, SurfelOutputs};
use gibs::{Clamped, Renderer, builtin};

const SIZE: [u32; 2] = [64, 64];

fn clamping(rays: u32) -> Settings {
    Settings {
        clamp: true,
        ..settings(rays)
    }
}

/// The total is the sum of what each frame took from each surfel, alike on every backend, and begins anew with the surfels.
#[test]
fn the_total_is_what_the_frames_took() {
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    // Else the memory of what each surfel lost is used again before the frame ends.
    let keep = |g: &mut Graph, _: SurfelOutputs| g.keep_transients();
    let mut totals = Vec::new();
    for backend in all_backends() {
        let name = backend.name();
        let mut renderer = Renderer::extended(
            backend.as_ref(),
            &scene,
            &view,
            SIZE,
            &clamping(4000),
            0,
            keep,
        )
        .unwrap_or_else(|e| panic!("{name}: {e}"));
        let (mut taken, mut brought, mut times) = (0.0, 0.0, 0);
        for _ in 0..48 {
            renderer.frame().expect("a frame");
            let exec = renderer.executable();
            let id = exec.schedule().resource("clamped_light").expect("a buffer");
            let frame: Vec<ClampedLight> =
                bytemuck::pod_collect_to_vec(&exec.read(id).expect("readable"));
            for surfel in frame {
                assert!(
                    surfel.taken >= 0.0 && surfel.taken <= surfel.brought,
                    "{name}"
                );
                taken += f64::from(surfel.taken);
                brought += f64::from(surfel.brought);
                times += surfel.samples;
            }
        }
        let counted = renderer.counters().expect("counters").clamped;
        let counted = counted.expect("the clamp is on");
        println!("{name}: {counted:?}, {:.6} by hand", taken / brought);
        assert_eq!(counted.times, times, "{name}");
        assert!(times > 20 && taken > 0.0, "{name}: nothing to count");
        // Sums of 48 frames, each of 32 surfels per lane and eight pairs: 88 roundings of 2^-24.
        let off = (f64::from(counted.share) / (taken / brought) - 1.0).abs();
        assert!(
            off < 2.0 * 88.0 * f64::from(f32::EPSILON) / 2.0,
            "{name}: {off:e}"
        );
        renderer.reset().expect("resets");
        renderer.frame().expect("a frame");
        let anew = renderer.counters().expect("counters").clamped;
        assert_eq!(anew, Some(Clamped::default()), "{name}");
        totals.push(counted);
    }
    assert!(
        totals.windows(2).all(|pair| pair[0] == pair[1]),
        "{totals:?}"
    );
}

/// Where every ray brings the same, there are no fireflies, and the box keeps its closed form.
#[test]
fn an_even_light_loses_nothing() {
    let (scene, view) = builtin::furnace(0.5, 1.0);
    for backend in all_backends() {
        let mut renderer =
            Renderer::new(backend.as_ref(), &scene, &view, SIZE, &clamping(10_000), 0)
                .expect("a renderer");
        for _ in 0..96 {
            renderer.frame().expect("a frame");
        }
        let clamped = renderer.counters().expect("counters").clamped;
        let radiance = mean(&renderer.picture().expect("a picture"), "");
        println!("{}: {clamped:?}, radiance {radiance:.4}", backend.name());
        assert!((radiance / 2.0 - 1.0).abs() < 0.03, "{radiance}");
        assert!(clamped.expect("the clamp is on").share < 1e-3);
    }
}

#[test]
fn without_the_clamp_nothing_is_counted() {
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    let backend = common::cpu();
    let mut renderer = Renderer::new(backend.as_ref(), &scene, &view, SIZE, &settings(1000), 0)
        .expect("a renderer");
    renderer.frame().expect("a frame");
    assert_eq!(renderer.counters().expect("counters").clamped, None);
}
