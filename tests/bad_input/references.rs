//! References to nothing, to themselves, and words that glTF does not know.
use super::file::{Doc, Folder};
use super::run::{drawn, refused, refused_file};
use serde_json::{Value, json};

/// The square with one of everything that refers to something.
fn full() -> Doc {
    let mut doc = Doc::square();
    let texture = doc.view(&super::textures::png(2, 2, [255; 4]));
    let times = doc.floats("SCALAR", &[0., 1.]);
    let moves = doc.floats("VEC3", &[0.; 6]);
    doc.root["images"] = json!([{"bufferView": texture}]);
    doc.root["samplers"] = json!([{}]);
    doc.root["textures"] = json!([{"source": 0, "sampler": 0}]);
    doc.at("/materials/0/pbrMetallicRoughness")["baseColorTexture"] = json!({"index": 0});
    doc.root["skins"] = json!([{"joints": [2]}]);
    doc.root["nodes"][0]["skin"] = json!(0);
    doc.root["nodes"][0]["children"] = json!([2]);
    doc.root["scenes"] = json!([{"nodes": [0, 1]}]);
    doc.root["animations"] = json!([{
        "samplers": [{"input": times, "output": moves}],
        "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
    }]);
    doc
}

/// The document is refused once the value at a JSON pointer is another.
#[track_caller]
fn refused_with(pointer: &str, value: Value, parts: &[&str]) {
    let mut doc = full();
    *doc.at(pointer) = value;
    refused(&doc, parts);
}

#[test]
fn the_document_that_is_broken_here_is_sound() {
    drawn(&full()).warns(&[]).is_the_square();
}

#[test]
fn references_to_nothing_are_named() {
    for (pointer, element, what, count) in [
        ("/scene", "scene", "scene", 1),
        ("/scenes/0/nodes/0", "the scene", "node", 3),
        ("/nodes/0/children/0", "nodes[0].children", "node", 3),
        ("/nodes/0/mesh", "nodes[0]", "mesh", 1),
        ("/nodes/0/skin", "nodes[0]", "skin", 1),
        ("/nodes/1/camera", "nodes[1]", "camera", 1),
        (
            "/nodes/2/extensions/KHR_lights_punctual/light",
            "nodes[2]",
            "light",
            1,
        ),
        ("/skins/0/joints/0", "skins[0]", "node", 3),
        (
            "/meshes/0/primitives/0/attributes/POSITION",
            "POSITION",
            "accessor",
            6,
        ),
        (
            "/meshes/0/primitives/0/attributes/NORMAL",
            "NORMAL",
            "accessor",
            6,
        ),
        (
            "/meshes/0/primitives/0/indices",
            "primitives[0].indices",
            "accessor",
            6,
        ),
        (
            "/meshes/0/primitives/0/material",
            "primitives[0]",
            "material",
            1,
        ),
        (
            "/materials/0/pbrMetallicRoughness/baseColorTexture/index",
            "materials[0]",
            "texture",
            1,
        ),
        ("/textures/0/source", "textures[0]", "image", 1),
        ("/textures/0/sampler", "textures[0]", "sampler", 1),
        ("/accessors/0/bufferView", "accessors[0]", "bufferView", 7),
        ("/bufferViews/0/buffer", "bufferViews[0]", "buffer", 1),
        (
            "/animations/0/channels/0/sampler",
            "channels[0]",
            "sampler",
            1,
        ),
        (
            "/animations/0/channels/0/target/node",
            "channels[0]",
            "node",
            3,
        ),
    ] {
        for index in [count as u64, 77, u64::from(u32::MAX) - 1] {
            let refers = format!("{element}: refers to {what} {index}, but there are {count};");
            refused_with(pointer, json!(index), &[&refers, "correct the index"]);
        }
    }
}

#[test]
fn ranges_beyond_their_data_are_named() {
    let again = "export the file again";
    refused_with(
        "/accessors/0/count",
        json!(5),
        &["accessors[0]", "5 elements of 12 bytes", "48 bytes", again],
    );
    refused_with(
        "/accessors/0/count",
        json!(u64::MAX),
        &["accessors[0]", again],
    );
    refused_with(
        "/bufferViews/0/byteLength",
        json!(1_000_000),
        &["bufferViews[0]", "1000000 bytes", again],
    );
    refused_with(
        "/bufferViews/0/byteOffset",
        json!(u64::MAX),
        &["bufferViews[0]", "18446744073709551615", again],
    );
    refused_with(
        "/accessors/2/count",
        json!(3),
        &[
            "attributes.NORMAL",
            "3 elements beside 4 positions",
            "give one",
        ],
    );
}

#[test]
fn words_that_gltf_does_not_know_are_quoted_with_those_it_knows() {
    refused_with(
        "/meshes/0/primitives/0",
        json!({"attributes": {"POSITION": 0}, "mode": 9}),
        &["meshes[0].primitives[0]", "mode 9", "must be 0 to 6"],
    );
    refused_with(
        "/accessors/0/componentType",
        json!(5130),
        &["accessors[0]", "componentType 5130", "5126"],
    );
    refused_with(
        "/accessors/0/type",
        json!("VEC5"),
        &["accessors[0]", "type \"VEC5\"", "VEC2 to VEC4"],
    );
    refused_with(
        "/accessors/1/componentType",
        json!(5122),
        &["accessors[1]", "I16", "unsigned integers", "5123"],
    );
    refused_with(
        "/materials/0",
        json!({"alphaMode": "GLASS"}),
        &["materials[0]", "\"GLASS\"", "OPAQUE, MASK or BLEND"],
    );
    refused_with(
        "/extensions/KHR_lights_punctual/lights/0/type",
        json!("lava"),
        &["lights[0]", "\"lava\"", "directional, point or spot"],
    );
    refused_with(
        "/animations/0/samplers/0",
        json!({"input": 4, "output": 5, "interpolation": "WAVY"}),
        &["channels[0]", "\"WAVY\"", "LINEAR, STEP or CUBICSPLINE"],
    );
}

/// A sampler that is not understood does not take the picture away.
#[test]
fn samplers_that_gltf_does_not_know_are_a_warning() {
    let mut doc = Doc::square();
    let texture = doc.view(&super::textures::png(2, 2, [255; 4]));
    doc.root["images"] = json!([{"bufferView": texture}]);
    doc.root["samplers"] = json!([{"wrapS": 4242}]);
    doc.root["textures"] = json!([{"source": 0, "sampler": 0}]);
    doc.at("/materials/0/pbrMetallicRoughness")["baseColorTexture"] = json!({"index": 0});
    let drawn = drawn(&doc).warns(&[&["samplers[0]", "4242", "no effect"]]);
    drawn.is_the_square();
}

#[test]
fn nodes_that_contain_themselves_are_named() {
    let own = "is its own ancestor; remove the cycle";
    let cyclic = |children: &[(usize, Value)], parts: &[&str]| {
        let mut doc = Doc::square();
        for (node, children) in children {
            doc.root["nodes"][*node]["children"] = children.clone();
        }
        doc.root["scenes"] = json!([{"nodes": [0]}]);
        refused(&doc, parts);
        // Without scenes, the roots are those that are nobody's child.
        let root = doc.root.as_object_mut().unwrap();
        root.retain(|key, _| !key.starts_with("scene"));
        let folder = Folder::new();
        refused_file(&doc.write(&folder), &["nodes", "remove the cycle"]);
    };
    cyclic(
        &[(0, json!([0])), (1, json!([2])), (2, json!([1]))],
        &["nodes[0]", own],
    );
    cyclic(
        &[(0, json!([1])), (1, json!([0])), (2, json!([2]))],
        &["nodes[0]", own],
    );
    cyclic(
        &[(0, json!([1])), (1, json!([2])), (2, json!([0]))],
        &["nodes[0]", own],
    );
}

#[test]
fn nodes_with_two_parents_are_named() {
    let mut doc = Doc::square();
    doc.root["nodes"][1]["children"] = json!([0]);
    refused(&doc, &["nodes[0]", "twice", "give every node one parent"]);
}
