//! `gibs bench`.
use crate::program::*;
use gibs::picture::Picture;
use serde_json::Value;

/// A small measurement of the Cornell box.
pub const FEW: [&str; 16] = [
    "bench",
    "cornell",
    "--backends",
    "cpu",
    "--size",
    "60x40",
    "--set",
    "surfels=8192",
    "--rays",
    "20000",
    "--frames",
    "3",
    "--spp",
    "16",
    "--search",
    "0.2",
];

fn rows(measured: &Value) -> &Vec<Value> {
    measured["rows"].as_array().unwrap()
}

fn last(row: &Value) -> &Value {
    row["after"].as_array().unwrap().last().unwrap()
}

#[test]
fn elements_are_measured_beside_path_tracing() {
    let folder = Folder::new("elements");
    let (report, cache) = (folder.path("report"), folder.path("cache"));
    let more = [
        "--elements",
        "guiding,sharing,guiding",
        "--seeds",
        "2",
        "--json",
        "--cache",
        &cache,
        "--report",
        &report,
    ];
    let all = json(&[&FEW[..], &more].concat());
    assert!(
        all["command"]
            .as_str()
            .unwrap()
            .starts_with("gibs bench cornell")
    );
    let measured = &all["measured"][0];
    assert_eq!(measured["backend"], "cpu");
    assert_eq!(measured["same_as_path_tracing"], serde_json::json!([]));
    // Every fifth pixel.
    assert_eq!(
        (&measured["truth"]["step"], &measured["truth"]["samples"]),
        (&5.into(), &16.into())
    );
    assert!(measured["truth"]["standard_error"].as_f64().unwrap() > 0.0);
    let rows = rows(measured);
    let text = |row: &Value, key: &str| row[key].as_str().unwrap().to_owned();
    let names: Vec<_> = rows.iter().map(|row| text(row, "name")).collect();
    assert_eq!(
        names,
        [
            "as set",
            "with guiding",
            "without sharing",
            "1/4 of the rays",
            "4 x the rays",
            "path tracing, equal rays",
            "path tracing, equal time",
            "brute force, equal rays",
            "brute force, equal time",
        ]
    );
    let rays: Vec<f64> = rows
        .iter()
        .map(|row| last(row)["rays"].as_f64().unwrap())
        .collect();
    // The budget, and up to as many again of paths that go on; path tracing takes whole samples, about eight a pixel, and the mean
    // length of its paths is known to a few percent.
    assert!((20_000.0..40_000.0).contains(&rays[0]), "{rays:?}");
    assert!((5_000.0..10_000.0).contains(&rays[3]), "{rays:?}");
    assert!((80_000.0..160_000.0).contains(&rays[4]), "{rays:?}");
    for equal_rays in [5, 7] {
        assert!((rays[equal_rays] / rays[0] - 1.0).abs() < 0.12, "{rays:?}");
    }
    // Of a lamp that rays meet by chance there is more noise.
    let noise = |row: &Value| last(row)["errors"]["flip"]["mean"].as_f64().unwrap();
    assert!(noise(&rows[7]) > 2.0 * noise(&rows[5]));
    for row in rows {
        let last = last(row);
        assert_eq!((&last["frames"], &last["asked"]), (&3.into(), &true.into()));
        for metric in ["rel_mse", "mape", "p99", "flip"] {
            let value = |key: &str| last["errors"][metric][key].as_f64().unwrap();
            assert!(value("mean") > 0.0, "{row}");
            // Two seeds: Student's t of one degree of freedom.
            let off = value("interval") - 12.706 * value("standard_error");
            assert!(off.abs() <= 1e-4 * value("interval"), "{row}");
        }
        assert!(last["milliseconds"].as_f64().unwrap() > 0.0, "{row}");
        assert!(last["seconds"]["mean"].as_f64().unwrap() > 0.0, "{row}");
        let total = last["total_rays"].as_f64().unwrap();
        assert!((total / 3.0 / last["rays"].as_f64().unwrap() - 1.0).abs() < 1e-9);
    }
    assert_eq!(last(&rows[0])["ratio"]["median"], 1.0);
    assert_eq!(last(&rows[0])["mape_ratio"]["mean"], 1.0);
    let after = || rows.iter().flat_map(|row| row["after"].as_array().unwrap());
    assert!(
        after().any(|after| after["pareto"] == true)
            && after().any(|after| after["pareto"] == false)
    );

    // Two baselines, one number of frames, two errors.
    let equal = measured["equal_error"].as_array().unwrap();
    assert_eq!(equal.len(), 4);
    for each in equal {
        assert!(each["times"]["mean"].as_f64().unwrap() > 0.0, "{each}");
        assert!(
            each["unreached"].is_u64() && each["fewer"].is_u64(),
            "{each}"
        );
    }

    let files = Folder::at(&report);
    assert!(
        files
            .read("cornell-cpu-frames.svg")
            .contains("path tracing")
    );
    assert!(
        files
            .read("cornell-cpu-front.svg")
            .contains("without sharing")
    );
    // After one, two and three frames each; path tracing may not reach a sample before the third.
    let lines = files.read("bench.csv").lines().count();
    assert!((1 + 5 * 3 + 4..=1 + 9 * 3).contains(&lines), "{lines}");
    assert_eq!(files.read("equal-error.csv").lines().count(), 1 + 4);
    assert_eq!(
        serde_json::from_str::<Value>(&files.read("bench.json")).unwrap(),
        all
    );
    assert!(files.read("bench.html").contains("without sharing"));
    // Another one's plot is noticed, this run's and files of other names are not.
    let other = ["atrium-cpu-frames.svg", "mine.svg"];
    for name in other {
        files.write(name, "<svg/>");
    }

    // The truth and its picture are kept, and found again: a second run adds nothing and finds the same.
    let kept = || std::fs::read_dir(&cache).unwrap().count();
    assert_eq!(kept(), 2);
    let again = [
        "--elements",
        "depth",
        "--seeds",
        "1",
        "--json",
        "--cache",
        &cache,
        "--report",
        &report,
    ];
    let output = gibs(&[&FEW[..], &again].concat());
    let message = stderr(&output);
    assert!(
        message.contains("has a plot or picture of an earlier run"),
        "{message}"
    );
    let again: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(again["measured"][0]["truth"], measured["truth"]);
    assert_eq!(kept(), 2);
}

/// What `gibs compare` says of the pictures is what stands in the rows.
#[test]
fn figures_are_those_of_compare() {
    let folder = Folder::new("compare");
    let (report, truth) = (folder.path("report"), folder.path("truth.exr"));
    let size = ["--size", "12x8", "--spp", "32", "--seed", "9", "--out"];
    succeed(
        &[
            &["reference", "cornell", "--backend", "cpu"],
            &size[..],
            &[&truth],
        ]
        .concat(),
    );
    let more = [
        "--elements",
        "depth",
        "--seeds",
        "1",
        "--no-cache",
        "--truth",
        &truth,
        "--pictures",
        "--report",
        &report,
        "--json",
    ];
    let all = json(&[&FEW[..], &more].concat());
    let rows = rows(&all["measured"][0]);
    let folder = std::path::Path::new(&report);
    for (file, name) in [
        ("cornell-cpu-as-set-3.exr", "as set"),
        (
            "cornell-cpu-path-tracing-equal-time-3.exr",
            "path tracing, equal time",
        ),
        (
            "cornell-cpu-brute-force-equal-time-3.exr",
            "brute force, equal time",
        ),
    ] {
        let picture = folder.join(file);
        let compared = json(&[
            "compare",
            picture.to_str().unwrap(),
            &truth,
            "--centers",
            "--json",
        ]);
        let row = rows.iter().find(|row| row["name"] == name).unwrap();
        for metric in ["rel_mse", "mape", "bias", "p99", "flip"] {
            assert_eq!(
                last(row)["errors"][metric]["mean"],
                compared["metrics"][metric],
                "{metric} of {name}"
            );
        }
    }
    // The truth that errors are of, and the one to look at.
    let own = folder.join("cornell-cpu-truth.exr");
    let same = json(&["compare", own.to_str().unwrap(), &truth, "--json"]);
    assert_eq!(same["metrics"]["rel_mse"], 0.0);
    let whole = folder.join("cornell-cpu-truth-whole.exr");
    assert_eq!(Picture::read_exr(&whole).unwrap().width, 60);
    let about = &all["measured"][0]["truth"];
    assert_eq!(about["file"], truth.as_str());
    assert_eq!(about["mask"], same["mask"]);
    let settings = &all["measured"][0]["settings"];
    assert_eq!(
        (&settings["rays"], &settings["surfels"]),
        (&20_000.into(), &8192.into())
    );
    assert!(all["measured"][0]["view"]["camera"].is_object());
}

#[test]
fn what_does_not_fit_is_refused() {
    let folder = Folder::new("refused");
    let truth = folder.path("truth.exr");
    let size = ["--size", "12x8", "--spp", "16", "--out"];
    succeed(
        &[
            &["reference", "cornell", "--backend", "cpu"],
            &size[..],
            &[&truth],
        ]
        .concat(),
    );
    let more = [
        "--elements",
        "depth",
        "--seeds",
        "1",
        "--search",
        "0",
        "--truth",
        &truth,
    ];
    let halves = ["--halves", truth.as_str(), truth.as_str()];
    let output = gibs(&[&FEW[..14], &more, &halves].concat());
    let (message, text) = (stderr(&output), stdout(&output));
    assert!(message.contains("both halves are the same"), "{message}");
    assert!(!text.contains("of whose noise alone"), "{text}");
    let text = succeed(&[&FEW[..14], &more].concat());
    assert!(text.contains("one of 25 pixels, standard error"), "{text}");
    assert!(text.contains("; errors are of "), "{text}");
    assert!(text.contains("| after 3 frames | relMSE |"), "{text}");
    assert!(text.contains("| without depth | "), "{text}");
    assert!(!text.contains("times the time"), "{text}");
    assert!(!text.contains("without sharing"), "{text}");
    let set = ["--backends", "cpu", "--size", "60x40", "--rays", "20000"];
    let few = ["--frames", "1", "--seeds", "1", "--search", "0"];
    let truth_of = ["--truth", truth.as_str()];
    let all = ["bench", "cornell", "--elements", "depth,all"];
    let text = succeed(&[&all[..], &set, &few, &truth_of].concat());
    assert!(text.contains("| after 1 frame | relMSE |"), "{text}");
    assert!(text.contains("| without sharing |"), "{text}");
    // The same truth of another scene is refused.
    refused(
        &[&["bench", "atrium"][..], &set, &few, &truth_of].concat(),
        &["truth.exr: ", "show another surface"],
    );
    refused(
        &["bench", "cornell", "atrium", "--truth", &truth],
        &["--truth", "truth.exr", "one scene"],
    );
    refused(
        &["bench", "cornell", "--size", "64x64", "--truth", &truth],
        &["truth.exr", "12x8", "64x64", "--size"],
    );
    refused(
        &["bench", "cornell", "--elements", "gravity"],
        &["--elements", "`gravity`", "sharing"],
    );
    refused(
        &["bench", "cornell", "--elements", "none,depth"],
        &["--elements", "`none` stands alone"],
    );
    refused(
        &["bench", "--backends", "cpu,abacus"],
        &["abacus", "wgpu", "all"],
    );
    refused(&["bench", "--search=-1"], &["--search", "86400"]);
    refused(&["bench", "--pictures"], &["--report"]);
    refused(
        &["bench", "cornell", "--halves", &truth, &truth],
        &["--truth"],
    );
    refused(&["bench", "--cache", "x", "--no-cache"], &["--no-cache"]);
}

/// Where no triangle and no part of the sky can be sent a ray to, both baselines trace the same paths: one is enough.
#[test]
fn brute_force_that_is_path_tracing_is_left_out() {
    let more = ["--elements", "none", "--seeds", "2", "--no-cache", "--json"];
    let all = json(&[&["bench", "window-room"], &FEW[2..], &more].concat());
    let measured = &all["measured"][0];
    assert_eq!(
        measured["same_as_path_tracing"],
        serde_json::json!(["brute force"])
    );
    let rows = rows(measured);
    let names: Vec<_> = rows.iter().filter_map(|row| row["name"].as_str()).collect();
    assert_eq!(
        names,
        [
            "as set",
            "1/4 of the rays",
            "4 x the rays",
            "path tracing, equal rays",
            "path tracing, equal time",
        ]
    );
    assert_eq!(measured["equal_error"].as_array().unwrap().len(), 2);
}

/// A dark room's truth is refused before anything is measured there; the scenes behind it are measured all the same.
#[test]
fn other_scenes_are_measured_when_one_fails() {
    let folder = Folder::new("kept");
    let report = folder.path("report");
    let more = [
        "--elements",
        "depth",
        "--seeds",
        "1",
        "--search",
        "0",
        "--no-cache",
        "--json",
        "--report",
        &report,
    ];
    let scenes = ["bench", "sealed-rooms", "cornell"];
    let output = gibs(&[&scenes, &FEW[2..14], &more].concat());
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(
        message.contains("sealed-rooms: the truth's mean luminance"),
        "{message}"
    );
    let printed: Value = serde_json::from_str(&stdout(&output)).unwrap();
    let written: Value = serde_json::from_str(&folder.read("report/bench.json")).unwrap();
    assert_eq!(printed, written);
    let measured = written["measured"].as_array().unwrap();
    assert_eq!(measured.len(), 1);
    assert_eq!(measured[0]["scene"], "cornell");
    let failed = written["failed"].as_array().unwrap();
    assert_eq!(failed.len(), 1);
    assert_eq!(failed[0]["scene"], "sealed-rooms");
    let page = folder.read("report/bench.html");
    assert!(page.contains("cornell") && page.contains("sealed-rooms"));
}
