//! Scenes that lack what a picture needs: triangles, lights, a camera.
use super::file::{BRIGHT, Doc, Folder};
use super::run::{Drawn, drawn, gibs, stderr};
use serde_json::json;

const NOTHING: &str = "no triangles to draw, the picture shows only the sky; give a node a mesh";
const DARK: &str = "nothing in the scene or the view shines, so the picture is black; add a light";

/// The same grey everywhere.
fn is_even(drawn: &Drawn) {
    assert_eq!(drawn.seen(), 0);
    let [red, green, blue] = drawn.picture.rgb("").unwrap();
    for plane in [red, green, blue] {
        assert!(plane.iter().all(|&x| x == plane[0]));
    }
}

#[test]
fn scenes_without_triangles_say_so() {
    let mut doc = Doc::square();
    doc.root["nodes"][0] = json!({});
    let picture = drawn(&doc).warns(&[&[NOTHING]]);
    is_even(&picture);
    assert_eq!(picture.color("", 0, 0), [0.0; 3]);

    let mut doc = Doc::square();
    doc.shape(&[0.; 9], &[0, 1, 2]);
    is_even(&drawn(&doc).warns(&[
        &["1 triangle without area dropped"],
        &["\"nodes[0]\" is left out: its mesh has no triangles"],
        &[NOTHING],
    ]));

    let mut doc = Doc::square();
    doc.root["nodes"][0]["scale"] = json!([0, 0, 0]);
    is_even(&drawn(&doc).warns(&[&["\"nodes[0]\" is left out", "singular"], &[NOTHING]]));

    let mut doc = Doc::square();
    doc.root["scenes"] = json!([{}]);
    let picture = drawn(&doc).warns(&[
        &["the file's scene has no nodes"],
        &["no camera"],
        &["no light"],
        &[NOTHING],
    ]);
    is_even(&picture);
    assert!(picture.color("", 0, 0)[2] > 0.1, "the sky that is made up");
}

/// All commands that read a scene say what it lacks.
#[test]
fn every_command_says_what_the_scene_lost() {
    let folder = Folder::new();
    let mut doc = Doc::square();
    doc.node(json!({"mesh": 0, "name": "lid", "scale": [1, 1, 0]}));
    let path = doc.write(&folder);
    let (scene, out) = (path.to_str().unwrap(), folder.0.join("truth.exr"));
    let out = out.to_str().unwrap();
    let size = ["--size", "8x8"];
    let cpu = ["--backend", "cpu"];
    let commands: [&[&[&str]]; 4] = [
        &[
            &["render", scene, "--frames", "1", "--out", out],
            &size,
            &cpu,
        ],
        &[
            &["reference", scene, "--spp", "1", "--out", out],
            &size,
            &cpu,
        ],
        &[&["profile", scene, "--frames", "1"], &size, &cpu],
        &[&["graph", scene], &size],
    ];
    for command in commands {
        let command = command.concat();
        let output = gibs(&command);
        let text = stderr(&output);
        assert_eq!(output.status.code(), Some(0), "{command:?}: {text}");
        assert_eq!(
            text.matches("node 3 \"lid\" is left out").count(),
            1,
            "{command:?}: {text}"
        );
    }
}

#[test]
fn scenes_without_light_get_a_sky_and_say_so() {
    let mut doc = Doc::square();
    doc.root["scenes"][0]["nodes"] = json!([0, 1]);
    let lit = drawn(&doc).warns(&[&["no light", "a sun and a soft sky", "view file"]]);
    assert!(lit.color("", 12, 12).iter().all(|&c| c > 0.1));
    assert!(lit.color("", 0, 0).iter().all(|&c| c > 0.1));
    // A light that gives nothing is none.
    let mut doc = Doc::square();
    doc.at("/extensions/KHR_lights_punctual/lights/0")["intensity"] = json!(0);
    let dark = drawn(&doc).warns(&[&["no light", "a sun and a soft sky", "view file"]]);
    assert_eq!(dark.color("direct", 12, 12), lit.color("direct", 12, 12));
    // A surface that shines is one.
    let mut doc = Doc::square();
    doc.root["scenes"][0]["nodes"] = json!([0, 1]);
    doc.root["materials"][0]["emissiveFactor"] = json!([0.25, 0.25, 0.25]);
    let shining = drawn(&doc).warns(&[]);
    shining.is_grey(12, 12, 0.25);
    shining.is_grey(0, 0, 0.0);
}

/// A view that asks for darkness gets it, with a word.
#[test]
fn views_without_light_are_black_and_say_so() {
    let folder = Folder::new();
    let mut doc = Doc::square();
    doc.root["scenes"][0]["nodes"] = json!([0]);
    let scene = doc.write(&folder);
    let view = json!({"camera": {"position": [0, 0, 3], "target": [0, 0, 0], "vfov_degrees": 53}});
    let view = folder.write("dark.json", view.to_string());
    let out = folder.0.join("dark.exr");
    let [scene, view, picture] = [&scene, &view, &out].map(|path| path.to_str().unwrap());
    let output = gibs(&[
        "render",
        scene,
        "--view",
        view,
        "--backend",
        "cpu",
        "--size",
        "24x24",
        "--frames",
        "1",
        "--out",
        picture,
    ]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let text = stderr(&output);
    assert!(text.contains(DARK) && text.lines().count() == 1, "{text}");
    let picture = gibs::picture::Picture::read_exr(&out).unwrap();
    assert!(picture.scalar("R").unwrap().iter().all(|&x| x == 0.0));
    assert!(picture.scalar("mask.A").unwrap().contains(&1.0));
}

#[test]
fn scenes_without_a_camera_are_framed_and_say_so() {
    let mut doc = Doc::square();
    doc.root["scenes"][0]["nodes"] = json!([0, 2]);
    let framed = drawn(&doc).warns(&[&["no camera", "view file can place one"]]);
    assert!(framed.seen() > 60 && !framed.sees(0, 0) && !framed.sees(23, 23));
    framed.is_grey(12, 12, BRIGHT);
}

#[test]
fn cameras_without_a_picture_are_left_out_by_name() {
    let none = &["no camera", "view file can place one"][..];
    for (camera, node, parts) in [
        (
            json!({"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "znear": 0, "zfar": 1}}),
            json!({}),
            &["cameras[0]", "not a perspective camera", "left out"][..],
        ),
        (
            json!({"type": "perspective"}),
            json!({}),
            &["cameras[0]", "not a perspective camera", "left out"],
        ),
        (
            json!({"type": "perspective", "perspective": {"yfov": 0, "znear": 1}}),
            json!({}),
            &["cameras[0] has no picture", "yfov 0", "left out"],
        ),
        (
            json!({"type": "perspective", "perspective": {"yfov": 3.5, "znear": 1}}),
            json!({}),
            &["cameras[0] has no picture", "yfov 3.5", "left out"],
        ),
        (
            json!({"type": "perspective", "perspective": {"yfov": 1, "znear": 1}}),
            json!({"scale": [1, 1, 0]}),
            &["cameras[0] has no picture", "flat node", "left out"],
        ),
    ] {
        let mut doc = Doc::square();
        doc.root["cameras"] = json!([camera]);
        doc.root["nodes"][1] = node;
        doc.root["nodes"][1]["camera"] = json!(0);
        let framed = drawn(&doc).warns(&[parts, none]);
        framed.is_grey(12, 12, BRIGHT);
    }
}
