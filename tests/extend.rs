//! The examples of `docs/extending.md` build, run and find what they claim.
#![cfg(feature = "cpu")]
mod common;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// The workspace's own build folder: its dependencies are those of the examples, and so compiled once.
fn target() -> PathBuf {
    let temporary = Path::new(env!("CARGO_TARGET_TMPDIR"));
    temporary.parent().expect("cargo makes it in there").into()
}

/// What `cargo run` printed and how it ended; cargo's own words where it did not end well.
fn cargo_run(arguments: &[&str]) -> String {
    let Output {
        status,
        stdout,
        stderr,
    } = Command::new(env!("CARGO"))
        .args(["run", "--release", "--locked"])
        .args(arguments)
        .current_dir(ROOT)
        .env("CARGO_TARGET_DIR", target())
        .output()
        .expect("cargo starts");
    let stdout = String::from_utf8_lossy(&stdout).into_owned();
    assert!(
        status.success(),
        "{status}\n{stdout}\n{}",
        String::from_utf8_lossy(&stderr)
    );
    stdout
}

/// A crate outside the workspace adds stages to the frame, on every backend that this machine has.
#[test]
fn a_crate_outside_adds_stages() {
    let manifest = ["--manifest-path", "examples/custom_stage/Cargo.toml"];
    let said = cargo_run(&manifest);
    print!("{said}");
    assert!(said.ends_with("agrees\n"), "{said}");
    for backend in common::all_backends() {
        let ran = format!("{}: exposure ", backend.name());
        assert!(said.contains(&ran), "not on {}", backend.name());
    }
}

/// A backend made from what `gibs-graph` has gives the CPU backend's bits.
#[test]
fn a_backend_outside_gives_the_same_bits() {
    let said = cargo_run(&["--example", "custom_backend"]);
    print!("{said}");
    assert!(said.contains("color: equal to the bit"), "{said}");
    assert!(!said.contains("DIFFERS"), "{said}");
}
