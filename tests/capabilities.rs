//! What the frames need of a device.
use gibs::Gi;
use gibs::builtin;
use gibs::graph::{BackendError, Capabilities};
use gibs::passes::frame::{Screen, Settings};

fn check(scene: &str, size: [u32; 2], settings: &Settings) -> Result<(), BackendError> {
    let (scene, view) = builtin::by_name(scene).expect("built in");
    let gi = Gi::new(&scene, &view, size, settings, Screen::Traced).expect("valid");
    Capabilities::webgpu().check("webgpu", gi.schedule())
}

/// Every built-in scene at the size of a screen; with more lights than two, with two of them per point.
#[test]
fn frames_fit_any_webgpu_device() {
    let settings = Settings {
        lights: 2,
        ..Settings::default()
    };
    for &(scene, _) in builtin::names() {
        if let Err(error) = check(scene, [1920, 1080], &settings) {
            panic!("{scene}: {error}");
        }
    }
}

/// Where four shadow rays per pixel are more than one binding holds, the stage and the limit are named.
#[test]
fn what_is_more_than_a_device_allows_is_named() {
    let refused = check("many-lights", [1920, 1080], &Settings::default());
    let text = refused.expect_err("265 MB in one binding").to_string();
    for part in [
        "stage `apply/sample_lights`",
        "`apply_light_rays`",
        "265420800",
        "134217728",
        "lights per point",
    ] {
        assert!(text.contains(part), "{part} is not in: {text}");
    }
    assert!(check("many-lights", [480, 270], &Settings::default()).is_ok());
}
