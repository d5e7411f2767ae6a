//! The program as its users see it: exit codes, messages, files. Everything here runs on the CPU, so that it needs no
//! device.
#![cfg(feature = "cpu")]

use gibs::picture::Picture;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A folder of one test's own, gone when the test is over.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("gibs-cli-{test}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn path(&self, name: &str) -> String {
        self.0.join(name).to_str().unwrap().to_owned()
    }

    fn write(&self, name: &str, text: &str) -> String {
        std::fs::write(self.0.join(name), text).unwrap();
        self.path(name)
    }

    fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(&self.0).unwrap();
        let mut names: Vec<_> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn gibs(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_gibs"))
        .args(args)
        .output()
        .unwrap()
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// Standard output of a run that succeeds.
fn succeed(args: &[&str]) -> String {
    let output = gibs(args);
    assert_eq!(
        output.status.code(),
        Some(0),
        "{args:?}: {}",
        stderr(&output)
    );
    stdout(&output)
}

fn json(args: &[&str]) -> Value {
    let text = succeed(args);
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{args:?}: {error} in {text}"))
}

/// A run that must be refused as bad usage or bad input, with every one of `parts` in its message.
fn refused(args: &[&str], parts: &[&str]) {
    let output = gibs(args);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{args:?}: {message}");
    assert_eq!(
        stdout(&output),
        "",
        "{args:?} prints results although it failed"
    );
    assert!(message.starts_with("error: "), "{args:?}: {message}");
    assert!(!message.contains("panicked"), "{args:?}: {message}");
    for part in parts {
        assert!(
            message.contains(part),
            "{args:?}: `{part}` is not in: {message}"
        );
    }
}

/// A small render of the Cornell box on the CPU.
fn render(out: &str, more: &[&str]) -> Output {
    let args = [
        "render",
        "cornell",
        "--backend",
        "cpu",
        "--size",
        "64x64",
        "--frames",
        "2",
        "--out",
        out,
    ];
    gibs(&[&args, more].concat())
}

#[test]
fn help_and_version_are_no_failure() {
    let help = succeed(&["--help"]);
    for command in [
        "render",
        "reference",
        "compare",
        "graph",
        "profile",
        "guiding",
        "bench",
        "settings",
        "devices",
    ] {
        assert!(help.contains(command), "{command} is not in: {help}");
    }
    assert!(succeed(&["--version"]).contains(env!("CARGO_PKG_VERSION")));
    assert_eq!(gibs(&[]).status.code(), Some(2), "a command is needed");
    assert_eq!(gibs(&["bake"]).status.code(), Some(2));
}

#[test]
fn scenes_that_are_not_there_are_named_with_those_that_are() {
    refused(
        &["render", "sponge", "--backend", "cpu"],
        &["`sponge`", ".gltf", "cornell", "atrium"],
    );
    refused(&["graph", "sponge"], &["`sponge`", "cornell"]);
    refused(&["reference", "missing.gltf"], &["missing.gltf", "check"]);
}

#[test]
fn broken_scene_files_are_named() {
    let folder = Folder::new("broken");
    let broken = folder.write("broken.gltf", "{ \"asset\": ");
    refused(&["graph", &broken], &["broken.gltf"]);
    let not_a_scene = folder.write("truncated.glb", "glTF");
    refused(&["graph", &not_a_scene], &["truncated.glb"]);
    let empty = folder.write("old.gltf", "{ \"asset\": { \"version\": \"1.0\" } }");
    refused(&["graph", &empty], &["old.gltf"]);
}

#[test]
fn bad_sizes_say_what_is_taken() {
    for size in ["64", "64x", "ax64", "64x-1"] {
        refused(
            &["graph", "cornell", "--size", size],
            &[size, "width and height", "960x540"],
        );
    }
    let folder = Folder::new("size");
    let out = folder.path("a.exr");
    for size in ["0x64", "64x9000"] {
        refused(
            &[
                "render",
                "cornell",
                "--backend",
                "cpu",
                "--size",
                size,
                "--out",
                &out,
            ],
            &[size, "1 to 8192"],
        );
    }
    assert!(folder.names().is_empty(), "{:?}", folder.names());
}

#[test]
fn bad_backends_and_settings_list_what_there_is() {
    refused(
        &["render", "cornell", "--backend", "metal"],
        &["`metal`", "auto, cpu, wgpu or vulkan"],
    );
    refused(
        &["graph", "cornell", "--set", "radius"],
        &["--set", "`radius`", "KEY=VALUE"],
    );
    refused(
        &["graph", "cornell", "--set", "radios=4"],
        &["`radios`", "gibs settings"],
    );
    refused(
        &["graph", "cornell", "--set", "rays=-1"],
        &["`rays`", "`-1`", "0 to 4000000"],
    );
    refused(
        &["graph", "cornell", "--set", "depth=perhaps"],
        &["`depth`", "on or off"],
    );
    refused(
        &["graph", "cornell", "--without", "depth,gravity"],
        &["--without", "`gravity`", "depth"],
    );
    refused(
        &["render", "cornell", "--frames", "0"],
        &["--frames", "'0'"],
    );
}

#[test]
fn settings_files_are_held_to_the_same_rules() {
    let folder = Folder::new("settings");
    let graph = |file: &str| {
        let path = folder.path(file);
        gibs(&["graph", "cornell", "--settings", &path])
    };
    folder.write("good.toml", "rays = 500\ndepth = false\n");
    assert_eq!(graph("good.toml").status.code(), Some(0));
    for (file, text, part) in [
        ("key.toml", "rayz = 500", "rayz"),
        ("range.toml", "radius = 1000.0", "radius"),
        ("kind.toml", "depth = 3", "depth"),
        ("syntax.toml", "rays =", "line 1"),
    ] {
        let path = folder.write(file, text);
        refused(&["graph", "cornell", "--settings", &path], &[file, part]);
    }
    refused(
        &["graph", "cornell", "--settings", &folder.path("none.toml")],
        &["none.toml"],
    );
}

#[test]
fn view_files_that_cannot_be_used_are_named() {
    let folder = Folder::new("view");
    let missing = folder.path("none.json");
    refused(
        &["graph", "cornell", "--view", &missing],
        &["none.json", "check that the path is right"],
    );
    let broken = folder.write("broken.json", "{ \"camera\": 3 }");
    refused(
        &["graph", "cornell", "--view", &broken],
        &["broken.json", "line"],
    );
}

#[test]
fn files_that_cannot_be_written_are_known_before_any_work() {
    let folder = Folder::new("unwritable");
    let nowhere = folder.path("missing/a.exr");
    refused(
        &["render", "cornell", "--backend", "cpu", "--out", &nowhere],
        &["a.exr", "does not exist"],
    );
    refused(
        &[
            "reference",
            "cornell",
            "--backend",
            "cpu",
            "--out",
            &nowhere,
        ],
        &["a.exr", "does not exist"],
    );
    let strange = folder.path("a.bmp");
    refused(
        &["render", "cornell", "--backend", "cpu", "--out", &strange],
        &["a.bmp", ".exr", ".png"],
    );
    assert!(folder.names().is_empty(), "{:?}", folder.names());
}

#[test]
fn debug_views_are_listed_refused_and_written() {
    let help = succeed(&["render", "--help"]);
    for view in ["surfels", "coverage", "cell-heat", "depth-function"] {
        assert!(help.contains(&format!("- {view}:")), "{view}: {help}");
    }
    let folder = Folder::new("debug");
    let (exr, png) = (folder.path("a.exr"), folder.path("a.png"));
    refused(
        &["render", "cornell", "--debug", "surfel", "--out", &exr],
        &["'surfel'", "surfels, coverage", "transform-id", "guide"],
    );
    refused(
        &["render", "cornell", "--debug", "guide", "--out", &exr],
        &["`guide`", "`guiding=on`"],
    );
    refused(
        &["graph", "cornell", "--set", "debug=probes"],
        &["`probes`", "surfels, coverage"],
    );
    assert!(folder.names().is_empty(), "{:?}", folder.names());

    let seen = render(&exr, &["--debug", "radius"]);
    assert_eq!(seen.status.code(), Some(0), "{}", stderr(&seen));
    let line = "debug view radius, pixels: 0 (black) to 16 (pale yellow); here";
    assert!(stdout(&seen).contains(line), "{}", stdout(&seen));
    assert_eq!(folder.names(), ["a.exr", "a.png"]);
    let picture = Picture::read_exr(Path::new(&exr)).unwrap();
    let radii = picture.scalar("debug.radius").unwrap();
    assert!(radii.iter().any(|r| *r > 0.5) && picture.has("E.R"));
    let beside = std::fs::read(&png).unwrap();
    let alone = render(&png, &["--debug", "radius", "--json"]);
    let summary: Value = serde_json::from_str(&stdout(&alone)).unwrap();
    assert_eq!(summary["debug"]["view"], "radius");
    assert_eq!(summary["debug"]["scale"]["heat"], 16.0);
    assert_eq!(std::fs::read(&png).unwrap(), beside);
    let graph = succeed(&["graph", "cornell", "--set", "debug=grid"]);
    assert!(graph.contains("debug/surface"), "{graph}");
    assert!(!succeed(&["graph", "cornell"]).contains("debug/"));
}

#[test]
fn guiding_is_measured_under_environments() {
    let folder = Folder::new("guiding");
    let report = folder.path("report");
    let few = [
        "--backend",
        "cpu",
        "--probes",
        "4",
        "--seeds",
        "2",
        "--rays",
        "64",
    ];
    let args = [
        &["guiding", "sun", "overcast", "--json", "--report", &report],
        &few[..],
    ]
    .concat();
    let all = json(&args);
    assert_eq!(all.as_array().unwrap().len(), 2);
    let rows = all[0]["rows"].as_array().unwrap();
    let rays: Vec<u64> = rows
        .iter()
        .map(|row| row["rays"].as_u64().unwrap())
        .collect();
    assert_eq!(rays, [8, 16, 32, 64]);
    assert!(
        rows.iter()
            .all(|row| row["guided"]["error"].as_f64().unwrap() > 0.0)
    );
    for name in ["sun.svg", "overcast.svg"] {
        let svg = std::fs::read_to_string(Path::new(&report).join(name)).unwrap();
        assert!(
            svg.starts_with("<svg") && svg.ends_with("</svg>\n"),
            "{svg}"
        );
    }
    let csv = std::fs::read_to_string(Path::new(&report).join("guiding.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + 2 * 4);

    let text = succeed(&[&["guiding", "windows"], &few[..]].concat());
    assert!(
        text.contains("windows on cpu: 4 probes") && text.contains(" % +- "),
        "{text}"
    );
}

#[test]
fn environments_that_cannot_be_read_are_refused() {
    let folder = Folder::new("environments");
    let broken = folder.write("broken.hdr", "#?RADIANCE\n\n-Y nothing");
    let missing = folder.path("missing.hdr");
    refused(&["guiding", "nowhere"], &["nowhere", "windows", "sun"]);
    refused(&["guiding", &missing], &["missing.hdr", "cannot read"]);
    refused(
        &["guiding", "sun", &broken],
        &["broken.hdr", "save it again"],
    );
    let text = folder.write("sky.txt", "blue");
    refused(&["guiding", &text], &["sky.txt", ".hdr"]);
    refused(
        &["guiding", "sun", "--backend", "cpu", "--report", &text],
        &["sky.txt", "is not a folder"],
    );
    refused(&["guiding"], &["ENV"]);
}

#[test]
fn settings_are_listed_with_range_and_meaning() {
    let all = json(&["settings", "--json"]);
    let all = all.as_array().unwrap();
    assert!(!all.is_empty());
    for setting in all {
        let number = |key: &str| setting[key].as_f64().unwrap();
        assert!(
            number("least") <= number("default") && number("default") <= number("most"),
            "{setting}"
        );
        assert!(!setting["about"].as_str().unwrap().is_empty(), "{setting}");
    }
    let text = succeed(&["settings"]);
    for setting in all {
        let name = setting["name"].as_str().unwrap();
        assert!(
            text.lines().any(|line| line.starts_with(name)),
            "{name} is not in: {text}"
        );
    }
}

#[test]
fn devices_always_include_the_processor() {
    let all = json(&["devices", "--json"]);
    let cpu = all
        .as_array()
        .unwrap()
        .iter()
        .find(|e| e["backend"] == "cpu");
    let devices = cpu.unwrap()["devices"].as_array().unwrap();
    assert_eq!(devices[0]["kind"], "cpu");
    assert!(succeed(&["devices"]).contains("auto picks"));
}

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

#[test]
fn a_render_writes_its_channels_a_preview_and_a_summary() {
    let folder = Folder::new("render");
    let out = folder.path("box.exr");
    let output = render(&out, &["--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let summary: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(summary["backend"], "cpu");
    assert_eq!(summary["size"], serde_json::json!([64, 64]));
    assert_eq!(summary["frames"], 2);
    assert_eq!(summary["out"], out.as_str());
    assert!(summary["surfels"].as_u64().unwrap() > 0, "{summary}");
    assert!(summary["bytes"].as_u64().unwrap() > 0, "{summary}");

    assert_eq!(folder.names(), ["box.exr", "box.png"]);
    let picture = Picture::read_exr(Path::new(&out)).unwrap();
    assert_eq!([picture.width, picture.height], [64, 64]);
    for channel in [
        "R",
        "G",
        "B",
        "E.R",
        "direct.R",
        "indirect.G",
        "albedo.B",
        "normal.X",
        "position.Y",
        "depth.Z",
        "mask.A",
    ] {
        let values = picture.scalar(channel).unwrap();
        assert!(values.iter().all(|v| v.is_finite()), "{channel}");
    }
    assert!(picture.scalar("E.R").unwrap().iter().any(|&v| v > 0.0));
    let preview = image::image_dimensions(folder.path("box.png")).unwrap();
    assert_eq!(preview, (64, 64));
}

#[test]
fn a_pipe_sees_no_progress_bar() {
    let folder = Folder::new("pipe");
    let output = render(&folder.path("box.png"), &[]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    for text in [stdout(&output), stderr(&output)] {
        let odd = text.chars().find(|c| c.is_control() && *c != '\n');
        assert_eq!(odd, None, "{text:?}");
        assert!(!text.contains('█') && !text.contains('░'), "{text:?}");
    }
    assert!(stdout(&output).contains("2 frames of 64x64"));
    assert_eq!(folder.names(), ["box.png"]);
}

#[test]
fn the_same_seed_gives_the_same_bits() {
    let folder = Folder::new("seed");
    let picture = |name: &str, seed: &str| {
        let out = folder.path(name);
        let output = render(&out, &["--seed", seed]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        Picture::read_exr(Path::new(&out)).unwrap()
    };
    let (first, again, other) = (
        picture("a.exr", "1"),
        picture("b.exr", "1"),
        picture("c.exr", "2"),
    );
    let bits = |p: &Picture, channel: &str| -> Vec<u32> {
        let values = p.scalar(channel).unwrap();
        values.iter().map(|v| v.to_bits()).collect()
    };
    for channel in first.channels.keys() {
        assert_eq!(bits(&first, channel), bits(&again, channel), "{channel}");
    }
    assert_ne!(bits(&first, "E.R"), bits(&other, "E.R"));
}

#[test]
fn a_reference_says_how_certain_it_is_and_judges_a_render() {
    let folder = Folder::new("reference");
    let truth = folder.path("truth.exr");
    let args = [
        "reference",
        "cornell",
        "--backend",
        "cpu",
        "--size",
        "16x16",
        "--spp",
        "4",
        "--out",
        &truth,
        "--json",
    ];
    let certainty = json(&args);
    assert_eq!(certainty["samples"], 4);
    assert!(
        certainty["standard_error"].as_f64().unwrap() > 0.0,
        "{certainty}"
    );
    let picture = Picture::read_exr(Path::new(&truth)).unwrap();
    assert!(picture.scalar("E.G").unwrap().iter().any(|&v| v > 0.0));

    // Our picture has four times the size, so cells of 4x4 pixels are averaged.
    let ours = folder.path("ours.exr");
    let output = render(&ours, &[]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let heat = folder.path("heat.png");
    let report = json(&["compare", &ours, &truth, "--out", &heat, "--json"]);
    assert_eq!(report["averaged"], 4);
    assert!(report["metrics"]["rel_mse"].as_f64().unwrap() > 0.0);
    assert_eq!(image::image_dimensions(&heat).unwrap(), (16, 16));
}

#[test]
fn a_picture_has_no_error_against_itself() {
    let folder = Folder::new("self");
    let out = folder.path("box.exr");
    let output = render(&out, &[]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    for channel in ["E", "RGB", "indirect"] {
        let report = json(&["compare", &out, &out, "--channel", channel, "--json"]);
        for metric in [
            "rel_mse",
            "rmse",
            "mape",
            "bias",
            "p99",
            "block_error",
            "flip",
        ] {
            assert_eq!(report["metrics"][metric], 0.0, "{channel} {metric}");
        }
    }
    refused(
        &["compare", &folder.path("none.exr"), &out],
        &["none.exr", "no such file"],
    );
    refused(
        &["compare", &out, &folder.path("box.png")],
        &["box.png", "not an OpenEXR file"],
    );
    refused(
        &["compare", &out, &out, "--channel", "velocity"],
        &["velocity", "E.R"],
    );
}

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
        assert_eq!(run["budget"], budget);
        assert_eq!(run["totals"]["slot_errors"], 0);
        let rows = run["rows"].as_array().unwrap();
        assert_eq!(rows.len(), 12);
        let error = |row: &Value| row["error"].as_f64().unwrap();
        // Against the last frame, which thus has none.
        assert!(error(&rows[0]) > error(&rows[10]) && rows[11]["error"].is_null());
        assert!(rows[1..].iter().all(|row| row["rays"] == budget));
        let frames = run["converged"]["frames"].as_u64().unwrap() as usize;
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
    let names = Folder(folder.0.join("out")).names();
    assert_eq!(
        names,
        ["cost-2000.svg", "cost-500.svg", "error.svg", "stress.csv"]
    );
}

#[test]
fn a_truth_of_another_size_is_refused_by_a_stress_test() {
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
    let stress = |size: &'static str| {
        vec![
            "stress",
            "cornell",
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
    // Three times as large: the centres of the truth's pixels.
    let text = succeed(&stress("96x96"));
    assert!(text.contains("not converged after 2 frames"), "{text}");
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
    let names = Folder(folder.0.join("out")).names();
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
