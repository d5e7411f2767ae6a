//! Sound glTF documents that use much of the format, to be broken.
use crate::file::Doc;
use base64::Engine;
use image::{DynamicImage, ImageFormat, RgbImage};
use serde_json::{Value, json};

const UNSIGNED_BYTE: u32 = 5121;
const SHORT: u32 = 5122;
const FLOAT: u32 = 5126;

/// The sound documents.
pub fn seeds() -> Vec<Doc> {
    vec![Doc::square(), textured(), moving(), stored()]
}

fn accessor(doc: &mut Doc, component: u32, kind: &str, count: usize, bytes: &[u8]) -> usize {
    let view = doc.view(bytes);
    doc.push(
        "/accessors",
        json!({"bufferView": view, "componentType": component, "type": kind, "count": count}),
    )
}

fn floats(doc: &mut Doc, kind: &str, count: usize, values: &[f32]) -> usize {
    let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    accessor(doc, FLOAT, kind, count, &bytes)
}

/// A picture of 4x3 as a file.
pub fn picture(format: ImageFormat) -> Vec<u8> {
    let image = RgbImage::from_fn(4, 3, |x, y| image::Rgb([x as u8 * 60, y as u8 * 90, 128]));
    let mut out = std::io::Cursor::new(Vec::new());
    DynamicImage::from(image)
        .write_to(&mut out, format)
        .expect("memory takes it");
    out.into_inner()
}

/// Every way to store an image, every kind of material.
fn textured() -> Doc {
    let mut doc = Doc::square();
    let png = doc.view(&picture(ImageFormat::Png));
    let jpeg = base64::engine::general_purpose::STANDARD.encode(picture(ImageFormat::Jpeg));
    doc.root["images"] = json!([
        {"bufferView": png, "mimeType": "image/png"},
        {"uri": format!("data:image/jpeg;base64,{jpeg}")},
    ]);
    doc.root["samplers"] = json!([{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728}]);
    doc.root["textures"] = json!([{"source": 0, "sampler": 0}, {"source": 1}]);
    doc.root["materials"] = json!([
        {
            "name": "picture",
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.5, 0.4, 0.3, 0.9],
                "baseColorTexture": {"index": 0, "texCoord": 0, "extensions": {
                    "KHR_texture_transform": {"offset": [0.1, 0.2], "rotation": 0.3, "scale": [2, 2]},
                }},
            },
            "emissiveTexture": {"index": 1},
            "emissiveFactor": [1, 0.5, 0.1],
            "alphaMode": "MASK", "alphaCutoff": 0.25, "doubleSided": true,
            "extensions": {
                "KHR_materials_emissive_strength": {"emissiveStrength": 4},
                "KHR_materials_transmission": {"transmissionFactor": 0.5},
            },
        },
        {"alphaMode": "BLEND", "extensions": {"KHR_materials_pbrSpecularGlossiness": {
            "diffuseFactor": [0.1, 0.2, 0.3, 0.4], "diffuseTexture": {"index": 0},
        }}},
    ]);
    let again = doc.root["meshes"][0]["primitives"][0].clone();
    doc.push("/meshes/0/primitives", again);
    *doc.at("/meshes/0/primitives/1/material") = json!(1);
    doc.root["extensionsUsed"] = json!([
        "KHR_lights_punctual",
        "KHR_texture_transform",
        "KHR_materials_emissive_strength",
        "KHR_materials_transmission",
        "KHR_materials_pbrSpecularGlossiness",
    ]);
    doc.root["extensions"]["KHR_lights_punctual"]["lights"] = json!([
        {"type": "directional", "intensity": 3, "color": [1, 0.9, 0.8]},
        {"type": "point", "intensity": 5, "range": 10},
        {"type": "spot", "intensity": 5, "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.6}},
    ]);
    for light in [1, 2] {
        doc.node(json!({
            "translation": [0, 0.5, 1], "rotation": [0, 0.1, 0, 0.99], "scale": [1, 2, 1],
            "extensions": {"KHR_lights_punctual": {"light": light}},
        }));
    }
    doc
}

/// A skin, a hierarchy, and clips of every interpolation.
fn moving() -> Doc {
    let mut doc = Doc::square();
    let joints = accessor(&mut doc, UNSIGNED_BYTE, "VEC4", 4, &[0, 1, 0, 0].repeat(4));
    let weights = floats(&mut doc, "VEC4", 4, &[0.25, 0.75, 0., 0.].repeat(4));
    let mut identity = [0.0; 16];
    (0..4).for_each(|d| identity[5 * d] = 1.0);
    let bind = floats(&mut doc, "MAT4", 2, &identity.repeat(2));
    let times = floats(&mut doc, "SCALAR", 2, &[0., 1.]);
    let moves = floats(&mut doc, "VEC3", 2, &[0., 0., 0., 0.5, 0., 0.]);
    let turns = floats(&mut doc, "VEC4", 2, &[0., 0., 0., 1., 0., 0., 0.6, 0.8]);
    let curves = floats(&mut doc, "VEC3", 6, &[1.; 18]);
    *doc.at("/meshes/0/primitives/0/attributes/POSITION") = json!(0);
    let attributes = doc.at("/meshes/0/primitives/0/attributes");
    attributes["JOINTS_0"] = json!(joints);
    attributes["WEIGHTS_0"] = json!(weights);
    doc.root["skins"] = json!([{"joints": [3, 4], "skeleton": 3, "inverseBindMatrices": bind}]);
    doc.root["nodes"][0]["skin"] = json!(0);
    doc.node(json!({"children": [4], "name": "hip"}));
    doc.push("/nodes", json!({"matrix": identity, "name": "knee"}));
    doc.root["animations"] = json!([{
        "name": "walk",
        "samplers": [
            {"input": times, "output": moves},
            {"input": times, "output": turns, "interpolation": "STEP"},
            {"input": times, "output": curves, "interpolation": "CUBICSPLINE"},
        ],
        "channels": [
            {"sampler": 0, "target": {"node": 3, "path": "translation"}},
            {"sampler": 1, "target": {"node": 3, "path": "rotation"}},
            {"sampler": 2, "target": {"node": 3, "path": "scale"}},
        ],
    }]);
    doc
}

/// Strips and fans, sparse and quantized accessors, strides, and a buffer within the document.
fn stored() -> Doc {
    let mut doc = Doc::square();
    let quantized: Vec<u8> = [
        [-100_i16, -100, 0, 0],
        [100, -100, 0, 0],
        [-100, 100, 0, 0],
        [100, 100, 0, 0],
    ]
    .iter()
    .flatten()
    .flat_map(|v| v.to_le_bytes())
    .collect();
    let positions = accessor(&mut doc, SHORT, "VEC3", 4, &quantized);
    let view = doc.root["accessors"][positions]["bufferView"].clone();
    doc.root["accessors"][positions]["normalized"] = json!(true);
    doc.root["bufferViews"][view.as_u64().expect("an index") as usize]["byteStride"] = json!(8);
    let places = doc.view(&[1, 3]);
    let values = doc.view(&[0; 12].map(|_: u8| 1).repeat(2));
    doc.root["accessors"][positions]["sparse"] = json!({
        "count": 2,
        "indices": {"bufferView": places, "componentType": UNSIGNED_BYTE, "byteOffset": 0},
        "values": {"bufferView": values, "byteOffset": 0},
    });
    let zeros = doc.push(
        "/accessors",
        json!({"componentType": FLOAT, "type": "VEC3", "count": 4}),
    );
    let primitive =
        |mode: u32, position: usize| json!({"attributes": {"POSITION": position}, "mode": mode});
    let list: Vec<Value> = vec![
        primitive(5, positions),
        primitive(6, 0),
        primitive(4, zeros),
        primitive(1, 0),
    ];
    for element in list {
        doc.push("/meshes/0/primitives", element);
    }
    doc.root["extensionsUsed"] = json!(["KHR_lights_punctual", "KHR_mesh_quantization"]);
    doc.root["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let bytes = base64::engine::general_purpose::STANDARD.encode(&doc.bin);
    doc.root["buffers"] = json!([{
        "byteLength": doc.bin.len(),
        "uri": format!("data:application/octet-stream;base64,{bytes}"),
    }]);
    doc
}

/// What is broken in the other tests is sound here.
#[test]
fn the_seeds_are_accepted_whole() {
    for (i, doc) in seeds().iter().enumerate() {
        let folder = crate::file::Folder::new();
        let scene = gibs::gltf_import::load(&doc.write(&folder))
            .unwrap_or_else(|e| panic!("{i}: {e}"))
            .scene;
        assert!(!scene.meshes.is_empty(), "{i}");
        let glb = folder.write("scene.glb", doc.glb());
        gibs::gltf_import::load(&glb).unwrap_or_else(|e| panic!("{i} as GLB: {e}"));
    }
}
