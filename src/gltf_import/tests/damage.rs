//! Damaged bytes and files: refused with a message that names file and fault, and never a panic.
use super::malformed::full;
use super::*;

#[test]
fn broken_bytes_are_named() {
    let broken = |breaking: &dyn Fn(&mut Gltf), parts: &[&str]| {
        let mut gltf = full();
        breaking(&mut gltf);
        let text = gltf.try_import().unwrap_err().to_string();
        assert!(parts.iter().all(|part| text.contains(part)), "{text}");
    };
    let start = |gltf: &Gltf, accessor: usize| {
        let view = gltf.root["accessors"][accessor]["bufferView"]
            .as_u64()
            .unwrap() as usize;
        gltf.root["bufferViews"][view]["byteOffset"]
            .as_u64()
            .unwrap() as usize
    };
    broken(
        &|g| g.bin[..4].copy_from_slice(&f32::NAN.to_le_bytes()),
        &["mesh 0 \"meshes[0].primitives[0]\", vertex 0", "NaN"],
    );
    broken(
        &|g| {
            let at = start(g, 4);
            g.bin[at + 1] = 3;
        },
        &["primitives[0].indices", "vertex 3 at place 1", "3 vertices"],
    );
    broken(
        &|g| {
            let at = start(g, 2);
            g.bin[at] = 5;
        },
        &[
            "mesh 0 \"meshes[0].primitives[0]\", vertex 0",
            "joint 5",
            "there are 1",
        ],
    );
    broken(
        &|g| {
            let view = g.root["accessors"][0]["sparse"]["indices"]["bufferView"]
                .as_u64()
                .unwrap() as usize;
            let at = g.root["bufferViews"][view]["byteOffset"].as_u64().unwrap() as usize;
            g.bin[at] = 3;
        },
        &["accessors[0]", "sparse index 3"],
    );
    broken(
        &|g| {
            let at = start(g, 5);
            g.bin[at..at + 4].copy_from_slice(&9f32.to_le_bytes());
        },
        &["animation 0, channel 0", "time of keyframe 1"],
    );
}

#[test]
fn buffers_that_cannot_be_read_are_named() {
    let gltf = full();
    let folder = Folder::new();
    folder.write("short.bin", b"1234");
    let length = gltf.bin.len();
    for (buffer, parts) in [
        (
            json!({"byteLength": length, "uri": "gone.bin"}),
            &["gone.bin", "cannot read"][..],
        ),
        (
            json!({"byteLength": length, "uri": "short.bin"}),
            &["short.bin is cut off", "it has 4"],
        ),
        (
            json!({"byteLength": length, "uri": "data:;base64,AAAA"}),
            &["buffers[0]", "it has 3"],
        ),
        (
            json!({"byteLength": length, "uri": "data:;base64,A?"}),
            &["buffers[0]", "'?'"],
        ),
        (
            json!({"byteLength": length, "uri": "https://x.y/z.bin"}),
            &["buffers[0]", "https", "download"],
        ),
        (json!({"byteLength": length}), &["buffer 0 has neither"]),
    ] {
        let mut root = gltf.root.clone();
        root["buffers"][0] = buffer;
        let text = refusal(&folder.write("test.gltf", root.to_string()));
        assert!(parts.iter().all(|part| text.contains(part)), "{text}");
    }
}

#[test]
fn files_that_are_not_gltf_are_named() {
    let folder = Folder::new();
    let text = refusal(&folder.0.join("nothing.gltf"));
    assert!(
        text.contains("nothing.gltf") && text.contains("cannot read"),
        "{text}"
    );
    for (content, part) in [
        ("", "JSON"),
        ("not json", "line 1"),
        ("[]", "asset.version"),
        ("{}", "asset.version"),
        (r#"{"asset": {"version": "1.0"}}"#, "glTF 1.0"),
        (
            r#"{"asset": {"version": "2.0", "minVersion": "2.1"}}"#,
            "needs glTF 2.1",
        ),
        ("glTF", "header is cut off"),
        ("glTF\u{1}\0\0\0\u{c}\0\0\0", "version 1"),
        ("glTF\u{2}\0\0\0\u{c}\0\0\0", "no JSON chunk"),
        ("glTF\u{2}\0\0\0\u{5}\0\0\0", "no JSON chunk"),
        ("glTF\u{2}\0\0\0\u{1c}\0\0\0", "cut off"),
        (
            "glTF\u{2}\0\0\0\u{14}\0\0\0\u{7f}\0\0\0JSON",
            "chunk at byte 12",
        ),
    ] {
        let text = refusal(&folder.write("test.gltf", content));
        assert!(
            text.contains(part) && text.contains("test.gltf"),
            "{content:?}: {text}"
        );
    }
}

#[test]
fn required_extensions_that_are_missing_are_an_error_with_a_remedy() {
    let mut gltf = Gltf::triangle();
    gltf.root["extensionsRequired"] =
        json!(["KHR_mesh_quantization", "KHR_draco_mesh_compression"]);
    let text = gltf.try_import().unwrap_err().to_string();
    assert!(
        text.contains("requires KHR_draco_mesh_compression,") && text.contains("without Draco"),
        "{text}"
    );
    gltf.root["extensionsRequired"] = json!(["EXT_texture_webp", "VENDOR_magic"]);
    let text = gltf.try_import().unwrap_err().to_string();
    assert!(
        text.contains("EXT_texture_webp, VENDOR_magic") && text.contains("PNG or JPEG"),
        "{text}"
    );
}

/// Every number of the document replaced by ones that break something: an error or not, but never a panic.
#[test]
fn no_number_makes_the_import_panic() {
    fn pointers(value: &Value, path: String, out: &mut Vec<String>) {
        match value {
            Value::Number(_) => out.push(path),
            Value::Array(list) => {
                list.iter()
                    .enumerate()
                    .for_each(|(i, value)| pointers(value, format!("{path}/{i}"), out));
            }
            Value::Object(map) => map
                .iter()
                .for_each(|(key, value)| pointers(value, format!("{path}/{key}"), out)),
            _ => {}
        }
    }
    let gltf = full();
    let folder = Folder::new();
    let document: Value = serde_json::from_str(&gltf.text()).unwrap();
    let mut places = Vec::new();
    pointers(&document, String::new(), &mut places);
    assert!(places.len() > 90, "{}", places.len());
    for place in places {
        for number in [
            json!(0),
            json!(1),
            json!(-1),
            json!(3),
            json!(1e39),
            json!(u32::MAX),
            json!(u64::MAX),
        ] {
            let mut broken = document.clone();
            *broken.pointer_mut(&place).unwrap() = number;
            // Reading is what is tested; either answer is fine.
            let _ = load(&folder.write("test.gltf", broken.to_string()));
        }
    }
}

/// A GLB cut at every length, and with single bytes changed: never a panic.
#[test]
fn no_damage_to_a_glb_makes_the_import_panic() {
    let glb = full().glb();
    let folder = Folder::new();
    let whole = load(&folder.write("whole.glb", &glb)).unwrap();
    assert_eq!(whole.warnings, [""; 0]);
    for length in (0..glb.len()).step_by(7) {
        refusal(&folder.write("cut.glb", &glb[..length]));
    }
    let mut random = 1u32;
    let mut next = || {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (random >> 8) as usize
    };
    for _ in 0..2000 {
        let mut damaged = glb.clone();
        let at = next() % glb.len();
        damaged[at] = next() as u8;
        let _ = load(&folder.write("damaged.glb", damaged));
    }
}
