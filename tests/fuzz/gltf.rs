//! The scene loader.
use crate::edits::{byte_edits, edit_bytes, edit_json, json_edits};
use crate::file::{Doc, Folder};
use crate::gltf_seed::{picture, seeds};
use crate::watch::{cases, watched};
use gibs::gltf_import::{ImportError, load};
use gibs::passes::frame::Settings;
use gibs::view::View;
use gibs::{RenderError, Renderer};
use image::ImageFormat;
use proptest::prelude::*;
use proptest::sample::Index;
use serde_json::json;
use std::path::Path;

/// Reads a file; what is refused is refused with its name and a remedy, what is read is sound.
fn read(path: &Path) -> Option<gibs::gltf_import::Imported> {
    match load(path) {
        Ok(mut imported) => {
            assert!(imported.warnings.iter().all(|warning| !warning.is_empty()));
            let again = imported.scene.validate();
            assert!(
                again.is_ok(),
                "a scene that was read is not sound: {again:?}"
            );
            Some(imported)
        }
        Err(error) => {
            let text = error.to_string();
            // Of a file that the document refers to, the message names that.
            let named = match &error {
                ImportError::Read { file, .. } => file,
                _ => path,
            };
            assert!(
                text.contains(&*named.to_string_lossy()),
                "the message does not name the file: {text}"
            );
            assert!(
                text.contains(';') || text.contains(','),
                "the message has no remedy: {text}"
            );
            None
        }
    }
}

/// Draws what was read, small. All that may fail is a scene that is too large for the tree.
fn draw(path: &Path) {
    let Some(imported) = read(path) else { return };
    let scene = imported.scene;
    let view = View::framing(&scene);
    let settings = Settings {
        rays: 64,
        surfels: 256,
        ..Settings::default()
    };
    let backend = crate::common::cpu();
    let made = Renderer::new(backend.as_ref(), &scene, &view, [6, 4], &settings, 0);
    let mut renderer = match made {
        Ok(renderer) => renderer,
        Err(error @ RenderError::Backend(_)) => panic!("{error}"),
        Err(_) => return,
    };
    for _ in 0..2 {
        renderer
            .frame()
            .expect("a scene that was read can be drawn");
    }
    let picture = renderer.picture().expect("a frame has a picture");
    for (name, values) in &picture.channels {
        assert!(
            values.iter().all(|v| v.is_finite()),
            "{name} has {values:?}"
        );
    }
}

fn broken(seed: Index, edits: &[crate::edits::JsonEdit]) -> (Doc, serde_json::Value) {
    let seeds = seeds();
    let mut doc = seed.get(&seeds).clone();
    if doc.root["buffers"] == json!([{}]) {
        doc.root["buffers"] = json!([{"byteLength": doc.bin.len(), "uri": "scene.bin"}]);
    }
    let mut root = doc.root.clone();
    edit_json(&mut root, edits);
    (doc, root)
}

proptest! {
    #![proptest_config(cases(5000))]

    #[test]
    fn a_broken_document_is_read_or_refused(seed: Index, edits in json_edits()) {
        let (doc, root) = broken(seed, &edits);
        let folder = Folder::new();
        folder.write("scene.bin", &doc.bin);
        let path = folder.write("broken.gltf", root.to_string());
        watched(|| drop(read(&path)));
    }

    #[test]
    fn a_damaged_glb_is_read_or_refused(seed: Index, edits in byte_edits()) {
        let mut bytes = seed.get(&seeds()).glb();
        edit_bytes(&mut bytes, &edits);
        let folder = Folder::new();
        let path = folder.write("damaged.glb", bytes);
        watched(|| drop(read(&path)));
    }

    #[test]
    fn a_damaged_buffer_is_read_or_refused(seed: Index, edits in byte_edits()) {
        let mut doc = seed.get(&seeds()).clone();
        doc.root["buffers"] = json!([{"byteLength": doc.bin.len(), "uri": "scene.bin"}]);
        edit_bytes(&mut doc.bin, &edits);
        let folder = Folder::new();
        let path = doc.write(&folder);
        watched(|| drop(read(&path)));
    }
}

proptest! {
    #![proptest_config(cases(400))]

    #[test]
    fn a_damaged_picture_is_read_left_out_or_refused(jpeg: bool, edits in byte_edits()) {
        let format = if jpeg { ImageFormat::Jpeg } else { ImageFormat::Png };
        let mut bytes = picture(format);
        edit_bytes(&mut bytes, &edits);
        let mut doc = Doc::square();
        doc.root["images"] = json!([{"uri": "picture"}]);
        doc.root["textures"] = json!([{"source": 0}]);
        doc.at("/materials/0/pbrMetallicRoughness")["baseColorTexture"] = json!({"index": 0});
        let folder = Folder::new();
        folder.write("picture", &bytes);
        let path = doc.write(&folder);
        watched(|| {
            // One that can be decoded and is too large is the scene's fault.
            if let Some(imported) = read(&path) {
                prop_assert_eq!(imported.scene.textures.len() + imported.warnings.len(), 1);
            }
            Ok(())
        })?;
    }
}

proptest! {
    #![proptest_config(cases(150))]

    /// What the loader accepts is drawn, whatever its numbers are, and every value of the picture is finite.
    #[test]
    fn what_is_read_can_be_drawn(seed: Index, edits in json_edits(), bytes in prop::option::of(byte_edits())) {
        let (mut doc, root) = broken(seed, &edits);
        if let Some(edits) = bytes {
            let len = doc.bin.len();
            edit_bytes(&mut doc.bin, &edits);
            doc.bin.resize(len, 0);
        }
        let folder = Folder::new();
        folder.write("scene.bin", &doc.bin);
        let path = folder.write("broken.gltf", root.to_string());
        watched(|| draw(&path));
    }
}

/// A device that has no end, in place of a buffer or a picture.
#[cfg(unix)]
#[test]
fn a_device_in_place_of_a_file_is_refused() {
    let folder = Folder::new();
    let mut doc = Doc::square();
    doc.root["buffers"] = json!([{"byteLength": doc.bin.len(), "uri": "/dev/zero"}]);
    let error = load(&doc.write(&folder))
        .expect_err("it is no buffer")
        .to_string();
    assert!(
        error.contains("/dev/zero") && error.contains("device"),
        "{error}"
    );
    let mut doc = Doc::square();
    doc.root["images"] = json!([{"uri": "/dev/zero"}]);
    doc.root["textures"] = json!([{"source": 0}]);
    doc.at("/materials/0/pbrMetallicRoughness")["baseColorTexture"] = json!({"index": 0});
    let warnings = load(&doc.write(&folder))
        .expect("the rest is sound")
        .warnings;
    assert!(
        warnings.len() == 1 && warnings[0].contains("/dev/zero"),
        "{warnings:?}"
    );
}
