//! An element of the technique that is switched off is off: in the schedule, where it has stages or buffers of its own, else in what
//! the stages are told.
mod common;

use common::{cpu, mean, render};
use gibs::passes::frame::{ELEMENTS, Screen, Settings};
use gibs::{Gi, builtin};
use std::collections::BTreeSet;

/// Labels of the steps, and keys of the resources, of the Cornell box's frame.
fn parts(settings: &Settings) -> BTreeSet<String> {
    parts_of(settings, Screen::Traced)
}

fn parts_of(settings: &Settings, screen: Screen) -> BTreeSet<String> {
    parts_in("cornell", settings, screen)
}

fn parts_in(scene: &str, settings: &Settings, screen: Screen) -> BTreeSet<String> {
    let (scene, view) = builtin::by_name(scene).expect("built in");
    let gi = Gi::new(&scene, &view, [64, 48], settings, screen).expect("compiles");
    let schedule = gi.schedule();
    let labels = schedule.steps.iter().map(|step| step.label.clone());
    let keys = schedule.resources.iter().map(|r| r.key.clone());
    labels.chain(keys).collect()
}

#[test]
fn what_is_off_has_no_stages() {
    for element in ELEMENTS {
        // Whatever has one of these in its name belongs to the element.
        let own: &[&str] = match element.name {
            "depth" => &["update_depth", "surfel_depths"],
            "guiding" => &["update_guide", "surfel_guides"],
            "sharing" => &["filtering/spatial", "neighbours"],
            "sorting" => &["persistent/ray_sorting", "spawn/ray_sorting", "sorted_rays"],
            "emitters" => &["scene_emitters"],
            "continuation" => &["continue_paths", "path_rays", "rays_1"],
            "half-resolution" => &[
                "select_pixels",
                "pack_pixels",
                "contrasts",
                "apply/upsample",
            ],
            "hit-births" => &["spawn/hit", "hit_candidates"],
            "clamp" => &["filtering/clamped"],
            "steering" | "fallback" => &[],
            name => panic!("say here what belongs to `{name}`"),
        };
        let defaults = Settings::default();
        let [on, off] = [true, false].map(|on| element.switched(&defaults, on));
        let [with, without] = [parts(&on), parts(&off)];
        for name in own {
            let has = |parts: &BTreeSet<String>| parts.iter().any(|part| part.contains(name));
            assert!(has(&with), "{}: nothing is called {name}", element.name);
            assert!(!has(&without), "{} is off, {name} is there", element.name);
        }
        if own.is_empty() {
            assert_eq!(with, without, "{}", element.name);
            let size = [64, 48];
            assert_ne!(on.device(size), off.device(size), "{}", element.name);
        }
    }
}

/// One light a point takes as many samples as there are points, whose dispatch is there already.
#[test]
fn light_samples_have_a_batch_of_their_own_where_they_are_several() {
    let two = Settings {
        lights: 2,
        ..Settings::default()
    };
    let one = Settings {
        lights: 1,
        ..Settings::default()
    };
    for (scene, settings, own) in [
        ("window-room", &two, false),
        ("many-lights", &two, true),
        ("many-lights", &one, false),
    ] {
        let parts = parts_in(scene, settings, Screen::Traced);
        let has = |name: &str| parts.iter().any(|part| part.contains(name));
        assert!(has("persistent/sample_lights_1") && has("apply/sample_lights"));
        assert_eq!(has("light_batch"), own, "{scene}");
    }
}

/// The parts of the talk's frame ("Frame Overview"), but for those of transparency.
#[test]
fn the_parts_of_the_talks_frame_are_there_by_name() {
    let settings = Settings {
        sorting: true,
        ..Settings::default()
    };
    let there = parts_of(&settings, Screen::Imported);
    for part in [
        "persistent/positional_update",
        "persistent/recycle",
        "persistent/grid_order",
        "persistent/ray_sorting_order",
        "persistent/ray_trace",
        "spawn/geometric_normals",
        "spawn/gap_fill",
        "spawn/ray_sorting_order",
        "spawn/ray_trace",
        "spawn/write_to_persistent_storage",
        "filtering/spatial",
        "filtering/temporal",
        "apply/inject_insert",
        "apply/lighting_apply",
        "apply/upsample",
    ] {
        assert!(there.contains(part), "{part}");
    }
    // Where rays are not sorted, those of new surfels are traced on their own as well; where rays find the surfaces, these have
    // their normals.
    let there = parts(&Settings::default());
    assert!(there.contains("spawn/ray_trace"));
    assert!(!there.contains("spawn/geometric_normals"));
}

/// In the first frame many pixels lie between surfels: at 480x270 the Cornell box is 29 % too dark without the average of the
/// cell, and 1 % with it.
#[test]
fn without_the_fallback_the_first_frame_is_dark() {
    let view = builtin::by_name("cornell").expect("built in");
    let [with, without] = [true, false].map(|fallback| {
        let settings = Settings {
            fallback,
            rays: 20_000,
            ..Settings::default()
        };
        mean(
            &render(cpu().as_ref(), &view, [160, 120], 1, &settings, 0),
            "E",
        )
    });
    println!("E {with:.4} with, {without:.4} without");
    assert!(without < 0.9 * with, "{without} and {with}");
}
