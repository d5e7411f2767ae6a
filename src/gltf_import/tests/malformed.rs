//! Documents that contradict themselves: each is refused with a message that names file and fault.
use super::*;

/// The triangle with one of everything that can refer to something else.
pub(super) fn full() -> Gltf {
    let mut gltf = Gltf::triangle();
    super::materials::add_texture(&mut gltf);
    let joints = gltf.accessor(UNSIGNED_BYTE, "VEC4", 3, &[0; 12]);
    let weights = gltf.floats("VEC4", &[1., 0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0.]);
    let indices = gltf.accessor(UNSIGNED_BYTE, "SCALAR", 3, &[0, 1, 2]);
    let times = gltf.floats("SCALAR", &[0., 1.]);
    let moves = gltf.floats("VEC3", &[0., 0., 0., 1., 0., 0.]);
    let turns = gltf.floats("VEC4", &[0., 0., 0., 1., 0., 1., 0., 0.]);
    let mut identity = [0.0; 16];
    (0..4).for_each(|d| identity[5 * d] = 1.0);
    let bind = gltf.floats("MAT4", &identity);
    let (places, values) = (gltf.view(&[1]), gltf.view(&little_endian(&[2., 0., 0.])));
    gltf.root["accessors"][0]["sparse"] = json!({
        "count": 1,
        "indices": {"bufferView": places, "componentType": UNSIGNED_BYTE},
        "values": {"bufferView": values},
    });
    gltf.primitive()["attributes"]["JOINTS_0"] = json!(joints);
    gltf.primitive()["attributes"]["WEIGHTS_0"] = json!(weights);
    gltf.primitive()["indices"] = json!(indices);
    gltf.primitive()["mode"] = json!(4);
    gltf.root["samplers"] = json!([{"wrapS": 33071}]);
    gltf.root["textures"][0]["sampler"] = json!(0);
    gltf.root["materials"][0]["alphaMode"] = json!("MASK");
    gltf.root["cameras"] =
        json!([{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]);
    gltf.root["extensions"] =
        json!({"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 1}]}});
    gltf.root["skins"] = json!([{"joints": [1], "inverseBindMatrices": bind}]);
    gltf.root["nodes"] = json!([
        {"mesh": 0, "skin": 0, "children": [1], "camera": 0},
        {"extensions": {"KHR_lights_punctual": {"light": 0}}},
    ]);
    gltf.root["scenes"] = json!([{"nodes": [0]}]);
    gltf.root["scene"] = json!(0);
    gltf.root["animations"] = json!([{
        "samplers": [{"input": times, "output": moves}, {"input": times, "output": turns}],
        "channels": [
            {"sampler": 0, "target": {"node": 1, "path": "translation"}},
            {"sampler": 1, "target": {"node": 1, "path": "rotation"}},
        ],
    }]);
    gltf
}

/// Sets the value at a JSON pointer and expects a refusal whose text has the file's name and all parts.
fn refused(pointer: &str, value: Value, parts: &[&str]) {
    let mut gltf = full();
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    let parent = gltf
        .root
        .pointer_mut(parent)
        .unwrap_or_else(|| panic!("no {parent}"));
    match parent {
        Value::Array(list) => list[key.parse::<usize>().unwrap()] = value,
        other => other[key] = value,
    }
    match gltf.try_import() {
        Ok(_) => panic!("{pointer}: accepted"),
        Err(error) => {
            let text = error.to_string();
            let missing = parts
                .iter()
                .chain(&["test.gltf"])
                .find(|part| !text.contains(**part));
            assert_eq!(missing, None, "{pointer}: {text}");
        }
    }
}

#[test]
fn the_unbroken_file_is_accepted() {
    let scene = full().scene();
    assert_eq!(
        (scene.lights.len(), scene.cameras.len(), scene.skins.len()),
        (1, 1, 1)
    );
}

#[test]
fn references_to_nothing_are_named() {
    let n = || json!(77);
    refused("/scene", n(), &["scene 77", "there are 1"]);
    refused("/scenes/0/nodes/0", n(), &["node 77", "there are 2"]);
    refused(
        "/nodes/0/children/0",
        n(),
        &["nodes[0].children", "node 77"],
    );
    refused("/nodes/0/mesh", n(), &["nodes[0]", "mesh 77"]);
    refused("/nodes/0/skin", n(), &["nodes[0]", "skin 77"]);
    refused("/nodes/0/camera", n(), &["nodes[0]", "camera 77"]);
    refused(
        "/nodes/1/extensions/KHR_lights_punctual/light",
        n(),
        &["nodes[1]", "light 77"],
    );
    refused("/skins/0/joints/0", n(), &["skins[0]", "node 77"]);
    refused(
        "/skins/0/inverseBindMatrices",
        n(),
        &["skins[0]", "accessor 77"],
    );
    refused(
        "/meshes/0/primitives/0/attributes/POSITION",
        n(),
        &["primitives[0].attributes.POSITION", "accessor 77"],
    );
    refused(
        "/meshes/0/primitives/0/indices",
        n(),
        &["primitives[0].indices", "accessor 77"],
    );
    refused(
        "/meshes/0/primitives/0/material",
        n(),
        &["meshes[0].primitives[0]", "material 77"],
    );
    refused(
        "/materials/0/pbrMetallicRoughness/baseColorTexture/index",
        n(),
        &["materials[0]", "texture 77"],
    );
    refused("/textures/0/source", n(), &["textures[0]", "image 77"]);
    refused("/textures/0/sampler", n(), &["textures[0]", "sampler 77"]);
    refused(
        "/accessors/0/bufferView",
        n(),
        &["accessors[0]", "bufferView 77"],
    );
    refused(
        "/accessors/0/sparse/values/bufferView",
        n(),
        &["accessors[0]", "bufferView 77"],
    );
    refused(
        "/bufferViews/0/buffer",
        n(),
        &["bufferViews[0]", "buffer 77"],
    );
    refused(
        "/animations/0/channels/0/sampler",
        n(),
        &["animations[0].channels[0]", "sampler 77"],
    );
    refused(
        "/animations/0/channels/0/target/node",
        n(),
        &["animations[0].channels[0]", "node 77"],
    );
    refused("/animations/0/samplers/0/output", n(), &["accessor 77"]);
}

#[test]
fn ranges_beyond_their_data_are_named() {
    let huge = || json!(u64::MAX);
    refused(
        "/accessors/0/count",
        json!(4),
        &["accessors[0]", "4 elements of 12 bytes", "36 bytes"],
    );
    refused("/accessors/0/count", huge(), &["accessors[0]"]);
    refused(
        "/accessors/0/byteOffset",
        json!(4),
        &["accessors[0]", "from byte 4"],
    );
    refused("/accessors/0/byteOffset", huge(), &["accessors[0]"]);
    refused(
        "/accessors/0/sparse/count",
        json!(2),
        &["accessors[0]", "2 elements of 1 bytes"],
    );
    refused("/accessors/0/sparse/count", huge(), &["accessors[0]"]);
    refused(
        "/accessors/0/sparse/values/byteOffset",
        huge(),
        &["accessors[0]"],
    );
    refused(
        "/bufferViews/0/byteLength",
        json!(1_000_000),
        &["bufferViews[0]", "1000000 bytes"],
    );
    refused("/bufferViews/0/byteOffset", huge(), &["bufferViews[0]"]);
    refused(
        "/bufferViews/0/byteStride",
        json!(8),
        &["accessors[0]", "byteStride is 8"],
    );
    refused("/bufferViews/0/byteStride", json!(0), &["byteStride is 0"]);
    refused(
        "/accessors/0",
        json!({"componentType": FLOAT, "type": "VEC3", "count": 1u64 << 40}),
        &["accessors[0]"],
    );
}

#[test]
fn contradictions_are_named() {
    refused(
        "/meshes/0/primitives/0/attributes/TEXCOORD_0",
        json!(4),
        &["TEXCOORD_0", "accessors[4]"],
    );
    refused(
        "/meshes/0/primitives/0/attributes/NORMAL",
        json!(6),
        &["NORMAL", "2 elements beside 3 positions"],
    );
    refused(
        "/meshes/0/primitives/0/attributes/JOINTS_0",
        json!(3),
        &["accessors[3]", "unsigned integers"],
    );
    refused(
        "/meshes/0/primitives/0/indices",
        json!(5),
        &["accessors[5]", "unsigned integers"],
    );
    refused(
        "/meshes/0/primitives/0/mode",
        json!(9),
        &["meshes[0].primitives[0]", "mode"],
    );
    refused(
        "/materials/0/alphaMode",
        json!("GLASS"),
        &["materials[0]", "alphaMode"],
    );
    refused(
        "/materials/0/emissiveFactor",
        json!([1e39, 0, 0]),
        &["material 0", "emission", "inf"],
    );
    refused(
        "/accessors/0/componentType",
        json!(5130),
        &["accessors[0]", "componentType"],
    );
    refused(
        "/accessors/0/type",
        json!("VEC5"),
        &["accessors[0]", "type"],
    );
    refused(
        "/accessors/0/sparse/indices/componentType",
        json!(FLOAT),
        &["accessors[0]", "sparse"],
    );
    refused(
        "/animations/0/samplers/0/interpolation",
        json!("WAVY"),
        &["channels[0]", "interpolation"],
    );
    refused(
        "/animations/0/samplers/0/interpolation",
        json!("CUBICSPLINE"),
        &["animation 0", "3 for each of 2"],
    );
    refused(
        "/animations/0/samplers/0/output",
        json!(7),
        &["accessors[7]", "Vec4"],
    );
    refused("/skins/0/joints", json!([1, 0]), &["skins[0]", "2 joints"]);
    refused(
        "/extensions/KHR_lights_punctual/lights/0/type",
        json!("lava"),
        &["lights[0]", "spot"],
    );
    refused(
        "/extensions/KHR_lights_punctual/lights/0/intensity",
        json!(-1),
        &["light 0", "intensity"],
    );
    refused(
        "/nodes/1/translation",
        json!([0, 1e39, 0]),
        &["node 1", "translation"],
    );
    refused(
        "/accessors/0/count",
        json!("many"),
        &["accessors[0]", "many"],
    );
    refused("/meshes/0/primitives", json!(null), &["meshes[0]"]);
    refused("/nodes", json!({}), &["nodes is not a list"]);
}

#[test]
fn hierarchies_must_be_trees() {
    refused(
        "/nodes/1/children",
        json!([0]),
        &["nodes[0]", "its own ancestor"],
    );
    refused(
        "/nodes/1/children",
        json!([1]),
        &["nodes[1]", "its own ancestor"],
    );
    refused("/scenes/0/nodes", json!([0, 1]), &["nodes[1]", "twice"]);
    let mut gltf = full();
    gltf.root
        .as_object_mut()
        .unwrap()
        .retain(|key, _| !key.starts_with("scene"));
    gltf.root["nodes"][1]["children"] = json!([0]);
    let error = gltf.try_import().unwrap_err().to_string();
    assert!(error.contains("remove the cycle"), "{error}");
}

/// A chain far deeper than any stack.
#[test]
fn deep_hierarchies_are_walked_without_recursion() {
    let mut gltf = Gltf::triangle();
    let depth = 100_000;
    let mut nodes: Vec<Value> = (1..depth)
        .map(|child| json!({"children": [child]}))
        .collect();
    nodes.push(json!({"mesh": 0}));
    gltf.root["nodes"] = Value::Array(nodes);
    let scene = gltf.scene();
    assert_eq!(scene.nodes[depth - 1].meshes, [0]);
    assert_eq!(scene.pose(&[]).world.len(), depth);
}
