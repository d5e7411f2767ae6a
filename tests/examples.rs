//! The examples of engines, run as the programs that they are.
#![cfg(all(feature = "cpu", feature = "wgpu", feature = "vulkan"))]
use gibs::backends::{self, Choice};
use gibs::graph::{Backend, BackendError};
use gibs_backend_vulkan::{Options, VulkanBackend};
use std::path::PathBuf;
use std::process::Command;

/// Whether the machine has something. Where it does not, that is a failure under `GIBS_STRICT=1`, and else reported.
fn has<T>(name: &str, opened: Result<T, BackendError>) -> bool {
    match opened {
        Ok(_) => true,
        Err(error) if std::env::var_os("GIBS_STRICT").is_some_and(|v| v == "1") => {
            panic!("{name}: {error}")
        }
        Err(error) => {
            eprintln!("{name} not run: {error}");
            false
        }
    }
}

/// Runs an example, which `cargo test` has built beside the tests, and returns what it prints. Where cargo is told which
/// tests to build, it has to be told of the examples, too: `cargo test --examples --test examples`.
fn run(name: &str, arguments: &[&str]) -> String {
    let test = std::env::current_exe().expect("a test is a program");
    // Tests are in `deps`, examples in `examples` beside that.
    let profile = test.ancestors().nth(2).expect("cargo's folder of builds");
    let program: PathBuf = profile
        .join("examples")
        .join(format!("{name}{}", std::env::consts::EXE_SUFFIX));
    let done = Command::new(&program)
        .args(arguments)
        .output()
        .unwrap_or_else(|e| panic!("{}: {e}", program.display()));
    let (out, err) = (
        String::from_utf8_lossy(&done.stdout),
        String::from_utf8_lossy(&done.stderr),
    );
    println!("{name}:\n{out}");
    assert_eq!(done.status.code(), Some(0), "{name}:\n{out}{err}");
    out.into_owned()
}

/// Both views before and after a change against the processor, and once against traced surfaces.
fn both_views_agree(printed: &str) {
    for view in ["view 0: ", "view 1: "] {
        let lines = || printed.lines().filter(|line| line.starts_with(view));
        let of = |what: &str| lines().any(|line| line.contains(what));
        for what in ["at noon: FLIP", "in the evening: FLIP", "traced surfaces"] {
            assert!(of(what), "{view}{what}: {printed}");
        }
        assert!(lines().all(|line| line.ends_with(": agrees")), "{printed}");
    }
}

#[test]
fn an_engine_on_wgpu_is_lit() {
    if has("embed_wgpu", backends::open(Choice::Wgpu)) {
        both_views_agree(&run("embed_wgpu", &[]));
    }
}

/// Under the validation layer, synchronization included, which has to stay silent.
#[test]
fn an_engine_on_vulkan_is_lit() {
    let watched = Options {
        validation: true,
        sync_validation: true,
        device: None,
    };
    let opened = VulkanBackend::new(watched);
    let traces = opened
        .as_ref()
        .is_ok_and(|backend| backend.capabilities().ray_query);
    if has("embed_vulkan", opened) {
        let silent = "messages of the validation layer: 0";
        let printed = run("embed_vulkan", &["--validate"]);
        both_views_agree(&printed);
        assert!(printed.contains(silent), "{printed}");
        let missing = (!traces).then(|| BackendError::Unavailable {
            backend: "vulkan".into(),
            reason: "the device has no ray queries".into(),
            remedy: "use the software driver".into(),
        });
        if !has("embed_vulkan with ray queries", missing.map_or(Ok(()), Err)) {
            return;
        }
        let printed = run("embed_vulkan", &["--validate", "--ray-queries"]);
        both_views_agree(&printed);
        assert!(printed.contains(silent), "{printed}");
        assert!(printed.contains("with ray queries"), "{printed}");
    }
}
