//! The readers of views, camera paths, settings and expected differences.
use crate::edits::{ByteEdit, byte_edits, edit_bytes, edit_json, json_edits};
use crate::watch::{cases, watched};
use gibs::check::Expectations;
use gibs::graph::NullBackend;
use gibs::graph::glam::DVec3;
use gibs::measure::CameraPath;
use gibs::passes::frame::Settings;
use gibs::passes::scene::Camera;
use gibs::view::View;
use gibs::{Renderer, builtin};
use proptest::prelude::*;
use proptest::sample::select;
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

fn damaged(text: &str, edits: &[ByteEdit]) -> String {
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
    #![proptest_config(cases(2000))]

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

/// Values that a settings file may give.
fn setting() -> impl Strategy<Value = (usize, String)> {
    let values = vec![
        "0",
        "1",
        "-1",
        "true",
        "false",
        "nan",
        "inf",
        "-inf",
        "1e30",
        "1e-30",
        "-0.0",
        "0.5",
        "4294967295",
        "4294967296",
        "9223372036854775807",
        "-9223372036854775808",
        "\"on\"",
        "\"\"",
        "[]",
        "{}",
        "1e400",
        "99999999999999999999999",
        "0x7fffffff",
        "1979-05-27",
    ];
    let edge = (any::<usize>(), select(values)).prop_map(|(i, value)| (i, value.to_owned()));
    // Around what the setting itself allows.
    let bound = (any::<usize>(), 0_usize..6).prop_map(|(i, which)| {
        let all = Settings::all();
        let info = &all[i % all.len()];
        let number = [
            info.least,
            info.most,
            info.default,
            info.least - 1.0,
            info.most + 1.0,
            info.most / 2.0,
        ][which];
        (
            i,
            if number.fract() == 0.0 && which < 5 {
                format!("{number:.0}")
            } else {
                format!("{number:?}")
            },
        )
    });
    prop_oneof![edge, bound]
}

proptest! {
    #![proptest_config(cases(400))]

    /// What a settings file may say makes a frame; memory is not asked for before it runs.
    #[test]
    fn settings_make_a_frame_or_are_refused(pairs in prop::collection::vec(setting(), 0..5), bytes in prop::option::of(byte_edits())) {
        let all = Settings::all();
        let mut lines: Vec<String> =
            pairs.iter().map(|(i, value)| format!("{} = {value}", all[i % all.len()].name)).collect();
        lines.sort();
        lines.dedup_by_key(|line| line.split(' ').next().map(str::to_owned));
        let mut text = lines.join("\n");
        if let Some(edits) = bytes {
            text = damaged(&text, &edits);
        }
        watched(|| {
            let Ok(settings) = toml::from_str::<Settings>(&text) else { return };
            if settings.check().is_err() {
                return;
            }
            let (scene, view) = builtin::by_name("cornell").expect("built in");
            let made = Renderer::new(&NullBackend::new(), &scene, &view, [8, 8], &settings, 0);
            // Too large for a buffer of WebGPU is a reason that names itself.
            if let Err(error) = made {
                assert!(!error.to_string().is_empty());
            }
        });
    }

    #[test]
    fn a_setting_takes_what_it_says(i: usize, value in "\\PC{0,12}", number: f64) {
        let all = Settings::all();
        let name = all[i % all.len()].name;
        for value in [value, number.to_string()] {
            let mut settings = Settings::default();
            match settings.set(name, &value) {
                Ok(()) => prop_assert!(settings.check().is_ok(), "{} = {}", name, value),
                Err(error) => prop_assert!(error.to_string().contains(name)),
            }
        }
    }
}
