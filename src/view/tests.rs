use super::{View, ViewError};
use gibs_passes::scene::{Camera, Environment, Light, LightKind, Material, Mesh, Node, Scene, Sun};
use gibs_passes::scene::{LocalTransform, Texture};
use glam::{DVec3, Vec3};
use std::path::{Path, PathBuf};

const FULL: &str = r#"{
    "scene": "room.gltf",
    "camera": {"position": [0, 1, 3], "target": [0, 1, 0], "up": [0, 2, 0], "vfov_degrees": 50},
    "resolution": [320, 200],
    "sun": {"direction": [0, -3, 4], "irradiance_rgb": [6, 5, 4]},
    "sky_radiance_rgb": [0.25, 0.5, 1],
    "animation": [{"index": 1, "time": 0.5}],
    "transparent": "coverage",
    "exposure": 1.5,
    "note": "a note"
}"#;

fn parse(text: &str) -> Result<View, ViewError> {
    View::from_json(text, Path::new("views/v.json"))
}

/// A file that is removed when the test ends.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        Self(std::env::temp_dir().join(format!("gibs-view-{}-{name}", std::process::id())))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

#[test]
fn every_field_is_read() {
    let view = parse(FULL).unwrap();
    assert_eq!(view.scene, Some(PathBuf::from("views/room.gltf")));
    assert_eq!(view.camera.up, DVec3::Y);
    assert_eq!(view.camera.vfov, 50_f64.to_radians());
    assert_eq!(view.resolution, [320, 200]);
    let sun = view.sun.unwrap();
    // 3-4-5 triangle; the division is exact to rounding.
    assert!((sun.direction - DVec3::new(0.0, -0.6, 0.8)).length() < 1e-15);
    assert_eq!(sun.irradiance, Vec3::new(6.0, 5.0, 4.0));
    assert_eq!(
        view.environment,
        Environment::Constant(Vec3::new(0.25, 0.5, 1.0))
    );
    assert_eq!(view.animation, [(1, 0.5)]);
    assert_eq!(view.exposure, 1.5);
}

#[test]
fn a_camera_is_enough() {
    let text = r#"{"camera": {"position": [0,1,3], "target": [0,1,0], "vfov_degrees": 50}}"#;
    let view = parse(text).unwrap();
    assert_eq!(view.resolution, super::DEFAULT_RESOLUTION);
    assert_eq!((view.sun, view.exposure), (None, 1.0));
    assert_eq!(view.environment, Environment::Constant(Vec3::ZERO));
}

#[test]
fn what_is_written_reads_back() {
    let view = parse(FULL).unwrap();
    let again = View::from_json(&view.to_json().unwrap(), Path::new("v.json")).unwrap();
    assert_eq!(again.scene, view.scene);
    // Degrees and unit vectors are rounded once more on the way.
    assert!((again.camera.vfov - view.camera.vfov).abs() < 1e-14);
    let (a, b) = (again.sun.unwrap(), view.sun.unwrap());
    assert!((a.direction - b.direction).length() < 1e-15);
    assert_eq!(a.irradiance, b.irradiance);
    assert_eq!(
        (again.environment, again.animation),
        (view.environment, view.animation)
    );
    assert_eq!(
        (again.resolution, again.exposure),
        (view.resolution, view.exposure)
    );
}

#[test]
fn errors_name_file_field_value_and_remedy() {
    let cases = [
        (
            r#""resolution": [320, 200]"#,
            r#""resolution": [0, 200]"#,
            "`resolution` is [0, 200]: give",
        ),
        (
            r#""vfov_degrees": 50"#,
            r#""vfov_degrees": 180"#,
            "`camera.vfov_degrees` is 180: give",
        ),
        (
            r#""target": [0, 1, 0]"#,
            r#""target": [0, 1, 3]"#,
            "`camera.target` is",
        ),
        (
            r#""target": [0, 1, 0]"#,
            r#""target": [0, 1e20, 0]"#,
            "`camera.target` is",
        ),
        (
            r#""up": [0, 2, 0]"#,
            r#""up": [0, 0, 1]"#,
            "parallel to the line of sight",
        ),
        (
            r#""up": [0, 2, 0]"#,
            r#""up": [0, 0, 0]"#,
            "`camera.up` is [0.0, 0.0, 0.0]: give",
        ),
        (
            r#""direction": [0, -3, 4]"#,
            r#""direction": [0, 0, 0]"#,
            "`sun.direction` is",
        ),
        (
            "[6, 5, 4]",
            "[6, -5, 4]",
            "`sun.irradiance_rgb` is [6.0, -5.0, 4.0]: give",
        ),
        ("[6, 5, 4]", "[6, 1e200, 4]", "`sun.irradiance_rgb` is"),
        ("[0.25, 0.5, 1]", "[-1, 0.5, 1]", "`sky_radiance_rgb` is"),
        (
            r#""exposure": 1.5"#,
            r#""exposure": 0"#,
            "`exposure` is 0: give",
        ),
        (
            r#""transparent""#,
            r#""environment": {"file": "x.hdr"}, "transparent""#,
            "or `environment`",
        ),
    ];
    for (from, to, expected) in cases {
        assert!(FULL.contains(from), "the case {from} is stale");
        let message = parse(&FULL.replace(from, to)).unwrap_err().to_string();
        assert!(message.contains("views/v.json"), "{message}");
        assert!(message.contains(expected), "{message} lacks {expected}");
    }
}

#[test]
fn malformed_files_tell_the_line() {
    for (from, to, expected) in [
        (
            r#""exposure""#,
            r#""exposition""#,
            "unknown field `exposition`, expected one of",
        ),
        (
            "[320, 200]",
            "[320, -1]",
            "invalid value: integer `-1`, expected u32 at line 4",
        ),
        (
            r#""vfov_degrees": 50"#,
            r#""vfov": 50"#,
            "unknown field `vfov`",
        ),
        (
            "coverage",
            "refraction",
            "unknown variant `refraction`, expected `coverage`",
        ),
        (
            "[6, 5, 4]",
            "[6, 1e999, 4]",
            "number out of range at line 5",
        ),
        ("\n}", "", "EOF while parsing an object at line 10"),
    ] {
        let message = parse(&FULL.replacen(from, to, 1)).unwrap_err().to_string();
        assert!(message.contains(expected), "{message} lacks {expected}");
        assert!(message.contains("views/v.json"), "{message}");
    }
}

#[test]
fn a_missing_file_is_named() {
    let message = View::load("no/such/view.json").unwrap_err().to_string();
    assert!(
        message.contains("cannot read no/such/view.json"),
        "{message}"
    );
}

/// Writes a 2 x 1 map with one texel (1, 2, 4) and one bad one, and returns the view that uses it.
fn load_map(name: &str, write: impl FnOnce(&Path)) -> Result<View, ViewError> {
    let map = Scratch::new(name);
    write(&map.0);
    let text = FULL
        .replace(
            r#""sky_radiance_rgb": [0.25, 0.5, 1]"#,
            "\"environment\": MAP",
        )
        .replace(
            "MAP",
            &format!(
                r#"{{"file": {:?}, "scale": 0.5, "rotation_y_degrees": 90}}"#,
                map.0
            ),
        );
    parse(&text)
}

#[test]
fn environment_maps_are_scaled_and_cleaned() {
    let pixels = [[1.0_f32, 2.0, 4.0], [f32::NAN, -1.0, f32::INFINITY]];
    let view = load_map("map.exr", |file| {
        exr::prelude::write_rgb_file(file, 2, 1, |x, _| {
            let [r, g, b] = pixels[x];
            (r, g, b)
        })
        .unwrap();
    })
    .unwrap();
    let Environment::Map(map) = &view.environment else {
        panic!("not a map")
    };
    assert_eq!((map.width, map.height), (2, 1));
    assert_eq!(
        map.texels,
        [Vec3::new(0.5, 1.0, 2.0), Vec3::new(0.0, 0.0, 65_504.0)]
    );
    assert_eq!(map.rotation_y, std::f64::consts::FRAC_PI_2);
    assert_eq!(view.warnings.len(), 1);
    assert!(
        view.warnings[0].contains("1 of 2 texels"),
        "{}",
        view.warnings[0]
    );
    assert!(matches!(view.to_json(), Err(ViewError::Unwritable { .. })));
}

#[test]
fn radiance_maps_are_read() {
    let view = load_map("map.hdr", |file| {
        let encoder = image::codecs::hdr::HdrEncoder::new(std::fs::File::create(file).unwrap());
        let texels = [image::Rgb([1.0, 2.0, 4.0]), image::Rgb([0.0, 0.0, 0.0])];
        encoder.encode(&texels, 2, 1).unwrap();
    })
    .unwrap();
    let Environment::Map(map) = &view.environment else {
        panic!("not a map")
    };
    // RGBE holds powers of two exactly.
    assert_eq!(map.texels, [Vec3::new(0.5, 1.0, 2.0), Vec3::ZERO]);
    assert!(view.warnings.is_empty());
}

#[test]
fn bad_maps_are_explained() {
    let garbage = |file: &Path| std::fs::write(file, "not an image").unwrap();
    for (name, expected) in [
        ("bad.hdr", "Radiance .hdr"),
        ("bad.exr", "OpenEXR"),
        ("bad.png", "neither in .hdr"),
    ] {
        let message = load_map(name, garbage).unwrap_err().to_string();
        assert!(
            message.contains(expected) && message.contains(name),
            "{message}"
        );
    }
    let huge = |file: &Path| {
        let text = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1000000 +X 1000000\n";
        std::fs::write(file, text).unwrap();
    };
    let message = load_map("huge.hdr", huge).unwrap_err().to_string();
    assert!(
        message.contains("1000000 x 1000000; scale it down"),
        "{message}"
    );
    let message = load_map("absent.hdr", |_| ()).unwrap_err().to_string();
    assert!(message.contains("cannot read"), "{message}");
}

fn square(emission: f32) -> Scene {
    Scene {
        meshes: vec![Mesh {
            positions: vec![Vec3::ZERO, Vec3::X * 4.0, Vec3::Y * 2.0],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        }],
        materials: vec![Material {
            emission: Vec3::splat(emission),
            ..Material::default()
        }],
        textures: vec![Texture::default()],
        nodes: vec![Node {
            name: String::new(),
            parent: None,
            local: LocalTransform::Parts {
                translation: DVec3::new(10.0, 0.0, 0.0),
                rotation: glam::DQuat::IDENTITY,
                scale: DVec3::ONE,
            },
            meshes: vec![0],
            skin: None,
        }],
        ..Scene::default()
    }
}

#[test]
fn framing_shows_every_corner() {
    let view = View::framing(&square(0.0));
    assert_eq!(view.camera.target, DVec3::new(12.0, 1.0, 0.0));
    let [right, up, forward] = view.camera.axes();
    for corner in [
        DVec3::new(10.0, 0.0, 0.0),
        DVec3::new(14.0, 0.0, 0.0),
        DVec3::new(10.0, 2.0, 0.0),
    ] {
        let d = corner - view.camera.position;
        let edge = (view.camera.vfov / 2.0).tan() * d.dot(forward);
        assert!(
            d.dot(forward) > 0.0
                && d.dot(up).abs() < edge
                && d.dot(right).abs() < edge * 16.0 / 9.0
        );
    }
    assert!(view.sun.is_some() && view.environment != Environment::default());
}

#[test]
fn framing_adds_light_only_to_darkness() {
    assert_eq!(View::framing(&square(1.0)).sun, None);
    let mut scene = square(0.0);
    scene.lights.push(Light {
        node: 0,
        kind: LightKind::Point,
        intensity: Vec3::ONE,
    });
    let view = View::framing(&scene);
    assert_eq!((view.sun, view.environment), (None, Environment::default()));
    let empty = View::framing(&Scene::default());
    assert!(empty.camera.position.is_finite() && matches!(empty.sun, Some(Sun { .. })));
}

#[test]
fn framing_prefers_the_scene_s_camera() {
    let mut scene = square(0.0);
    let camera = Camera {
        position: DVec3::ZERO,
        target: DVec3::NEG_Z,
        up: DVec3::Y,
        vfov: 0.5,
    };
    scene.cameras.push((0, camera));
    // In world space already: its node, which is moved, does not move it again.
    assert_eq!(View::framing(&scene).camera, camera);
}
