//! The commands `check`, `bisect` and `replay`.
use crate::common::{all_backends, is_strict};
use gibs::check::Capture;
use std::path::Path;
use std::process::{Command, Output};

pub fn gibs(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gibs"));
    command.args(arguments).output().expect("it starts")
}

pub fn code(output: &Output) -> Option<i32> {
    output.status.code()
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn check_passes_and_writes_its_report() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("check-report");
    let folder = folder.to_str().expect("a name");
    let output = gibs(&[
        "check",
        "cornell",
        "--backends",
        "cpu-scalar,cpu",
        "--frames",
        "1",
        "--report",
        folder,
        "--json",
    ]);
    assert_eq!(code(&output), Some(0), "{}", text(&output.stderr));
    let summary: serde_json::Value =
        serde_json::from_slice(&output.stdout).expect("JSON and nothing else");
    assert_eq!(summary["verdict"], "equal");
    assert_eq!(summary["passed"], true);
    assert_eq!(summary["gaps"].as_array().map(Vec::len), Some(0));
    let html = std::fs::read_to_string(Path::new(folder).join("report.html")).expect("written");
    assert!(html.contains("gibs check") && html.contains("cpu-scalar"));
    // Nothing is loaded from elsewhere.
    assert!(!html.contains("http://") && !html.contains("https://") && !html.contains("<script"));
    let json = std::fs::read(Path::new(folder).join("report.json")).expect("written");
    let written: serde_json::Value = serde_json::from_slice(&json).expect("JSON");
    assert_eq!(written["report"]["lanes"], summary["report"]["lanes"]);
}

/// Every kernel of a frame, some of which leave bindings out.
#[test]
fn vulkan_and_wgpu_agree_on_the_same_words() {
    let backends = all_backends();
    let is_there = |name| backends.iter().any(|b| b.name() == name);
    if !is_there("vulkan") || !is_there("wgpu") {
        println!("not run: vulkan and wgpu are not both there");
        return;
    }
    let output = gibs(&[
        "check",
        "cornell",
        "--same-spirv",
        "--backends",
        "vulkan,wgpu",
        "--frames",
        "3",
        "--json",
    ]);
    assert_eq!(code(&output), Some(0), "{}", text(&output.stderr));
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    if let Some(missing) = summary["not_run"].as_array().and_then(|list| list.first()) {
        assert!(!is_strict(), "not run: {missing}");
        println!("not run: {missing}");
        return;
    }
    let pair = &summary["report"]["cases"][0]["steps"][0]["ports"][0]["pairs"][0];
    assert_eq!(pair["exact"], true, "{pair}");
}

#[test]
fn a_part_of_the_frame_can_be_checked() {
    let part = [
        "check",
        "cornell",
        "--backends",
        "cpu-scalar,cpu",
        "--frames",
        "1",
        "--stage",
    ];
    let output = gibs(&[&part[..], &["Integrate", "--json"]].concat());
    assert_eq!(code(&output), Some(0), "{}", text(&output.stderr));
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let steps = summary["report"]["cases"][0]["steps"]
        .as_array()
        .expect("steps");
    assert!(steps.iter().all(|step| step["stage"] == "Integrate") && !steps.is_empty());
    let output = gibs(&[&part[..], &["NoSuchStage"]].concat());
    assert_eq!(code(&output), Some(2));
    assert!(text(&output.stderr).contains("NoSuchStage"));
}

#[test]
fn what_cannot_be_compared_is_refused() {
    for (backends, said) in [
        ("cpu", "two backends or more"),
        ("cpu,cpu", "same backend"),
        ("cpu,metal", "choose of"),
    ] {
        let output = gibs(&["check", "cornell", "--backends", backends]);
        assert_eq!(code(&output), Some(2), "{backends}");
        let error = text(&output.stderr);
        assert!(error.contains(said), "{backends}: {error}");
    }
    let output = gibs(&["check", "nowhere.gltf", "--backends", "cpu-scalar,cpu"]);
    assert_eq!(code(&output), Some(2));
    for (options, said) in [
        (["--same-spirv", "--backends", "cpu,vulkan"], "name both"),
        (["--backends", "cpu-scalar,cpu", "--stage="], "--stage"),
    ] {
        let output = gibs(&[&["check", "cornell"], &options[..]].concat());
        assert_eq!(code(&output), Some(2), "{options:?}");
        let error = text(&output.stderr);
        assert!(error.contains(said), "{options:?}: {error}");
    }
    // Before any frame is run, and so before it is known whether there is anything to capture.
    let nowhere = Path::new(env!("CARGO_TARGET_TMPDIR")).join("no-such-folder/parted.npz");
    let out = nowhere.to_str().expect("a name");
    let both = ["--a", "cpu-scalar", "--b", "cpu", "--frames", "1"];
    let output = gibs(&[&["bisect", "cornell", "--out", out], &both[..]].concat());
    assert_eq!(code(&output), Some(2));
    assert!(text(&output.stderr).contains("no-such-folder"));
}

/// A list of expected differences that do not come fails the check.
#[test]
fn expectations_that_are_not_met_fail() {
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("expectations.toml");
    let check = |list: &str| {
        std::fs::write(&file, list).expect("written");
        gibs(&[
            "check",
            "cornell",
            "--backends",
            "cpu-scalar,cpu",
            "--frames",
            "1",
            "--expectations",
            file.to_str().expect("a name"),
        ])
    };
    // Every processor's driver is this program.
    let output =
        check("[[expected]]\ndevice = \"gibs\"\nstage = \"Compose\"\nreason = \"a test\"\n");
    assert_eq!(code(&output), Some(1));
    assert!(
        text(&output.stderr).contains("did not: a test"),
        "{}",
        text(&output.stderr)
    );
    let output =
        check("[[expected]]\ndevice = \"other\"\nstage = \"Compose\"\nreason = \"a test\"\n");
    assert_eq!(code(&output), Some(0));
    let output = check("[[expected]]\nstage = \"Compose\"\n");
    assert_eq!(code(&output), Some(2));
    assert!(text(&output.stderr).contains("expectations.toml"));
}

#[test]
fn bisect_says_that_backends_agree() {
    let output = gibs(&[
        "bisect",
        "cornell",
        "--a",
        "cpu-scalar",
        "--b",
        "cpu",
        "--frames",
        "3",
        "--size",
        "48x27",
        "--rays",
        "500",
    ]);
    assert_eq!(code(&output), Some(0), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("agree over 3 frames"));
}

/// The file says itself which stage it is of; another one's capture is refused.
#[test]
fn replay_refuses_what_is_no_capture() {
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("no-capture.npz");
    std::fs::write(&file, b"nothing").expect("written");
    let output = gibs(&["replay", file.to_str().expect("a name"), "--backend", "cpu"]);
    assert_eq!(code(&output), Some(2));
    assert!(text(&output.stderr).contains("no capture"));
    assert!(Capture::read(&file).is_err());
}

/// A list that names what there is not would never be found wrong.
#[test]
fn expectations_name_what_there_is() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("check-expectations");
    std::fs::create_dir_all(&folder).expect("a folder");
    let file = folder.join("expected.toml");
    let check = |list: &str| {
        std::fs::write(&file, list).expect("written");
        gibs(&[
            "check",
            "cornell",
            "--stage",
            "gap_fill",
            "--frames",
            "1",
            "--size",
            "16x9",
            "--backends",
            "cpu-scalar,cpu",
            "--json",
            "--expectations",
            file.to_str().expect("a name"),
        ])
    };
    let entry = |device: &str, stage: &str, more: &str| {
        format!(
            "[[expected]]\ndevice = \"{device}\"\nstage = \"{stage}\"\nreason = \"a test\"\n{more}"
        )
    };
    for (list, problem) in [
        (entry("", "GapFill", ""), "`device` is empty"),
        (
            entry("x", "gap_fill", ""),
            "no stage has the type name `gap_fill`",
        ),
        (
            entry("x", "GapFill", "port = \"points\""),
            "writes no port `points`",
        ),
        (
            entry("x", "GapFill", "backend = \"cuda\""),
            "no participant is called `cuda`",
        ),
        (
            entry("x", "GapFill", "backend = \"c\""),
            "no participant is called `c`: choose of cpu-scalar, cpu",
        ),
        (
            entry("x", "GapFill", "backend = \"\""),
            "no participant is called ``",
        ),
    ] {
        let output = check(&list);
        assert_eq!(code(&output), Some(2), "{problem}");
        let said = text(&output.stderr);
        assert!(said.contains(problem), "{said}");
    }
    let output = check(&entry("gibs", "GapFill", ""));
    assert_eq!(code(&output), Some(1), "what is expected does not come");
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(summary["unmet"][0]["stage"], "GapFill");
}
