//! Light that is no light: negative, infinite, or more than sums of it can hold.
use super::file::{BRIGHT, Doc, Folder};
use super::run::{drawn, gibs, refused, stderr};
use serde_json::{Value, json};
use std::path::Path;

const EXPECTED: &str = "must be finite, not negative and at most 1e13";

#[test]
fn lights_that_are_too_bright_or_too_dark_are_named() {
    for (intensity, found) in [
        (json!(-1), "-1"),
        (json!(1e39), "inf"),
        (json!(2e13), "20000000000000"),
    ] {
        let mut doc = Doc::square();
        doc.at("/extensions/KHR_lights_punctual/lights/0")["intensity"] = intensity.clone();
        refused(&doc, &["light 0", "intensity is", found, EXPECTED]);
        let mut doc = Doc::square();
        doc.root["materials"][0]["emissiveFactor"] = json!([0, 1, 0]);
        doc.root["materials"][0]["extensions"] =
            json!({"KHR_materials_emissive_strength": {"emissiveStrength": intensity}});
        refused(
            &doc,
            &["material 0 \"grey\"", "emission is", found, EXPECTED],
        );
    }
}

#[test]
fn the_brightest_light_is_drawn() {
    let mut doc = Doc::square();
    doc.at("/extensions/KHR_lights_punctual/lights/0")["intensity"] = json!(1e13);
    let expected = 1e13 * BRIGHT / std::f32::consts::PI;
    let drawn = drawn(&doc).warns(&[]);
    for channel in drawn.color("", 12, 12) {
        assert!((channel / expected - 1.0).abs() < 4e-3, "{channel}");
    }
}

/// The program with a view of this sky.
fn with_sky(scene: &Path, command: &[&str], sky: Value) -> (Option<i32>, String) {
    let camera = json!({"position": [0, 0, 3], "target": [0, 0, 0], "vfov_degrees": 53});
    let view = json!({"camera": camera, "sky_radiance_rgb": sky}).to_string();
    let (file, out) = (
        scene.with_file_name("sky.json"),
        scene.with_file_name("sky.exr"),
    );
    std::fs::write(&file, view).unwrap();
    let [scene, view, out] = [scene, &file, &out].map(|path| path.to_str().unwrap());
    let common = [
        scene,
        "--view",
        view,
        "--backend",
        "cpu",
        "--size",
        "8x8",
        "--out",
        out,
    ];
    let output = gibs(&[command, &common].concat());
    (output.status.code(), stderr(&output))
}

/// As bright as is allowed, sums and their squares still fit; a step further is refused.
#[test]
fn skies_are_drawn_up_to_the_limit_and_refused_beyond() {
    let folder = Folder::new();
    let scene = Doc::square().write(&folder);
    for command in [
        &["render", "--frames", "4"][..],
        &["reference", "--spp", "64"],
    ] {
        let answer = with_sky(&scene, command, json!([1e13, 1e13, 1e13]));
        assert_eq!(answer, (Some(0), String::new()), "{command:?}");
        for (sky, found) in [
            (json!([0, 2e13, 0]), "20000000000000.0"),
            (json!([0, -1, 0]), "-1.0"),
        ] {
            let (code, text) = with_sky(&scene, command, sky);
            assert_eq!(code, Some(2), "{text}");
            for part in ["sky.json", "`sky_radiance_rgb`", found, "from 0 to 1e13"] {
                assert!(text.contains(part), "{part:?} is not in: {text}");
            }
        }
    }
}

/// A map of four texels: a number that is none, two that are too small or too large, and one that is light.
#[test]
fn sky_texels_that_are_no_light_are_clamped_and_counted() {
    let folder = Folder::new();
    let mut doc = Doc::square();
    doc.root["scenes"][0]["nodes"] = json!([0]);
    let scene = doc.write(&folder);
    let mut map = gibs::picture::Picture::new(4, 1);
    let red = vec![f32::NAN, -1.0, 1e20, 0.25];
    map.set_rgb("", [red.clone(), red.clone(), red]).unwrap();
    map.write_exr(&folder.0.join("sky.exr")).unwrap();
    let view = json!({
        "camera": {"position": [0, 0, 3], "target": [0, 0, 0], "vfov_degrees": 53},
        "environment": {"file": "sky.exr"},
    });
    let view = folder.write("map.json", view.to_string());
    let args = [&scene, &view].map(|path| path.to_str().unwrap());
    let out = folder.0.join("out.png");
    let output = gibs(&[
        "render",
        args[0],
        "--view",
        args[1],
        "--backend",
        "cpu",
        "--size",
        "8x8",
        "--frames",
        "4",
        "--out",
        out.to_str().unwrap(),
    ]);
    let text = stderr(&output);
    assert_eq!(output.status.code(), Some(0), "{text}");
    for part in [
        "warning: environment map",
        "sky.exr",
        "3 of 4 texels",
        "clamped",
    ] {
        assert!(text.contains(part), "{part:?} is not in: {text}");
    }
    assert_eq!(text.lines().count(), 1, "{text}");
}
