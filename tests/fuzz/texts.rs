//! The readers of views, camera paths and expected differences.
use crate::edits::{ByteEdit, byte_edits, edit_bytes, edit_json, json_edits};
use crate::watch::{cases, watched};
use gibs::check::Expectations;
use gibs::graph::glam::DVec3;
use gibs::measure::CameraPath;
use gibs::passes::frame::Settings;
use gibs::passes::scene::Camera;
use gibs::view::View;
use gibs::{Renderer, builtin};
use proptest::prelude::*;
use serde_json::{Value, json};
use std::path::Path;

const FILE: &str = "broken.json";

fn view() -> Value {
    json!({
        "scene": "room.gltf",
        "camera": {"position": [0, 1, 3], "target": [0, 1, 0], "up": [0, 1, 0], "vfov_degrees": 50},
        "resolution": [64, 48],
        "sun": {"direction": [-1, -2, 0], "irradiance_rgb": [6, 6, 5]},
        "sky_radiance_rgb": [0.3, 0.4, 0.6],
        "animation": [{"index": 0, "time": 1.5}],
        "transparent": "coverage",
        "exposure": 1,
        "note": "anything",
    })
}

fn path() -> Value {
    json!({
        "keys": [
            {"frame": 0, "position": [0, 1, 3], "target": [0, 1, 0]},
            {"frame": 12.5, "position": [2, 1, 1], "target": [0, 1, -3]},
            {"frame": 40, "position": [2, 2, 1], "target": [1, 1, -3]},
        ],
        "note": "anything",
    })
}

/// Breaks a text.
pub fn damaged(text: &str, edits: &[ByteEdit]) -> String {
    let mut bytes = text.as_bytes().to_vec();
    edit_bytes(&mut bytes, edits);
    String::from_utf8_lossy(&bytes).into_owned()
}

/// A camera that can take a picture.
fn assert_sees(camera: &Camera) {
    let axes = camera.axes();
    let finite = |v: &DVec3| v.is_finite();
    assert!(
        finite(&camera.position) && finite(&camera.target),
        "{camera:?}"
    );
    assert!(
        axes.iter().all(|axis| (axis.length() - 1.0).abs() < 1e-6),
        "{camera:?} has the axes {axes:?}"
    );
    assert!(
        camera.vfov > 0.0 && camera.vfov < std::f64::consts::PI,
        "{camera:?}"
    );
}

/// What is read is sound, and is read again as it was from what is written of it.
fn read_view(text: &str) {
    match View::from_json(text, Path::new(FILE)) {
        Ok(view) => {
            assert_sees(&view.camera);
            assert!(view.resolution.iter().all(|side| (1..=8192).contains(side)));
            let written = view.to_json().expect("its numbers are finite");
            let again =
                View::from_json(&written, Path::new(FILE)).expect("what is written can be read");
            // JSON's numbers are read to a unit in the last place, and directions are made unit again.
            let near = |a: f64, b: f64| (a - b).abs() <= 1e-12 * a.abs() + f64::MIN_POSITIVE;
            let (a, b) = (again.camera.position, view.camera.position);
            assert!((0..3).all(|i| near(a[i], b[i])), "{a} and {b}");
            assert_eq!(again.environment, view.environment);
            match (again.sun, view.sun) {
                (None, None) => {}
                (Some(a), Some(b)) => assert!(
                    a.irradiance == b.irradiance && a.direction.distance(b.direction) < 1e-12
                ),
                different => panic!("{different:?}"),
            }
            assert_eq!(again.exposure, view.exposure);
            assert_eq!(again.animation.len(), view.animation.len());
            for (a, b) in again.animation.iter().zip(&view.animation) {
                assert!(a.0 == b.0 && near(a.1, b.1), "{a:?} and {b:?}");
            }
        }
        Err(error) => assert!(error.to_string().contains(FILE), "{error}"),
    }
}

/// What is read has a camera at any time.
fn read_path(text: &str) {
    let (_, view) = builtin::by_name("cornell").expect("built in");
    match CameraPath::from_json(text, Path::new(FILE), &view.camera) {
        Ok(path) => {
            let last = path.last_frame();
            for frame in (0..40)
                .map(|i| (last / 40.0 * f64::from(i)).floor())
                .chain([last, last + 1.0])
            {
                assert_sees(&path.camera(frame));
            }
        }
        Err(error) => assert!(error.to_string().contains(FILE), "{error}"),
    }
}

proptest! {
    #![proptest_config(cases(6000))]

    #[test]
    fn a_broken_view_is_read_or_refused(edits in json_edits()) {
        let mut root = view();
        edit_json(&mut root, &edits);
        watched(|| read_view(&root.to_string()));
    }

    #[test]
    fn a_damaged_view_is_read_or_refused(edits in byte_edits()) {
        let text = damaged(&view().to_string(), &edits);
        watched(|| read_view(&text));
    }

    #[test]
    fn a_broken_path_is_read_or_refused(edits in json_edits()) {
        let mut root = path();
        edit_json(&mut root, &edits);
        watched(|| read_path(&root.to_string()));
    }

    #[test]
    fn a_damaged_path_is_read_or_refused(edits in byte_edits()) {
        let text = damaged(&path().to_string(), &edits);
        watched(|| read_path(&text));
    }

    #[test]
    fn damaged_expectations_are_read_or_refused(edits in byte_edits()) {
        let text = "[[expected]]\ndevice = \"llvmpipe\"\nbackend = \"vulkan\"\nstage = \"TraceClosest\"\n\
                    port = \"hits\"\nreason = \"the driver's bug\"\n[[expected]]\ndevice = 'x'\nstage = 'y'\nreason = ''";
        let text = damaged(text, &edits);
        watched(|| {
            let read: Result<Expectations, _> = toml::from_str(&text);
            if let Ok(read) = read {
                let written = toml::to_string(&read).expect("it is a table");
                prop_assert_eq!(toml::from_str::<Expectations>(&written).ok(), Some(read));
            }
            Ok(())
        })?;
    }
}

/// Draws a scene as a view says, small; every value of the picture is finite.
fn draw(text: &str) {
    let Ok(asked) = View::from_json(text, Path::new(FILE)) else {
        return;
    };
    let (scene, _) = builtin::by_name("cornell").expect("built in");
    let settings = Settings {
        rays: 64,
        surfels: 256,
        ..Settings::default()
    };
    // Its clips are those of another scene.
    let view = View {
        animation: Vec::new(),
        ..asked
    };
    let backend = crate::common::cpu();
    let made = Renderer::new(backend.as_ref(), &scene, &view, [6, 4], &settings, 0);
    let mut renderer = made.unwrap_or_else(|e| panic!("{e}"));
    for _ in 0..2 {
        renderer.frame().unwrap_or_else(|e| panic!("{e}"));
    }
    let picture = renderer.picture().unwrap_or_else(|e| panic!("{e}"));
    for (name, values) in &picture.channels {
        assert!(values.iter().all(|v| v.is_finite()), "{name}: {values:?}");
    }
}

/// An angle of so few degrees that it is none in radians.
#[test]
fn a_field_of_view_of_the_smallest_number_is_refused() {
    let mut root = view();
    root["camera"]["vfov_degrees"] = json!(5e-324);
    let error = View::from_json(&root.to_string(), Path::new(FILE)).expect_err("no angle");
    assert!(error.to_string().contains("camera.vfov_degrees"), "{error}");
}

proptest! {
    #![proptest_config(cases(100))]

    #[test]
    fn what_a_view_says_can_be_drawn(edits in json_edits()) {
        let mut root = view();
        edit_json(&mut root["camera"], &edits[..1]);
        edit_json(&mut root, &edits[1..]);
        watched(|| draw(&root.to_string()));
    }
}
