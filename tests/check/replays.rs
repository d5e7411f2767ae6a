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

/// A capture that a check has written.
fn captured(folder: &Path) -> PathBuf {
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
        "GapFill",
        "--capture",
        "GapFill",
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
    let file = captured(&folder("replay-captured"));
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
    let sound = Capture::read(&captured(&folder)).expect("a capture");
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
    let mut capture = Capture::read(&captured(&folder)).expect("a capture");
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
