//! Vertices, indices and triangles that make no surface.
use super::file::{Doc, SQUARE, SQUARE_PIXELS};
use super::run::{drawn, refused};
use serde_json::json;

#[test]
fn indices_out_of_range_are_named_with_their_place() {
    for (place, index) in [(0, 4), (3, 5), (5, u16::MAX)] {
        let mut doc = Doc::square();
        let mut indices = [0, 1, 2, 0, 2, 3];
        indices[place] = index;
        doc.shape(&SQUARE, &indices);
        let text = format!("has vertex {index} at place {place}, but there are 4 vertices;");
        refused(
            &doc,
            &[
                "meshes[0].primitives[0].indices",
                &text,
                "correct the index",
            ],
        );
    }
}

#[test]
fn positions_that_are_no_places_are_named_with_their_vertex() {
    for (value, text) in [
        (f32::NAN, "NaN"),
        (f32::INFINITY, "inf"),
        (f32::NEG_INFINITY, "-inf"),
        (f32::MAX, "340282350000000000000000000000000000000"),
        (-1e12, "-1000000000000"),
    ] {
        for component in [0, 4, 11] {
            let mut doc = Doc::square();
            doc.overwrite(0, component, &[value]);
            let vertex = format!("mesh 0 \"wall\", vertex {}: position is [", component / 3);
            refused(&doc, &[&vertex, text, "must be finite and below 1e12"]);
        }
    }
}

/// What has no name is named by its place in the file.
#[test]
fn bad_positions_in_a_mesh_without_a_name_are_named_by_their_primitive() {
    let mut doc = Doc::square();
    doc.at("/meshes/0").as_object_mut().unwrap().remove("name");
    let positions = doc.floats("VEC3", &[0., 0., 0., 1., f32::NAN, 0., 1., 1., 0.]);
    doc.push(
        "/meshes/0/primitives",
        json!({"attributes": {"POSITION": positions}}),
    );
    refused(
        &doc,
        &[
            "\"meshes[0].primitives[1]\", vertex 1",
            "NaN",
            "must be finite",
        ],
    );
}

#[test]
fn numbers_that_are_no_numbers_are_refused_in_skins_and_keyframes() {
    let mut doc = Doc::square();
    let times = doc.floats("SCALAR", &[0., f32::NAN]);
    let moves = doc.floats("VEC3", &[0.; 6]);
    doc.root["animations"] = json!([{
        "samplers": [{"input": times, "output": moves}],
        "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
    }]);
    refused(
        &doc,
        &[
            "animation 0, channel 0",
            "keyframe 1 is NaN",
            "must be finite",
        ],
    );
    doc.overwrite(times, 1, &[1.0]);
    doc.overwrite(moves, 5, &[f32::INFINITY]);
    refused(&doc, &["animation 0, channel 0", "inf", "must be finite"]);
    doc.overwrite(moves, 5, &[0.0]);
    drawn(&doc).warns(&[]).is_the_square();
}

/// Bad normals are worth less than the surface they belong to, so they are replaced.
#[test]
fn normals_and_coordinates_that_are_no_numbers_are_replaced() {
    for bad in [[f32::NAN; 3], [f32::INFINITY; 3], [0.0; 3]] {
        let mut doc = Doc::square();
        doc.overwrite(2, 3, &bad);
        let drawn = drawn(&doc).warns(&[&["1 normal", "replaced", "mesh 0 \"wall\""]]);
        drawn.is_the_square();
    }
    let mut doc = Doc::square();
    let texture = doc.view(&super::textures::png(2, 2, [255; 4]));
    doc.root["images"] = json!([{"bufferView": texture}]);
    doc.root["textures"] = json!([{"source": 0}]);
    doc.at("/materials/0/pbrMetallicRoughness")["baseColorTexture"] = json!({"index": 0});
    doc.overwrite(3, 2, &[f32::NAN, f32::NEG_INFINITY]);
    let drawn = drawn(&doc).warns(&[&["1 texture coordinate", "set to zero", "mesh 0 \"wall\""]]);
    drawn.is_the_square();
}

#[test]
fn triangles_without_area_are_dropped_and_the_rest_is_drawn() {
    let mut doc = Doc::square();
    // Beside the square: a corner thrice, a corner twice, three corners on a line, three corners at one place.
    let mut positions = SQUARE.to_vec();
    positions.extend([0., 0., 0.]);
    positions.extend([5., 5., 5.].repeat(3));
    let flat = [1, 1, 1, 0, 0, 1, 0, 4, 2, 5, 6, 7];
    doc.shape(&positions, &[&[0, 1, 2, 0, 2, 3][..], &flat].concat());
    let drawn = drawn(&doc).warns(&[&["4 triangles without area dropped", "mesh 0 \"wall\""]]);
    drawn.is_the_square();
}

#[test]
fn corners_that_are_left_over_are_ignored() {
    let mut doc = Doc::square();
    doc.shape(&SQUARE, &[0, 1, 2, 0, 2, 3, 0, 1]);
    let drawn = drawn(&doc).warns(&[&["primitives[0]", "8 corners", "the rest is ignored"]]);
    drawn.is_the_square();
}

/// Primitives that draw nothing are named; those beside them are drawn.
#[test]
fn parts_without_triangles_are_named_and_the_rest_is_drawn() {
    let empty = |primitive: serde_json::Value, parts: &[&str]| {
        let mut doc = Doc::square();
        doc.push("/meshes/0/primitives", primitive);
        drawn(&doc).warns(&[parts]).is_the_square();
    };
    let mut doc = Doc::square();
    let none = doc.shorts(&[]);
    doc.push(
        "/meshes/0/primitives",
        json!({"attributes": {"POSITION": 0}, "indices": none}),
    );
    let drawn = drawn(&doc).warns(&[&["primitives[1] has no triangles", "left out"]]);
    drawn.is_the_square();
    empty(
        json!({"attributes": {}}),
        &["primitives[1] has no positions", "left out"],
    );
    empty(
        json!({"attributes": {"POSITION": 0}, "mode": 0}),
        &["points and lines", "left out"],
    );
}

#[test]
fn a_mesh_without_primitives_is_named() {
    let mut doc = Doc::square();
    let mesh = doc.push("/meshes", json!({"primitives": []}));
    doc.node(json!({"mesh": mesh}));
    let drawn = drawn(&doc).warns(&[&["meshes[1] has no primitives", "left out"]]);
    drawn.is_the_square();
}

/// A scene far from any usual size is still the same picture.
#[test]
fn tiny_and_huge_scenes_are_framed() {
    for scale in [1e-12, 1e-6, 1e6, 0.9e12f32] {
        let mut doc = Doc::square();
        doc.shape(&SQUARE.map(|x| x * scale), &[0, 1, 2, 0, 2, 3]);
        doc.root["scenes"][0]["nodes"] = json!([0]);
        let drawn = drawn(&doc).warns(&[&["no camera"], &["no light"]]);
        assert!(
            (60..SQUARE_PIXELS).contains(&drawn.seen()),
            "{scale}: {}",
            drawn.seen()
        );
        let [red, ..] = drawn.color("", 12, 12);
        assert!(drawn.sees(12, 12) && red > 0.1, "{scale}: {red}");
    }
}
