//! Files and parts of files that are truncated, missing or something else.
use super::file::{Doc, Folder};
use super::run::{drawn_file, refused, refused_file, refused_naming};
use serde_json::json;

/// What all other tests break is sound, in both forms, so that they cannot pass for another reason.
#[test]
fn the_unbroken_files_are_drawn_without_a_word() {
    let folder = Folder::new();
    let doc = Doc::square();
    let gltf = doc.write(&folder);
    drawn_file(&gltf, [24, 24]).warns(&[]).is_the_square();
    let glb = folder.write("whole.glb", doc.glb());
    drawn_file(&glb, [24, 24]).warns(&[]).is_the_square();
}

#[test]
fn files_that_are_not_there_or_not_gltf_are_named() {
    let folder = Folder::new();
    let missing = folder.0.join("missing.gltf");
    refused_file(&missing, &["cannot read", "check that the file is there"]);
    let inside = folder.0.join("folder.gltf");
    std::fs::create_dir(&inside).unwrap();
    refused_file(&inside, &["cannot read", "check that the file is there"]);
    for (content, parts) in [
        (&b""[..], &["line 1 column 0", "export it again"][..]),
        (&b"\x89PNG\r\n\x1a\n"[..], &["line 1", "export it again"]),
        (&[0xff; 64][..], &["line 1", "export it again"]),
        (b"[1, 2]", &["no asset.version", "give a glTF 2.0 file"]),
        (
            br#"{"asset": {"version": "1.0"}}"#,
            &["glTF 1.0", "export it as glTF 2.0"],
        ),
        (
            br#"{"asset": {"version": "2.0"}, "nodes": [{"mesh": -1}]}"#,
            &["nodes[0]", "-1", "correct it"],
        ),
    ] {
        refused_file(&folder.write("strange.gltf", content), parts);
    }
    let nested = "[".repeat(100_000);
    refused_file(
        &folder.write("nested.gltf", nested),
        &["recursion limit", "export it again"],
    );
}

#[test]
fn truncated_json_is_named_with_its_line() {
    let folder = Folder::new();
    let whole = std::fs::read(Doc::square().write(&folder)).unwrap();
    for length in [1, whole.len() / 3, whole.len() - 1] {
        let path = folder.write("cut.gltf", &whole[..length]);
        refused_file(&path, &["JSON is broken: EOF", "line 1", "export it again"]);
    }
}

#[test]
fn truncated_glbs_are_named_with_what_is_left() {
    let folder = Folder::new();
    let whole = Doc::square().glb();
    let text = u32::from_le_bytes(whole[12..16].try_into().unwrap()) as usize;
    // In the header; behind it; within the JSON; behind it; within the binary chunk.
    for length in [4, 11, 12, 100, 20 + text, 30 + text, whole.len() - 1] {
        let (found, told) = (length.to_string(), whole.len().to_string());
        let parts: &[&str] = match length {
            0..12 => &["header is cut off", "copy or export it again"],
            _ => &["is cut off", &told, &found, "copy or export it again"],
        };
        refused_file(&folder.write("cut.glb", &whole[..length]), parts);
    }
    // A header that agrees with the file's length, so that only the chunks can tell.
    let shortened = |length: usize| {
        let mut cut = whole[..length].to_vec();
        cut[8..12].copy_from_slice(&(length as u32).to_le_bytes());
        folder.write("cut.glb", cut)
    };
    refused_file(&shortened(12), &["no JSON chunk", "copy or export"]);
    refused_file(&shortened(100), &["chunk at byte 12", &text.to_string()]);
    refused_file(
        &shortened(20 + text),
        &["buffer 0", "add the buffer's file"],
    );
    refused_file(
        &shortened(whole.len() - 4),
        &[
            &format!("chunk at byte {}", 20 + text),
            "more than there are",
        ],
    );
}

#[test]
fn buffers_that_are_missing_or_short_are_named() {
    let doc = Doc::square();
    let length = doc.bin.len();
    let needed = length.to_string();
    let with = |buffer| {
        let mut doc = doc.clone();
        doc.root["buffers"] = json!([buffer]);
        doc
    };
    // What is missing is named, rather than the file that asks for it.
    let folder = Folder::new();
    let path = with(json!({"byteLength": length, "uri": "gone.bin"})).write(&folder);
    let parts = ["cannot read", "check that the file is there"];
    refused_naming(&path, "gone.bin", &parts);
    let short = with(json!({"byteLength": length + 1, "uri": "scene.bin"}));
    let more = (length + 1).to_string();
    refused(&short, &["buffers[0]", "scene.bin", &more, &needed, "copy"]);
    refused(
        &with(json!({"byteLength": length, "uri": "data:;base64,AAAA"})),
        &["buffers[0]", "data URI is cut off", &needed, "it has 3"],
    );
    refused(
        &with(json!({"byteLength": length, "uri": "data:;base64,AA*A"})),
        &["buffers[0]", "'*' at place 2", "export the file again"],
    );
    refused(
        &with(json!({"byteLength": length, "uri": "data:;base64,AAAAA"})),
        &["buffers[0]", "base64 text is cut off", "copy or export"],
    );
    refused(
        &with(json!({"byteLength": length, "uri": "https://a.example/b.bin"})),
        &["buffers[0]", "https", "download the file"],
    );
    refused(
        &with(json!({"byteLength": length})),
        &[
            "bufferViews",
            "buffer 0 has neither",
            "add the buffer's file",
        ],
    );
    refused(
        &with(json!({"byteLength": 40, "uri": "scene.bin"})),
        &[
            "bufferViews[0]",
            "48 bytes from byte 0",
            "40 bytes",
            "correct",
        ],
    );
}

#[test]
fn extensions_that_cannot_be_left_out_are_named() {
    let mut doc = Doc::square();
    doc.root["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    refused(
        &doc,
        &["KHR_draco_mesh_compression", "export it without Draco"],
    );
    doc.root["extensionsRequired"] = json!(["ACME_portals"]);
    refused(&doc, &["ACME_portals", "export it without them"]);
}
