//! The command `replay`: captures of a check in which all agree, and files that are none.
use crate::program::{code, gibs, text};
use gibs::check::Capture;
use std::path::{Path, PathBuf};
use std::process::Output;

/// A folder of its own for each test.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).expect("a folder");
    folder
}

fn replay(file: &Path, more: &[&str]) -> Output {
    let file = file.to_str().expect("a name");
    gibs(&[&["replay", file, "--backend", "cpu", "--runs", "2"], more].concat())
}

/// A capture of a stage that a check has written.
fn captured(folder: &Path, stage: &str) -> PathBuf {
    let output = gibs(&[
        "check",
        "cornell",
        "--backends",
        "cpu-scalar,cpu",
        "--frames",
        "1",
        "--size",
        "16x9",
        "--stage",
        stage,
        "--capture",
        stage,
        "--json",
        "--report",
        folder.to_str().expect("a name"),
    ]);
    assert_eq!(code(&output), Some(0), "{}", text(&output.stderr));
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let files = summary["captures"].as_array().expect("captures");
    PathBuf::from(files[0].as_str().expect("a path"))
}

#[test]
fn what_a_check_captures_can_be_replayed() {
    let file = captured(&folder("replay-captured"), "GapFill");
    let output = replay(&file, &["--json"]);
    assert_eq!(code(&output), Some(0), "{}", text(&output.stderr));
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(
        (&summary["stage"], &summary["verdict"]),
        (&"GapFill".into(), &"equal".into())
    );
    assert_eq!(summary["passed"], true);
    let said = text(&replay(&file, &[]).stdout);
    let last = said.lines().last().expect("something");
    assert!(
        last.starts_with("passed: the bits that cpu-scalar made"),
        "{last}"
    );
    // Where they go has to be said.
    let output = gibs(&["check", "cornell", "--capture", "GapFill"]);
    assert_eq!(code(&output), Some(2));
    assert!(text(&output.stderr).contains("--report"));
}

/// Each error names the file and what can be done.
#[test]
fn files_that_cannot_be_replayed_are_named_with_a_remedy() {
    let folder = folder("replay-refused");
    let refused = |file: &Path, parts: &[&str]| {
        let output = replay(file, &[]);
        assert_eq!(code(&output), Some(2));
        let said = text(&output.stderr);
        let name = file.file_name().unwrap_or(file.as_os_str());
        let name = name.to_str().expect("a name");
        assert!(said.contains(name), "{said}");
        for part in parts {
            assert!(said.contains(part), "{said}");
        }
    };
    refused(
        &folder.join("missing.npz"),
        &["cannot be read", "gibs check --report"],
    );
    refused(&folder, &["is a folder", ".npz"]);
    let sound = Capture::read(&captured(&folder, "GapFill")).expect("a capture");
    let file = folder.join("changed.npz");
    let write = |change: &dyn Fn(&mut Capture)| {
        let mut capture = sound.clone();
        change(&mut capture);
        capture.write(&file).expect("written");
    };
    write(&|capture| capture.stage = "Nope".into());
    refused(&file, &["`Nope`", "the program that wrote it"]);
    write(&|capture| capture.bindings[0].port = "other".into());
    refused(&file, &["`GapFill`", "--capture GapFill"]);
    // Nothing was compared, so nothing has passed.
    write(&|capture| capture.results.clear());
    refused(&file, &["no results", "nothing was checked"]);
    let json = replay(&file, &["--json"]).stdout;
    let json: serde_json::Value = serde_json::from_slice(&json).expect("JSON");
    assert_eq!(
        (&json["verdict"], &json["passed"]),
        (&"unchecked".into(), &false.into())
    );
}

/// A file cannot make the terminal do things.
#[test]
fn names_of_a_capture_reach_the_terminal_as_text() {
    let folder = folder("replay-names");
    let mut capture = Capture::read(&captured(&folder, "GapFill")).expect("a capture");
    capture.label = "\u{1b}[2Jstep".into();
    capture.case = "case\u{7}".into();
    capture.results[0].device = "\u{9b}31mdevice".into();
    let file = folder.join("names.npz");
    capture.write(&file).expect("written");
    let shows = || {
        let output = replay(&file, &[]);
        let said = text(&output.stdout) + &text(&output.stderr);
        assert!(!said.contains(['\u{1b}', '\u{7}', '\u{9b}']), "{said:?}");
        said
    };
    assert!(shows().contains("\\u{1b}[2Jstep"));
    capture.stage = "\u{1b}[2J".into();
    capture.write(&file).expect("written");
    assert!(shows().contains("\\u{1b}[2J"));
}

/// The scalar kernel walks one tree and the wide one another. Where the triangles of one are gone the two differ, which is a
/// failure however well the backend does what the capture holds; where the other is full of zeros, kernels panic, which is told
/// as an error of the stage alone.
#[test]
fn a_difference_is_reduced_and_fails() {
    let folder = folder("replay-reduced");
    let whole = captured(&folder, "TraceClosest");
    let mut capture = Capture::read(&whole).expect("a capture");
    let triangles = capture
        .buffers
        .iter_mut()
        .find(|buffer| buffer.key == "scene_triangles");
    triangles.expect("the scalar kernel's").bytes.fill(0);
    let file = folder.join("parted.npz");
    capture.write(&file).expect("written");
    let reduced = folder.join("smaller.npz");
    let more = ["--tries", "60", "--json", "--reduce"];
    let output = replay(
        &file,
        &[&more[..], &[reduced.to_str().expect("a name")]].concat(),
    );
    let error = text(&output.stderr);
    assert_eq!(code(&output), Some(1), "{error}");
    assert!(
        error.contains("cpu-scalar") && error.contains("smaller.npz"),
        "{error}"
    );
    assert!(!error.contains("panicked"), "{error}");
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(
        (&summary["verdict"], &summary["passed"]),
        (&"differs".into(), &false.into())
    );
    let bytes = |key: &str| summary["reduced"][key].as_u64().expect("a number");
    assert!(bytes("nonzero_bytes_after") < bytes("nonzero_bytes_before"));
    // What is left shows it.
    assert_eq!(code(&replay(&reduced, &[])), Some(1));

    let before = std::fs::read(&file).expect("there");
    let output = replay(&file, &["--reduce", file.to_str().expect("a name")]);
    assert_eq!(code(&output), Some(2));
    assert!(text(&output.stderr).contains("the capture itself"));
    assert!(std::fs::read(&file).expect("there") == before);
    // The first captures were of another report.
    let said = text(
        &gibs(&[
            "check",
            "cornell",
            "--backends",
            "cpu-scalar,cpu",
            "--frames",
            "1",
            "--stage",
            "GapFill",
            "--report",
            folder.to_str().expect("a name"),
        ])
        .stderr,
    );
    assert!(said.contains("not of this report"), "{said}");
}
