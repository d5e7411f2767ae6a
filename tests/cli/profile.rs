//! `gibs profile`: prints, compares with what it printed, writes a trace, refuses what is no profile.
use crate::program::*;
use serde_json::Value;

/// A small profile of the Cornell box on the CPU.
fn small<'a>(more: &[&'a str]) -> Vec<&'a str> {
    let args = [
        "profile",
        "cornell",
        "--backend",
        "cpu",
        "--size",
        "32x24",
        "--frames",
        "2",
        "--warm-up",
        "1",
    ];
    [&args, more].concat()
}

#[test]
fn profiles_are_printed_compared_and_traced() {
    let folder = Folder::new("profile");
    let printed = succeed(&small(&["--json", "--why", "--runs", "2"]));
    let file: Value = serde_json::from_str(&printed).unwrap();
    let mut profiles = file["profiles"].clone();
    assert_eq!(file["not_run"], serde_json::json!([]));
    assert_eq!(file["failed"], serde_json::json!([]));
    assert_eq!(profiles[0]["backend"], "cpu");
    assert_eq!(profiles[0]["size"], serde_json::json!([32, 24]));
    let needs = profiles[0]["needs"].as_array().unwrap();
    let guiding = needs.iter().find(|need| need["name"] == "ray guiding");
    assert!(guiding.unwrap()["time"]["ms"].is_f64(), "{guiding:?}");
    // The processor has no ray queries; to time the frame without them would say nothing.
    let queries = needs.iter().find(|need| need["name"] == "ray queries");
    assert_eq!(queries.unwrap()["time"], Value::Null);
    assert!(queries.unwrap()["not_measured"].is_string(), "{queries:?}");

    let (old, trace) = (
        folder.write("old.json", &printed),
        folder.path("trace.json"),
    );
    let told = succeed(&small(&["--against", &old, "--trace", &trace]));
    for part in [
        "left out: direct light",
        "against ",
        "not alike: runs",
        "95 % interval",
        "apply/compose",
    ] {
        assert!(told.contains(part), "{part}: {told}");
    }
    assert!(!told.contains("not alike: setting"), "{told}");
    // Programs hear of it, too; and a backend that is named twice is measured once.
    let compared = succeed(&small(&["--against", &old, "--json", "--backend", "cpu"]));
    let compared: Value = serde_json::from_str(&compared).unwrap();
    let compared = &compared["profiles"];
    assert_eq!(compared.as_array().map(Vec::len), Some(1), "{compared}");
    let against = &compared[0]["against"];
    assert_eq!(against["frame"]["name"], "frame", "{against}");
    assert!(against["frame"]["ratio"].is_object(), "{against}");
    assert!(profiles[0].get("against").is_none());
    // Figures that nobody measured are refused by name, and names are told without what a terminal would obey.
    let wall = |of_runs: Value| {
        let mut changed: Value = serde_json::from_str(&printed).unwrap();
        changed["profiles"][0]["frame"]["wall_ms"]["of_runs"] = of_runs;
        changed
    };
    let mut escape = wall(Value::Array(vec![]));
    escape["profiles"][0]["frame"] = profiles[0]["frame"].clone();
    escape["profiles"][0]["groups"][0]["name"] = "\u{1b}[2J".into();
    escape["profiles"][0]["groups"][0]["ms"]["median"] = (-1.0).into();
    for (name, broken, parts) in [
        (
            "no-runs.json",
            wall(serde_json::json!([])),
            ["`frame`", "0 runs"],
        ),
        (
            "more-runs.json",
            wall(serde_json::json!([1, 2, 3])),
            ["`frame`", "there were 2"],
        ),
        (
            "negative.json",
            wall(serde_json::json!([1, -2])),
            ["`frame`", "-2 milliseconds"],
        ),
        ("escape.json", escape, ["`\\u{1b}[2J`", "-1 milliseconds"]),
        (
            "zeros.json",
            wall(serde_json::json!([0, 0])),
            ["`frame`", "where runs have from 0 to 0"],
        ),
        (
            "empty.json",
            serde_json::json!({ "gibs_profile": file["gibs_profile"], "profiles": [] }),
            ["is empty", "gibs profile"],
        ),
    ] {
        let broken = folder.write(name, &broken.to_string());
        let parts = [&parts[..], &[name, "write it anew"]].concat();
        refused(&small(&["--against", &broken]), &parts);
    }
    let trace: Value = serde_json::from_str(&folder.read("trace.json")).unwrap();
    let events = trace["traceEvents"].as_array().unwrap();
    let frames = events.iter().filter(|e| e["tid"] == 1 && e["ph"] == "X");
    assert_eq!(frames.count(), 2);

    // Of two other backends, neither is what the CPU is to be held against.
    for (name, at) in [("wgpu", 0), ("vulkan", 1)] {
        let mut other = profiles[0].clone();
        other["backend"] = name.into();
        match at {
            0 => profiles[0] = other,
            _ => profiles.as_array_mut().unwrap().push(other),
        }
    }
    let mut others = file.clone();
    others["profiles"] = profiles;
    let others = folder.write("others.json", &others.to_string());
    refused(
        &small(&["--against", &others]),
        &["others.json", "cpu", "wgpu, vulkan"],
    );
}

#[test]
fn what_is_no_profile_is_refused_before_anything_is_measured() {
    let folder = Folder::new("no-profile");
    let wrong = folder.write("wrong.json", "{\"gibs_profile\": 1}");
    refused(
        &small(&["--against", &wrong]),
        &["wrong.json", "gibs profile"],
    );
    let trace = folder.write("trace.json", "{\"traceEvents\": []}");
    refused(
        &small(&["--against", &trace]),
        &["trace.json is a trace, no profile", "gibs profile"],
    );
    let stress = folder.write("stress.json", "[{\"scene\": \"cornell\"}]");
    refused(
        &small(&["--against", &stress]),
        &["stress.json is JSON of something else"],
    );
    let absent = folder.path("absent.json");
    refused(
        &small(&["--against", &absent]),
        &["absent.json", "gibs profile"],
    );
    let nowhere = folder.path("no/such/folder/trace.json");
    refused(
        &small(&["--trace", &nowhere]),
        &["trace.json", "does not exist"],
    );
    for wrong in [["--frames", "0"], ["--runs", "0"], ["--backend", "gpu"]] {
        refused(&small(&wrong), &[wrong[0]]);
    }
}
