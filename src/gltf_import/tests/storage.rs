use super::*;
use glam::Vec3;

const CORNERS: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::Y];

#[test]
fn buffers_come_from_data_uris_files_and_glb() {
    let gltf = Gltf::triangle();
    assert_eq!(gltf.scene().meshes[0].positions, CORNERS);

    let folder = Folder::new();
    let scene = load(&folder.write("a.glb", gltf.glb())).unwrap().scene;
    assert_eq!(scene.meshes[0].positions, CORNERS);
    assert_eq!(scene.name, "a");

    let mut root = gltf.root.clone();
    root["buffers"][0] = json!({"byteLength": gltf.bin.len(), "uri": "da%20ta%C3%BC.bin"});
    // A byte order mark is no reason to fail.
    let path = folder.write("b.gltf", format!("\u{feff}{root}"));
    folder.write("da ta\u{fc}.bin", &gltf.bin);
    assert_eq!(load(&path).unwrap().scene.meshes[0].positions, CORNERS);
}

#[test]
fn images_come_from_files_too() {
    let mut gltf = Gltf::triangle();
    super::materials::add_texture(&mut gltf);
    gltf.root["images"][0] = json!({"uri": "sub/t%23.png"});
    let folder = Folder::new();
    std::fs::create_dir(folder.0.join("sub")).unwrap();
    folder.write("sub/t#.png", png(3, 1, [1, 2, 3, 4]));
    let imported = load(&folder.write("a.glb", gltf.glb())).unwrap();
    assert_eq!(imported.warnings, [""; 0]);
    assert_eq!(imported.scene.textures[0].width, 3);
}

#[test]
fn jpeg_and_gray_images_become_rgba() {
    let folder = Folder::new();
    let gray = image::GrayImage::from_pixel(8, 8, image::Luma([200]));
    gray.save(folder.0.join("t.jpg")).unwrap();
    let mut gltf = Gltf::triangle();
    super::materials::add_texture(&mut gltf);
    gltf.root["images"][0] = json!({"uri": "t.jpg", "mimeType": "image/png"});
    let scene = load(&folder.write("a.gltf", gltf.text())).unwrap().scene;
    let texture = &scene.textures[0];
    assert_eq!((texture.width, texture.height), (8, 8));
    // A flat image survives JPEG to within one step.
    assert!(
        texture
            .texels
            .iter()
            .all(|t| t[..3].iter().all(|c| c.abs_diff(200) <= 1) && t[3] == 255)
    );
}

#[test]
fn unknown_glb_chunks_and_free_form_extras_are_skipped() {
    let mut gltf = Gltf::triangle();
    gltf.root["extras"] = json!(7);
    gltf.root["nodes"][0]["extras"] = json!(["any", {"thing": null}]);
    gltf.primitive()["extras"] = json!("text");
    let mut glb = gltf.glb();
    glb.extend(4u32.to_le_bytes());
    glb.extend(b"XYZW....");
    let length = (glb.len() as u32).to_le_bytes();
    glb[8..12].copy_from_slice(&length);
    let folder = Folder::new();
    let imported = load(&folder.write("a.glb", glb)).unwrap();
    assert_eq!(imported.warnings, [""; 0]);
    assert_eq!(imported.scene.meshes[0].positions, CORNERS);
}

#[test]
fn compressed_vertices_with_a_plain_copy_are_read_from_it() {
    let mut gltf = Gltf::triangle();
    gltf.root["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
    gltf.primitive()["extensions"] =
        json!({"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {}}});
    assert_eq!(gltf.scene().meshes[0].positions, CORNERS);
    gltf.root["accessors"][0]
        .as_object_mut()
        .unwrap()
        .remove("bufferView");
    let error = gltf.try_import().unwrap_err().to_string();
    assert!(
        error.contains("meshes[0].primitives[0]") && error.contains("without it"),
        "{error}"
    );

    let mut gltf = Gltf::triangle();
    gltf.root["extensionsUsed"] = json!(["EXT_meshopt_compression"]);
    gltf.root["bufferViews"][0]["extensions"] = json!({"EXT_meshopt_compression": {"buffer": 0}});
    assert_eq!(gltf.scene().meshes[0].positions, CORNERS);
    gltf.root["bufferViews"][0]["buffer"] = json!(1);
    push(&mut gltf.root["buffers"], json!({"byteLength": 36}));
    let error = gltf.try_import().unwrap_err().to_string();
    assert!(
        error.contains("bufferViews[0]") && error.contains("without meshopt"),
        "{error}"
    );
}

/// A few bytes of JSON would otherwise ask for any memory: an accessor without data counts each time that it is read.
#[test]
fn elements_without_data_have_one_budget() {
    let with_primitives = |count: usize| {
        let mut gltf = Gltf::triangle();
        // A multiple of three, so that five are within 2^26 and six are not.
        let indices = gltf.accessor(UNSIGNED_BYTE, "SCALAR", 3, &[0, 1, 2]);
        let accessor = &mut gltf.root["accessors"][indices];
        accessor.as_object_mut().unwrap().remove("bufferView");
        accessor["count"] = json!(3 * (1 << 22));
        let mut primitive = gltf.primitive().clone();
        primitive["indices"] = json!(indices);
        gltf.root["meshes"][0]["primitives"] = json!(vec![primitive; count]);
        gltf.try_import()
    };
    let Err(error) = with_primitives(6) else {
        panic!("so many are accepted");
    };
    let text = error.to_string();
    assert!(
        text.contains("no bufferView and 12582912 elements") && text.contains("accessors["),
        "{text}"
    );
    assert!(with_primitives(1).is_ok());
}
