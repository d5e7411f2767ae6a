//! What `gibs check` says agrees with how it exits, in text, JSON and HTML.
use crate::common::cpu;
use crate::program::{code, gibs, text};
use crate::sabotage::{How, Sabotaged};
use gibs::builtin;
use gibs::check::{
    CheckError, CheckOptions, Checked, Expectation, Expectations, NotRun, Participant, Summary,
    Verdict, check, html, surfels,
};
use gibs::passes::frame::Settings;
use gibs_backend_cpu::{CpuBackend, Options};
use std::path::{Path, PathBuf};

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

/// A short check of one stage.
const SHORT: [&str; 10] = [
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
];

/// Two participants on a small frame; `how` is what the second does to the colours that `Compose` writes.
fn checked(how: How, capture: Option<&str>) -> Result<Checked, CheckError> {
    let options = Options {
        scalar: true,
        ..Options::default()
    };
    let oracle = CpuBackend::new(options).expect("threads start");
    let other = Sabotaged {
        inner: cpu(),
        stage: "Compose",
        port: "color",
        from: 1,
        how,
    };
    let settings = Settings {
        surfels: 256,
        rays: 256,
        ..Settings::default()
    };
    let scene = builtin::by_name("cornell").expect("built in");
    let case = surfels("cornell", &scene, [48, 27], 0..2, &settings).expect("a frame");
    let participants = [
        Participant::named("cpu-scalar", &oracle),
        Participant::new(&other),
    ];
    let options = CheckOptions {
        captures: 1,
        capture: capture.map(str::to_owned),
        captured: 3,
        ..CheckOptions::default()
    };
    check(&mut [case], &participants, &options, |_, _, _| {})
}

fn nan(bytes: &mut [u8]) {
    bytes[..4].copy_from_slice(&f32::NAN.to_ne_bytes());
}

/// Nothing differs, and still the check has failed.
#[test]
fn an_unmet_expectation_fails_in_every_form() {
    let folder = folder("check-unmet");
    std::fs::create_dir_all(&folder).expect("a folder");
    let list = folder.join("expected.toml");
    let entry = "[[expected]]\ndevice = \"gibs\"\nstage = \"GapFill\"\nreason = \"a test\"\n";
    std::fs::write(&list, entry).expect("written");
    let [folder, list] = [&folder, &list].map(|path| path.to_str().expect("a name"));
    let more = ["--expectations", list, "--report", folder];
    let output = gibs(&[&SHORT[..], &more].concat());
    assert_eq!(code(&output), Some(1), "{}", text(&output.stderr));
    let said = text(&output.stdout);
    let last = said.lines().last().expect("something");
    assert!(last.starts_with("failed: 1 expected difference"), "{last}");
    let page = std::fs::read_to_string(Path::new(folder).join("report.html")).expect("written");
    assert!(page.contains("<title>gibs check: failed</title>"));
    assert!(page.contains("is expected to differ and did not: a test"));
    let json = std::fs::read(Path::new(folder).join("report.json")).expect("written");
    let json: serde_json::Value = serde_json::from_slice(&json).expect("JSON");
    assert_eq!(json["passed"], false);
    assert_eq!(json["verdict"], "equal");

    let output = gibs(&SHORT);
    assert_eq!(code(&output), Some(0));
    let said = text(&output.stdout);
    let last = said.lines().last().expect("something");
    assert!(last.starts_with("passed, equal"), "{last}");
}

/// A line for each port of each stage, though all is equal.
#[test]
fn the_text_has_a_table_of_all_ports() {
    let output = gibs(&SHORT);
    let said = text(&output.stdout);
    let rows: Vec<_> = said.lines().filter(|l| l.starts_with("GapFill")).collect();
    assert!(!rows.is_empty(), "{said}");
    for row in &rows {
        assert!(row.contains("equal"), "{row}");
    }
    let ports: std::collections::BTreeSet<_> = rows
        .iter()
        .map(|row| row.split_whitespace().nth(1))
        .collect();
    assert_eq!(ports.len(), rows.len(), "each port has one line: {said}");
    assert!(
        said.lines()
            .any(|l| l.starts_with("stage") && l.contains("comparator"))
    );
}

#[test]
fn the_table_says_what_is_worst_and_where() {
    let checked = checked(How::Damage(nan), None).expect("it runs");
    let summary = Summary::new(&checked.report, &[], &[]);
    assert!(!summary.passed);
    assert_eq!(summary.headline(), "failed: 1 comparison differs");
    let differs: Vec<_> = summary
        .table
        .iter()
        .filter(|row| row.verdict == Verdict::Differs)
        .collect();
    let [row] = &differs[..] else {
        panic!("{differs:?}");
    };
    assert_eq!(
        (row.stage.as_str(), row.port.as_str()),
        ("Compose", "color")
    );
    let worst = row.worst.as_ref().expect("a number");
    assert_eq!((worst.case.as_str(), worst.frame), ("cornell", 1));
    assert!(worst.place().contains("frame 1, [0]"), "{}", worst.place());
    let page = html(&summary, &checked.captures, [48, 27]);
    // The type name is what expectations ask for.
    assert!(page.contains("<code>TraceClosest</code>"));
    assert!(page.contains("relative inf"));
}

/// A page does not look sound because what it would have said did not run.
#[test]
fn what_did_not_run_is_on_the_page() {
    let checked = checked(How::Damage(|_| {}), None).expect("it runs");
    let (a, b) = (cpu(), cpu());
    let others = [Participant::new(a.as_ref()), Participant::new(b.as_ref())];
    let gaps = checked.report.gaps(&[], &others);
    let missing = [NotRun {
        name: "vulkan".into(),
        reason: "no <driver>".into(),
    }];
    let summary = Summary {
        not_run: &missing,
        stages_not_run: &["NeverRun"],
        ..Summary::new(&checked.report, &[], &[])
    };
    assert!(summary.passed);
    let line = "passed, equal: 1 participant not run, 1 stage in no case";
    assert_eq!(summary.headline(), line);
    let page = html(&summary, &[], [48, 27]);
    for said in [line, "no &lt;driver&gt;", "NeverRun"] {
        assert!(page.contains(said), "{said}");
    }
    let summary = Summary::new(&checked.report, &gaps, &[]);
    assert!(!summary.passed);
    let page = html(&summary, &[], [48, 27]);
    assert!(page.contains("not looked at: ") && page.contains("gibs check: failed"));
}

/// `cpu` is not `cpu-scalar`, and neither is a part of either.
#[test]
fn expectations_name_whole_participants() {
    let found = checked(How::Damage(nan), None).expect("it runs").report;
    let verdict = |backend: Option<&str>, device: &str| {
        let list = Expectations {
            expected: vec![Expectation {
                device: device.into(),
                backend: backend.map(str::to_owned),
                stage: "Compose".into(),
                port: None,
                reason: "a test".into(),
            }],
        };
        let mut report = found.clone();
        list.apply(&mut report);
        report.verdict()
    };
    for backend in [None, Some("cpu"), Some("cpu-scalar")] {
        assert_eq!(verdict(backend, "gibs"), Verdict::Expected, "{backend:?}");
    }
    for backend in ["", "c", "cpu-", "cpu-scalar-2"] {
        assert_eq!(
            verdict(Some(backend), "gibs"),
            Verdict::Differs,
            "{backend}"
        );
    }
    assert_eq!(verdict(None, ""), Verdict::Differs);
}

#[test]
fn steps_are_captured_where_all_agree_too() {
    let checked = checked(How::Damage(|_| {}), Some("Compose")).expect("it runs");
    assert!(checked.captures.is_empty());
    let frames: Vec<_> = checked
        .asked
        .iter()
        .map(|c| (c.stage.as_str(), c.frame))
        .collect();
    assert_eq!(frames, [("Compose", 0), ("Compose", 1)]);
    assert!(checked.asked.iter().all(|c| c.results.len() == 2));
    assert!(!checked.asked_more);
    let all = self::checked(How::Damage(nan), Some("")).expect("it runs");
    assert_eq!(all.asked.len(), 3);
    assert!(all.asked_more);
    assert_eq!(all.captures.len(), 1, "differences have room of their own");
}

#[test]
fn a_name_that_no_step_has_brings_those_that_come_near() {
    let error = checked(How::Skip, Some("gapfil")).expect_err("no such step");
    let said = error.to_string();
    assert!(said.contains("`GapFill`"), "{said}");
    let output = gibs(&[
        "check",
        "--backends",
        "cpu-scalar,cpu",
        "--stage",
        "Nonsense",
    ]);
    assert_eq!(code(&output), Some(2));
    let said = text(&output.stderr);
    assert!(
        said.contains("Nonsense") && said.contains("gibs graph"),
        "{said}"
    );
    assert!(said.len() < 300, "{said}");
}

/// A list of as many frames would not fit into memory.
#[test]
fn frames_have_a_range() {
    for command in [
        &["check", "cornell", "--frames", "4294967295"][..],
        &[
            "bisect",
            "cornell",
            "--a",
            "cpu",
            "--b",
            "cpu-scalar",
            "--frames",
            "65537",
        ],
    ] {
        let output = gibs(command);
        assert_eq!(code(&output), Some(2));
        let said = text(&output.stderr);
        assert!(
            said.contains("--frames") && said.contains("1..=65536"),
            "{said}"
        );
    }
}

/// It is the promise of the documentation that a backend is that small.
#[test]
fn the_backend_of_the_documentation_is_short() {
    let example = include_str!("../../examples/custom_backend.rs");
    assert!(example.lines().count() < 300);
}
