//! What was measured is not lost when a file of its report cannot be written.
use crate::program::*;
use serde_json::Value;

/// Runs a command whose report has a folder where this file goes: what it prints, although it fails.
fn printed(args: &[&str], folder: &Folder, file: &str) -> Value {
    let report = folder.path("report");
    std::fs::create_dir_all(folder.path(&format!("report/{file}"))).unwrap();
    let usual = ["--backend", "cpu", "--size", "32x24", "--json"];
    let usual = match args[0] {
        "bench" => &usual[2..],
        _ => &usual[..],
    };
    let output = gibs(&[args, usual, &["--report", &report]].concat());
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains(file), "{message}");
    serde_json::from_str(&stdout(&output)).unwrap()
}

#[test]
fn a_bench_keeps_what_it_cannot_draw() {
    let folder = Folder::new("kept-bench");
    let args = "bench cornell --backends cpu --elements none --frames 1 --seeds 1 --search 0 --spp 4 --no-cache";
    let args: Vec<&str> = args.split(' ').collect();
    let all = printed(&args, &folder, "cornell-cpu-front.svg");
    assert_eq!(all["measured"].as_array().map(Vec::len), Some(1));
    assert_eq!(all["failed"], serde_json::json!([]));
    let written: Value = serde_json::from_str(&folder.read("report/bench.json")).unwrap();
    assert_eq!(written, all);
}

#[test]
fn a_stress_test_and_a_flight_keep_what_they_cannot_draw() {
    let folder = Folder::new("kept-runs");
    let runs = printed(
        &["stress", "cornell", "--frames", "2"],
        &folder,
        "error.svg",
    );
    assert_eq!(runs[0]["rows"].as_array().map(Vec::len), Some(2));
    let flight = printed(&["roam", "cornell", "--frames", "1"], &folder, "cost.svg");
    assert_eq!(flight["rows"].as_array().map(Vec::len), Some(1));
    // The first frame has no surfel to begin with: of holes nothing is known.
    assert_eq!(flight["holes"], Value::Null);
}
