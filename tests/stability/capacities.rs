//! Every capacity too small at once. tests/budgets.rs exceeds them one by one.
use super::build::room;
use super::common::all_backends;
use super::measure::{SIZE, bits, draw, go_on, levels, settings};
use super::pictures;
use gibs::passes::frame::Settings;
use gibs::passes::scene::Scene;
use gibs::view::View;
use gibs::{Renderer, builtin};
use std::f64::consts::PI;

/// 4 slots and 4 entries of cells' lists where thousands are wanted, one surfel to a lookup, one ray, paths of one segment,
/// births at hits.
fn starved() -> Settings {
    Settings {
        surfels: 4,
        grid_lists: 1,
        lookup: 1,
        rays: 1,
        continuations: 1,
        hit_births: 4096,
        coverage: 8.0,
        check_slots: true,
        ..settings()
    }
}

fn starve(scene: &(Scene, View), settings: &Settings, holds: impl Fn(f64) -> bool, what: &str) {
    let (scene, view) = scene;
    for backend in all_backends() {
        let name = format!("{}: {what}", backend.name());
        let mut renderer = Renderer::new(backend.as_ref(), scene, view, SIZE, settings, 0)
            .unwrap_or_else(|e| panic!("{name}: {e}"));
        let (mut overflow, mut most) = (0, 0f64);
        for _ in 0..24 {
            let picture = go_on(&mut renderer, 1, &name);
            let counters = renderer.counters().expect("reads");
            assert_eq!(counters.slot_errors, Some(0), "{name}");
            assert!(counters.live <= settings.surfels, "{name}: {counters:?}");
            assert!(counters.rays <= settings.rays, "{name}: {counters:?}");
            overflow += u64::from(counters.overflow);
            for e in levels(&picture, "E") {
                assert!(holds(e), "{name}: {e}");
                most = most.max(e);
            }
        }
        let counters = renderer.counters().expect("reads");
        println!(
            "{name}: {} starved, {overflow} entries too many, E at most {most:.3}",
            counters.starved
        );
        assert!(counters.starved > 0 && overflow > 0, "{name}: {counters:?}");
        let picture = renderer.picture().expect("a picture");
        pictures::irradiance(&format!("capacities-{what}"), backend.name(), &picture);
    }
}

/// What does not fit is counted, and every value stays finite. A furnace bounds E: without emitter sampling every segment of a
/// ray weighs 1 at most, and there are two; each brings the emission, and of the most that a surfel has the share a. So `E <= 2
/// (pi e + a E)`, and at albedo 1/4 that is `4 pi e`.
#[test]
fn all_capacities_exceeded_at_once_are_counted() {
    let most = 4.0 * PI;
    let alone = Settings {
        emitters: false,
        ..starved()
    };
    let bounded = |e: f64| (0.0..=most).contains(&e);
    starve(&builtin::furnace(0.25, 1.0), &alone, bounded, "furnace");
    starve(&room(), &starved(), |e| e >= 0.0, "room");
}

/// Direct light takes no surfel: it is that of ample capacities, to the bit.
#[test]
fn direct_light_needs_no_capacity() {
    for backend in all_backends() {
        let name = backend.name();
        let of = |settings| draw(backend.as_ref(), &room(), SIZE, 4, settings, 0);
        let same = bits(&of(&starved()), "direct") == bits(&of(&settings()), "direct");
        assert!(same, "{name}");
        println!("{name}: starved: every bit of direct light is the same");
    }
}
