//! Extending the frame: what cannot be is refused, and the examples of `docs/extending.md` build, run and find what they
//! claim.
#![cfg(feature = "cpu")]
mod common;

use gibs::graph::glam::Vec4;
use gibs::graph::{
    Backend, BackendError, Dispatch, Executable, Graph, GraphError, NullBackend, WgslSource,
    Workgroup, stage,
};
use gibs::passes::frame::{Light, SurfelOutputs};
use gibs::{RenderError, Renderer, builtin};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// The workspace's own build folder: its dependencies are those of the examples, and so compiled once.
fn target() -> PathBuf {
    let temporary = Path::new(env!("CARGO_TARGET_TMPDIR"));
    temporary.parent().expect("cargo makes it in there").into()
}

/// What a program printed; it must end well.
fn output(command: &mut Command) -> String {
    let Output {
        status,
        stdout,
        stderr,
    } = command.output().expect("the program starts");
    let stdout = String::from_utf8_lossy(&stdout).into_owned();
    assert!(
        status.success(),
        "{command:?}: {status}\n{stdout}\n{}",
        String::from_utf8_lossy(&stderr)
    );
    stdout
}

fn cargo(arguments: &[&str]) -> String {
    let mut command = Command::new(env!("CARGO"));
    command
        .args(arguments)
        .current_dir(ROOT)
        .env("CARGO_TARGET_DIR", target());
    output(&mut command)
}

/// A crate outside the workspace adds stages to the frame, on every backend that this machine has.
#[test]
fn a_crate_outside_adds_stages() {
    let manifest = "--manifest-path=examples/custom_stage/Cargo.toml";
    let said = cargo(&["run", "--release", "--locked", manifest]);
    print!("{said}");
    assert!(said.ends_with("agrees\n"), "{said}");
    for backend in common::all_backends() {
        let ran = format!("{}: exposure ", backend.name());
        assert!(said.contains(&ran), "not on {}", backend.name());
    }
}

/// A backend made from what `gibs-graph` has passes the cross-check kit with the CPU backend's bits.
#[test]
fn a_backend_outside_gives_the_same_bits() {
    // Of the whole workspace, as the tests are built: features of dependencies are then the same, and nothing is compiled
    // twice.
    let example = ["--workspace", "--example", "custom_backend"];
    cargo(&[&["build", "--release", "--locked"], &example[..]].concat());
    let file = format!("custom_backend{}", std::env::consts::EXE_SUFFIX);
    let said = output(&mut Command::new(
        target().join("release/examples").join(file),
    ));
    print!("{said}");
    assert!(said.contains("frames: Equal, 0 gaps"), "{said}");
}

stage! {
    /// Paints over the first pixel; says that it reads the picture, too, which it does not.
    pub stage Paint {
        wgsl: WgslSource {
            name: "paint",
            text: "@group(0) @binding(0) var<storage, read> light: array<vec4<f32>>;
                @group(0) @binding(1) var<storage, read_write> color: array<vec4<f32>>;
                @compute @workgroup_size(1) fn main() { color[0] = light[0]; }",
            modules: &[],
            features: &[],
        },
        workgroup: [1, 1, 1],
        ports: { read light: Vec4, read_write color: Vec4 },
        cpu: paint,
        wide: None,
    }
}

fn paint(p: &Views<'_>, _: Workgroup) {
    p.color.set(0, p.light[0]);
}

fn renderer(
    extend: impl Fn(&mut Graph, SurfelOutputs) + Send + Sync + 'static,
) -> Result<Renderer, RenderError> {
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    let (backend, settings) = (NullBackend::new(), common::settings(100));
    Renderer::extended(&backend, &scene, &view, [8, 8], &settings, 0, extend)
}

/// What further stages get wrong is named, with the stage.
#[test]
fn stages_that_do_not_fit_are_refused() {
    let refused = renderer(|g, frame| {
        let Light::Traced {
            irradiance, color, ..
        } = frame.light
        else {
            panic!("the renderer traces")
        };
        let _ = g.add::<Paint>(
            "apply/paint",
            Inputs {
                light: &irradiance,
                color,
            },
            Dispatch::Groups([1, 1, 1]),
        );
    });
    let Err(RenderError::Graph(errors)) = refused.map(|_| ()) else {
        panic!("a picture that is not the last version was accepted")
    };
    let not_last =
        |e: &GraphError| matches!(e, GraphError::NotLast { resource, .. } if resource == "color");
    assert!(errors.errors.iter().any(not_last), "{errors}");
    // A build without a GPU backend has nothing to read WGSL with.
    if cfg!(any(feature = "wgpu", feature = "vulkan")) {
        let over_declared = |e: &GraphError| {
            matches!(e, GraphError::Shader { stage, message, .. }
                if stage == "apply/paint" && message.contains("over-declared"))
        };
        assert!(errors.errors.iter().any(over_declared), "{errors}");
    }
}

/// Outputs are read by name and type.
#[test]
fn outputs_that_are_not_there_are_refused() {
    let mut renderer = renderer(|g, frame| g.output("gathered", &frame.gathered)).expect("a frame");
    renderer.frame().expect("runs");
    assert_eq!(renderer.output::<Vec4>("color").expect("there").len(), 64);
    let gathered = renderer.output::<gibs::passes::data::Gathered>("gathered");
    assert_eq!(gathered.expect("there").len(), 64);
    let refused = |result: Result<(), RenderError>| match result {
        Err(RenderError::Backend(error @ BackendError::Refused { .. })) => error.to_string(),
        other => panic!("{other:?}"),
    };
    let error = refused(renderer.output::<Vec4>("colour").map(|_| ()));
    assert!(
        error.contains("`colour`") && error.contains("irradiance, color"),
        "{error}"
    );
    let error = refused(renderer.output::<f32>("color").map(|_| ()));
    assert!(error.contains("`vec4<f32>`, not `f32`"), "{error}");
}

/// An engine makes a renderer on one thread and renders on another.
#[test]
fn a_renderer_moves_to_another_thread() {
    const fn is_send<T: Send>() {}
    const fn is_shared<T: Send + Sync + ?Sized>() {}
    const {
        is_send::<Renderer>();
        is_send::<gibs::Gi>();
        is_send::<Box<dyn Executable>>();
        is_shared::<dyn Backend>();
    }
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    let settings = common::settings(100);
    for backend in common::all_backends() {
        let mut renderer = Renderer::new(backend.as_ref(), &scene, &view, [8, 8], &settings, 0)
            .unwrap_or_else(|e| panic!("{}: {e}", backend.name()));
        let there = std::thread::spawn(move || {
            renderer.frame()?;
            renderer.picture().map(|picture| picture.width)
        });
        let width = there.join().expect("no panic");
        assert_eq!(width.expect("a picture"), 8, "{}", backend.name());
    }
}
