//! `gibs graph`.
use crate::program::*;

#[test]
fn the_frame_is_shown_in_every_format() {
    let text = succeed(&["graph", "cornell"]);
    let dot = succeed(&["graph", "cornell", "--format", "dot"]);
    let schedule = json(&["graph", "cornell", "--format", "json"]);
    let steps = schedule["steps"].as_array().unwrap();
    assert!(dot.starts_with("digraph"), "{dot}");
    for label in [
        "gbuffer/ray_trace",
        "persistent/positional_update",
        "persistent/ray_trace",
        "spawn/gap_fill",
        "apply/lighting_apply",
        "apply/compose",
    ] {
        assert!(text.contains(label), "{label} is not in: {text}");
        assert!(dot.contains(label), "{label} is not in the DOT text");
        assert!(
            steps.iter().any(|step| step["label"] == label),
            "{label} is not in the JSON"
        );
    }
    // A box without lights has no stage for them; a street has.
    assert!(!text.contains("sample_lights"), "{text}");
    assert!(succeed(&["graph", "many-lights"]).contains("apply/sample_lights"));
    // An element that is switched off takes its stages along.
    let without = succeed(&["graph", "cornell", "--without", "continuation"]);
    assert!(text.contains("continue_paths") && !without.contains("continue_paths"));
}

/// The Cornell box has no light but its lamp's surface; the atrium has the sun. What is needed is in the frame, what is
/// left out is not.
#[test]
fn why_says_what_the_scene_needs() {
    let printed = json(&["graph", "cornell", "--why", "--format", "json"]);
    let needs = printed["needs"].as_array().unwrap();
    assert_eq!(printed["scene"], "cornell");
    assert!(printed["settings"]["rays"].is_u64() && printed.get("measured").is_none());
    let lights = needs.iter().find(|need| need["name"] == "direct light");
    let lights = lights.unwrap();
    assert_eq!(lights["present"], false);
    assert_eq!(lights.get("time"), Some(&serde_json::Value::Null));
    assert!(!lights["stages"].as_array().unwrap().is_empty());
    let small = ["--size", "32x24", "--measure", "1", "--backend", "cpu"];
    let timed = ["graph", "cornell", "--why", "--format", "json"];
    let timed = json(&[&timed, &small[..]].concat());
    let measured = &timed["measured"];
    assert_eq!(
        (&measured["backend"], &measured["frames"]),
        (&"cpu".into(), &1.into())
    );
    assert_eq!(timed["size"], serde_json::json!([32, 24]));
    // Rays to emitters that are not there would not be traced.
    let why = succeed(&[&["graph", "atrium", "--why"], &small[..]].concat());
    let emitters = why.split("emitter sampling").nth(1).unwrap_or_default();
    let line = emitters.lines().nth(1).unwrap_or_default();
    assert!(line.contains("time not measured: "), "{why}");
    refused(
        &["graph", "cornell", "--why", "--format", "dot"],
        &["--format", "dot", "--why"],
    );
    for (scene, light) in [("cornell", "left out"), ("atrium", "needed")] {
        let why = succeed(&["graph", scene, "--why"]);
        let frame = succeed(&["graph", scene]);
        assert!(
            why.contains(&format!("{light}: direct light, because of")),
            "{why}"
        );
        assert!(why.contains("left out: irradiance at points, because of the setting queries = 0"));
        let mut present = None;
        let mut stages = 0;
        for line in why.lines() {
            if let Some(binding) = line.strip_suffix(" (binding)") {
                assert!(binding.contains('.'), "{binding}");
            } else if let Some(stage) = line.strip_prefix("    ") {
                let there = frame
                    .lines()
                    .any(|step| step.split_whitespace().any(|word| word == stage));
                assert_eq!(Some(there), present, "{scene}: {stage}");
                stages += 1;
            } else if !line.starts_with(' ') {
                present = Some(line.starts_with("needed"));
            }
        }
        assert!(stages > 40, "{scene}: {stages} stages");
        let without = succeed(&["graph", scene, "--why", "--without", "continuation"]);
        assert!(
            without.contains("left out: paths beyond a hit"),
            "{without}"
        );
    }
}
