//! `gibs stress` and `gibs roam`.
use crate::program::*;
use serde_json::Value;

#[test]
fn a_stress_test_reports_when_light_has_converged() {
    let folder = Folder::new("stress");
    let report = folder.path("out");
    let runs = json(&[
        "stress",
        "cornell",
        "--backend",
        "cpu",
        "--size",
        "64x64",
        "--frames",
        "12",
        "--rays",
        "500,2000",
        "--converged",
        "20",
        "--set",
        "surfels=512",
        "--report",
        &report,
        "--json",
    ]);
    for (run, budget) in runs.as_array().unwrap().iter().zip([500, 2000]) {
        assert_eq!(
            (&run["budget"], &run["limit"]),
            (&budget.into(), &0.2.into())
        );
        assert_eq!(
            (&run["scene"], &run["seed"]),
            (&"cornell".into(), &0.into())
        );
        assert_eq!(run["settings"]["rays"], budget);
        assert_eq!(run["settings"]["surfels"], 512);
        // It is on in every such run, and part of its time.
        assert_eq!(run["settings"]["check_slots"], true);
        assert!(run["view"]["camera"].is_object() && run["driver"].is_string());
        assert_eq!(run["totals"]["slot_errors"], 0);
        let rows = run["rows"].as_array().unwrap();
        assert_eq!(rows.len(), 12);
        let error = |row: &Value| row["error"].as_f64().unwrap();
        // Against the last frame, which thus has none.
        assert!(error(&rows[0]) > error(&rows[10]) && rows[11]["error"].is_null());
        assert!(rows[1..].iter().all(|row| row["rays"] == budget));
        // Nothing says that what no longer changes is right.
        assert!(run.get("converged").is_none());
        let frames = run["settled"]["frames"].as_u64().unwrap() as usize;
        assert!(rows[frames - 1..11].iter().all(|row| error(row) < 0.2));
        assert!(frames == 1 || error(&rows[frames - 2]) >= 0.2);
        let groups: Vec<_> = run["groups"].as_array().unwrap().iter().collect();
        for group in [
            "gbuffer",
            "persistent",
            "spawn",
            "filtering",
            "apply",
            "check",
        ] {
            assert!(groups.iter().any(|g| *g == group), "{group} in {groups:?}");
        }
    }
    let names = Folder::at(&folder.path("out")).names();
    assert_eq!(
        names,
        ["cost-2000.svg", "cost-500.svg", "error.svg", "stress.csv"]
    );
}

#[test]
fn a_stress_test_refuses_truths_of_other_sizes_and_scenes() {
    let folder = Folder::new("stress-truth");
    let truth = folder.path("truth.exr");
    succeed(&[
        "reference",
        "cornell",
        "--backend",
        "cpu",
        "--size",
        "32x32",
        "--spp",
        "4",
        "--out",
        &truth,
    ]);
    let stress_of = |scene: &'static str, size: &'static str| {
        vec![
            "stress",
            scene,
            "--backend",
            "cpu",
            "--size",
            size,
            "--frames",
            "2",
            "--truth",
            &truth,
        ]
    };
    let stress = |size| stress_of("cornell", size);
    // Three times as large: the centres of the truth's pixels.
    let output = gibs(&stress("96x96"));
    let text = stdout(&output);
    assert!(text.contains("not converged after 2 frames"), "{text}");
    assert!(!stderr(&output).contains("another surface"));
    refused(
        &stress_of("atrium", "96x96"),
        &["truth.exr: ", "another surface"],
    );
    // Without light there is no error, and nothing that might settle.
    let dark = ["stress", "cornell", "--backend", "cpu", "--size", "32x32"];
    let text = succeed(&[&dark[..], &["--frames", "3", "--rays", "0"]].concat());
    assert!(
        text.contains("no indirect light") && !text.contains("settled"),
        "{text}"
    );
    refused(&stress("64x64"), &["truth.exr", "2 times as large"]);
    refused(&stress("40x32"), &["truth.exr", "40x32"]);
}

#[test]
fn a_flight_reports_surfels_slots_and_holes() {
    let folder = Folder::new("roam");
    let report = folder.path("out");
    let path = folder.write(
        "path.json",
        r#"{"keys": [{"frame": 0, "position": [2.78, 2.73, -8], "target": [2.78, 2.73, 0]},
                     {"frame": 19, "position": [2.78, 2.73, -3], "target": [2.0, 2.0, 2]}]}"#,
    );
    let args = [
        "roam",
        "cornell",
        "--backend",
        "cpu",
        "--size",
        "64x64",
        "--frames",
        "20",
        "--rays",
        "500",
        "--path",
        &path,
        "--set",
        "surfels=512",
    ];
    let flight = json(
        &[
            &args[..],
            &["--report", &report, "--pictures", "10", "--json"],
        ]
        .concat(),
    );
    assert_eq!(
        (&flight["scene"], &flight["seed"]),
        (&"cornell".into(), &0.into())
    );
    assert_eq!(
        (&flight["path"], &flight["settings"]["surfels"]),
        (&path.as_str().into(), &512.into())
    );
    assert!(flight["view"]["camera"].is_object() && flight["driver"].is_string());
    let rows = flight["rows"].as_array().unwrap();
    assert_eq!(
        (rows.len(), &flight["totals"]["slot_errors"]),
        (20, &0.into())
    );
    let settled = rows[19]["settled"].as_u64().unwrap();
    assert!(
        settled * 10 > rows[19]["surfaces"].as_u64().unwrap() * 9,
        "{}",
        rows[19]
    );
    assert_eq!(rows[5]["settled"], 0);
    let names = Folder::at(&folder.path("out")).names();
    assert_eq!(
        names,
        [
            "cost.svg",
            "frame-00000.png",
            "frame-00010.png",
            "holes.svg",
            "roam.csv",
            "surfels.svg"
        ]
    );
    let text = succeed(&args);
    assert!(
        text.contains("0 slot errors") && text.contains("in view for 8 frames"),
        "{text}"
    );
    let broken = folder.write(
        "broken.json",
        r#"{"keys": [{"frame": -3, "position": [0, 0, 0], "target": [0, 0, 1]}]}"#,
    );
    refused(
        &["roam", "cornell", "--backend", "cpu", "--path", &broken],
        &["broken.json", "keys[0].frame", "-3"],
    );
}

#[test]
fn what_runs_out_is_warned_of_with_the_setting_to_raise() {
    let folder = Folder::new("shortage");
    let out = folder.path("a.png");
    let output = gibs(&[
        "render",
        "cornell",
        "--backend",
        "cpu",
        "--size",
        "64x64",
        "--frames",
        "4",
        "--rays",
        "100",
        "--set",
        "surfels=32",
        "--set",
        "grid_lists=1",
        "--out",
        &out,
        "--json",
    ]);
    let message = stderr(&output);
    assert!(output.status.success(), "{message}");
    for part in [
        "no free surfel; raise `surfels`",
        "did not fit the grid; raise `grid_lists`",
    ] {
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn crowded_cells_and_surfels_without_rays_are_warned_of() {
    let folder = Folder::new("crowded");
    let out = folder.path("a.png");
    let small = ["cornell", "--backend", "cpu", "--size", "64x64"];
    let crowded = ["--frames", "20", "--set", "lookup=1"];
    for command in ["render", "stress", "roam"] {
        let mut args = [&[command], &small[..], &crowded].concat();
        if command == "render" {
            args.extend(["--out", &out, "--json"]);
        }
        let output = gibs(&args);
        let message = stderr(&output);
        assert!(output.status.success(), "{message}");
        assert!(message.contains("raise `lookup`"), "{command}: {message}");
        if command == "render" {
            let summary: Value = serde_json::from_slice(&output.stdout).expect("JSON");
            let holes = summary["crowded"].as_u64().expect("a number");
            assert!(message.contains(&format!("{holes} holes")), "{message}");
            // Rays beyond hits come on top.
            assert_eq!(summary["rays"], 100_000);
            assert!(summary["continued_rays"].as_u64() > Some(1000), "{summary}");
        } else {
            let said = String::from_utf8_lossy(&output.stdout);
            assert!(said.contains("holes in crowded cells"), "{said}");
        }
    }
    // 160 rays in all, of surfels alone.
    let few = ["--frames", "8", "--rays", "20"];
    for command in ["render", "stress", "roam"] {
        let mut args = [&[command], &small[..], &few].concat();
        if command == "render" {
            args.extend(["--out", &out]);
        }
        let message = stderr(&gibs(&args));
        let had = "surfels have had 160 rays in all";
        assert!(message.contains(had), "{command}: {message}");
    }
}
