//! The surfel frame and the reference under Vulkan's validation layer, synchronization included: silence.
#![cfg(feature = "vulkan")]
mod common;

use common::{render, settings};
use gibs::builtin;
use gibs::reference::{ReferenceOptions, reference};
use gibs_backend_vulkan::{Options, VulkanBackend};

/// The backend with all checks, or `None` where the machine lacks driver or layer; under `GIBS_STRICT=1` that fails.
fn watched() -> Option<VulkanBackend> {
    let options = Options {
        validation: true,
        sync_validation: true,
        device: None,
    };
    match VulkanBackend::new(options) {
        Ok(backend) => Some(backend),
        Err(error) if std::env::var_os("GIBS_STRICT").is_some_and(|v| v == "1") => {
            panic!("{error}")
        }
        Err(error) => {
            eprintln!("not run: {error}");
            None
        }
    }
}

/// A scene with lights, sky and emission, so that every stage of both frames runs.
#[test]
fn the_layer_stays_silent() {
    let Some(backend) = watched() else { return };
    let (scene, mut view) = builtin::by_name("cornell").expect("built in");
    let (_, lit) = builtin::by_name("window-room").expect("built in");
    (view.sun, view.environment) = (lit.sun, lit.environment);
    render(
        &backend,
        &(scene.clone(), view.clone()),
        [48, 48],
        4,
        &settings(2_000),
        0,
    );
    let options = ReferenceOptions {
        size: [24, 24],
        samples: 4,
        seed: 0,
        emitters: true,
    };
    reference(&backend, &scene, &view, &options, |_, _| {}).expect("renders");
    let messages = backend.validation_messages();
    assert!(
        messages.is_empty(),
        "{} messages:\n{}",
        messages.len(),
        messages.join("\n")
    );
}
