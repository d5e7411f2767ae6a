//! An element of the technique that is switched off is off: in the schedule, where it has stages or buffers of its own, else in what
//! the stages are told.
use gibs::passes::frame::{ELEMENTS, Screen, Settings};
use gibs::{Gi, builtin};
use std::collections::BTreeSet;

/// Labels of the steps, and keys of the resources, of the Cornell box's frame.
fn parts(settings: &Settings) -> BTreeSet<String> {
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    let gi = Gi::new(&scene, &view, [64, 48], settings, Screen::Traced).expect("compiles");
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
            "sorting" => &["ray_sorting", "sorted_rays", "spawn/ray_trace"],
            "emitters" => &["scene_emitters"],
            "continuation" => &["continue_paths", "path_rays", "rays_1"],
            "half-resolution" => &["select_pixels", "pack_points", "apply/upsample"],
            "hit-births" => &["spawn/hit", "hit_candidates"],
            "clamp" => &["filtering/clamped"],
            "steering" => &[],
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
