use super::*;
use gibs_passes::scene::Mesh;
use glam::{Vec2, Vec3};

/// A unit square as four corners, drawn by one node, with the given indices.
fn square(component: u32, indices: &[u8], count: usize) -> Gltf {
    let mut gltf = Gltf::triangle();
    let positions = gltf.floats("VEC3", &[0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.]);
    let indices = gltf.accessor(component, "SCALAR", count, indices);
    *gltf.primitive() = json!({"attributes": {"POSITION": positions}, "indices": indices});
    gltf
}

fn mesh(gltf: &Gltf) -> Mesh {
    let mut scene = gltf.scene();
    assert_eq!(scene.meshes.len(), 1);
    scene.meshes.remove(0)
}

#[test]
fn indices_of_every_width_are_read() {
    let corners = [0u32, 1, 2, 2, 3, 0];
    let bytes = corners.map(|c| c as u8);
    let shorts: Vec<u8> = corners
        .iter()
        .flat_map(|&c| (c as u16).to_le_bytes())
        .collect();
    let words: Vec<u8> = corners.iter().flat_map(|c| c.to_le_bytes()).collect();
    for (component, indices) in [
        (UNSIGNED_BYTE, &bytes[..]),
        (UNSIGNED_SHORT, &shorts),
        (UNSIGNED_INT, &words),
    ] {
        assert_eq!(
            mesh(&square(component, indices, 6)).triangles,
            [[0, 1, 2], [2, 3, 0]]
        );
    }
}

#[test]
fn strips_and_fans_keep_their_facing() {
    let front = |mesh: &Mesh| {
        mesh.triangles.iter().all(|t| {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            (b - a).cross(c - a).z > 0.0
        })
    };
    // The repeated corner of the strip turns it around and draws nothing itself.
    for (mode, corners, count) in [
        (5, &[0u8, 1, 3, 2][..], 2),
        (5, &[0, 1, 3, 2, 2, 3][..], 2),
        (6, &[0, 1, 2, 3], 2),
    ] {
        let mut gltf = square(UNSIGNED_BYTE, corners, corners.len());
        gltf.primitive()["mode"] = json!(mode);
        let mesh = mesh(&gltf);
        assert_eq!(mesh.triangles.len(), count, "mode {mode}");
        assert!(front(&mesh), "mode {mode}: {:?}", mesh.triangles);
    }
}

#[test]
fn primitives_without_indices_draw_every_vertex() {
    let mesh = mesh(&Gltf::triangle());
    assert_eq!(mesh.triangles, [[0, 1, 2]]);
    assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert!(mesh.normals.is_empty() && mesh.uvs.is_empty());
}

#[test]
fn points_and_lines_are_left_out_with_one_warning() {
    let mut gltf = Gltf::triangle();
    for mode in [0, 1, 2, 3] {
        let primitive = json!({"attributes": {"POSITION": 0}, "mode": mode});
        push(&mut gltf.root["meshes"][0]["primitives"], primitive);
    }
    let imported = gltf.import();
    only_warning(&imported, "points and lines");
    assert_eq!(imported.scene.meshes.len(), 1);
}

#[test]
fn a_rest_of_corners_is_ignored_with_a_warning() {
    let imported = square(UNSIGNED_BYTE, &[0, 1, 2, 2], 4).import();
    only_warning(&imported, "4 corners");
    assert_eq!(imported.scene.meshes[0].triangles, [[0, 1, 2]]);
}

/// Two primitives that share one large accessor each keep only the vertices that they draw.
#[test]
fn shared_accessors_are_not_copied_whole() {
    let mut gltf = Gltf::triangle();
    let many: Vec<f32> = (0..3000).map(|i| (i * i % 997) as f32).collect();
    let positions = gltf.floats("VEC3", &many);
    let indices = gltf.accessor(UNSIGNED_SHORT, "SCALAR", 3, &[0x84, 3, 7, 0, 0xe7, 3]);
    *gltf.primitive() = json!({"attributes": {"POSITION": positions}, "indices": indices});
    let mesh = mesh(&gltf);
    assert_eq!(mesh.positions.len(), 3);
    let vertex = |v: usize| Vec3::from_slice(&many[3 * v..]);
    let drawn = mesh.triangles[0].map(|v| mesh.positions[v as usize]);
    assert_eq!(drawn, [vertex(900), vertex(7), vertex(999)]);
}

/// KHR_mesh_quantization: strided bytes, plain or normalized (glTF 2.0, 3.6.2.2).
#[test]
fn quantized_attributes_are_decoded() {
    let mut gltf = Gltf::triangle();
    gltf.root["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    gltf.root["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let shorts = |v: &[i16]| v.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    // Each vertex takes four shorts of which the last is padding.
    let positions = shorts(&[0, 0, 0, 9, 32767, 0, 0, 9, 0, -32768, 0, 9]);
    let positions = gltf.accessor(SHORT, "VEC3", 3, &positions);
    let normals = gltf.accessor(BYTE, "VEC3", 3, &[0, 0, 127, 9, 0, 0, 127, 9, 0, 0, 127]);
    let uvs = gltf.accessor(
        UNSIGNED_SHORT,
        "VEC2",
        3,
        &[0, 0, 0xff, 0xff, 0xff, 0xff, 0, 0, 0x33, 0x33, 0, 0],
    );
    for (accessor, stride, normalized) in [(positions, 8, true), (normals, 4, true), (uvs, 4, true)]
    {
        let view = gltf.root["accessors"][accessor]["bufferView"]
            .as_u64()
            .unwrap() as usize;
        gltf.root["accessors"][accessor]["normalized"] = json!(normalized);
        gltf.root["bufferViews"][view]["byteStride"] = json!(stride);
    }
    *gltf.primitive() = json!({"attributes": {"POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs}, "material": 0});
    super::materials::add_texture(&mut gltf);
    let read = mesh(&gltf);
    // -32768 is clamped to -1.
    assert_eq!(read.positions, [Vec3::ZERO, Vec3::X, Vec3::NEG_Y]);
    assert_eq!(read.normals, [Vec3::Z; 3]);
    assert_eq!(
        read.uvs,
        [
            Vec2::new(0.0, 1.0),
            Vec2::new(1.0, 0.0),
            Vec2::new(0.2, 0.0)
        ]
    );

    gltf.root["accessors"][positions]["normalized"] = json!(false);
    assert_eq!(mesh(&gltf).positions[2], Vec3::new(0.0, -32768.0, 0.0));
    let bytes = gltf.accessor(
        UNSIGNED_BYTE,
        "VEC3",
        3,
        &[0, 0, 0, 0, 255, 0, 0, 0, 0, 7, 0],
    );
    let view = gltf.root["accessors"][bytes]["bufferView"]
        .as_u64()
        .unwrap() as usize;
    gltf.root["bufferViews"][view]["byteStride"] = json!(4);
    gltf.primitive()["attributes"]["POSITION"] = json!(bytes);
    assert_eq!(
        mesh(&gltf).positions,
        [Vec3::ZERO, Vec3::X * 255.0, Vec3::Y * 7.0]
    );
}

#[test]
fn sparse_accessors_replace_elements_of_their_base_or_of_zero() {
    let mut gltf = Gltf::triangle();
    let places = gltf.view(&[1, 2]);
    let values = gltf.view(&little_endian(&[2., 0., 0., 0., 5., 0.]));
    gltf.root["accessors"][0]["sparse"] = json!({
        "count": 2,
        "indices": {"bufferView": places, "componentType": UNSIGNED_BYTE},
        "values": {"bufferView": values},
    });
    let expected = [Vec3::ZERO, Vec3::X * 2.0, Vec3::Y * 5.0];
    assert_eq!(mesh(&gltf).positions, expected);
    gltf.root["accessors"][0]
        .as_object_mut()
        .unwrap()
        .remove("bufferView");
    assert_eq!(mesh(&gltf).positions, expected);
}

#[test]
fn unsupported_attributes_are_named_once() {
    let mut gltf = Gltf::triangle();
    gltf.primitive()["attributes"]["COLOR_0"] = json!(0);
    gltf.primitive()["targets"] = json!([{"POSITION": 0}]);
    gltf.primitive()["attributes"]["_CUSTOM"] = json!(0);
    let primitive = gltf.primitive().clone();
    push(&mut gltf.root["meshes"][0]["primitives"], primitive);
    let warnings = gltf.import().warnings;
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(warnings[0].contains("morph targets") && warnings[1].contains("vertex colours"));
}

#[test]
fn one_mesh_may_hang_on_many_nodes() {
    let mut gltf = Gltf::triangle();
    gltf.root["nodes"] = json!([{"mesh": 0}, {"mesh": 0, "scale": [-1, 1, 1]}]);
    let scene = gltf.scene();
    assert_eq!(scene.meshes.len(), 1);
    assert_eq!(scene.nodes[0].meshes, [0]);
    assert_eq!(scene.nodes[1].meshes, [0]);
    assert!(scene.pose(&[]).world[1].matrix3.determinant() < 0.0);
}
