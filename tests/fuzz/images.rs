//! The readers of environment maps and of pictures to compare.
use crate::edits::{byte_edits, edit_bytes};
use crate::file::Folder;
use crate::watch::{cases, watched};
use gibs::passes::scene::Environment;
use gibs::picture::Picture;
use gibs::view::View;
use image::{DynamicImage, ImageFormat, Rgb32FImage};
use proptest::prelude::*;
use std::path::Path;

/// A Radiance image; rows of eight pixels and more are run-length coded.
fn radiance() -> Vec<u8> {
    let image = Rgb32FImage::from_fn(16, 4, |x, y| image::Rgb([x as f32, 0.25 * y as f32, 1.0]));
    let mut out = std::io::Cursor::new(Vec::new());
    DynamicImage::from(image)
        .write_to(&mut out, ImageFormat::Hdr)
        .expect("memory takes it");
    out.into_inner()
}

/// An OpenEXR image of 6x4.
fn openexr() -> Vec<u8> {
    let mut picture = Picture::new(6, 4);
    let plane = |scale: f32| (0..24).map(|i| scale * i as f32).collect();
    picture
        .set_rgb("", [plane(1.0), plane(0.5), plane(0.1)])
        .expect("it fits");
    let folder = Folder::new();
    let file = folder.0.join("sound.exr");
    picture.write_exr(&file).expect("written");
    std::fs::read(file).expect("it is there")
}

/// A view under the map; it is sound or refused by name.
fn read_map(bytes: &[u8], name: &str) {
    let folder = Folder::new();
    folder.write(name, bytes);
    let text = format!(
        r#"{{"camera": {{"position": [0, 0, 1], "target": [0, 0, 0], "vfov_degrees": 50}},
            "environment": {{"file": "{name}", "scale": 2}}}}"#
    );
    match View::from_json(&text, &folder.0.join("view.json")) {
        Ok(view) => {
            let Environment::Map(map) = view.environment else {
                panic!("it names a map")
            };
            assert_eq!(map.texels.len(), map.width as usize * map.height as usize);
            assert!(
                map.texels
                    .iter()
                    .all(|t| t.is_finite() && t.min_element() >= 0.0)
            );
        }
        Err(error) => assert!(error.to_string().contains(name), "{error}"),
    }
}

fn read_picture(path: &Path) {
    match Picture::read_exr(path) {
        Ok(picture) => {
            assert!(
                picture
                    .channels
                    .values()
                    .all(|plane| plane.len() == picture.pixels())
            );
        }
        Err(error) => assert!(error.to_string().contains("picture.exr"), "{error}"),
    }
}

#[test]
fn whole_maps_and_pictures_are_read() {
    read_map(&radiance(), "sky.hdr");
    read_map(&openexr(), "sky.exr");
}

proptest! {
    #![proptest_config(cases(1500))]

    #[test]
    fn a_damaged_radiance_map_is_read_or_refused(edits in byte_edits()) {
        let mut bytes = radiance();
        edit_bytes(&mut bytes, &edits);
        watched(|| read_map(&bytes, "sky.hdr"));
    }

    #[test]
    fn a_damaged_openexr_map_is_read_or_refused(edits in byte_edits()) {
        let mut bytes = openexr();
        edit_bytes(&mut bytes, &edits);
        watched(|| read_map(&bytes, "sky.exr"));
    }

    #[test]
    fn a_damaged_picture_is_read_or_refused(edits in byte_edits()) {
        let mut bytes = openexr();
        edit_bytes(&mut bytes, &edits);
        let folder = Folder::new();
        let path = folder.write("picture.exr", &bytes);
        watched(|| read_picture(&path));
    }
}

/// A few hundred bytes that say that they are an image of gigabytes.
#[test]
fn a_header_that_the_file_does_not_bear_out_is_refused() {
    let folder = Folder::new();
    // The data window and the display window of an image of 6x4 end at 5, 3.
    let mut bytes = openexr();
    let window = [5_i32, 3].map(i32::to_le_bytes).concat();
    let wide = [(1_i32 << 24) - 1, 3].map(i32::to_le_bytes).concat();
    for at in (0..bytes.len() - 8)
        .filter(|&at| bytes[at..at + 8] == window)
        .collect::<Vec<_>>()
    {
        bytes[at..at + 8].copy_from_slice(&wide);
    }
    let path = folder.write("picture.exr", &bytes);
    let error = watched(|| Picture::read_exr(&path))
        .expect_err("it is damaged")
        .to_string();
    assert!(
        error.contains("16777216x4") && error.contains("bytes"),
        "{error}"
    );
    let hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8192 +X 16384\n\x02\x02\x40\x00";
    for (name, bytes) in [("sky.exr", bytes.as_slice()), ("sky.hdr", hdr)] {
        folder.write(name, bytes);
        let text = format!(
            r#"{{"camera": {{"position": [0, 0, 1], "target": [0, 0, 0], "vfov_degrees": 50}},
                "environment": {{"file": "{name}"}}}}"#
        );
        let view = watched(|| View::from_json(&text, &folder.0.join("view.json")));
        let error = view.expect_err("it is damaged").to_string();
        assert!(
            error.contains(name) && error.contains("has only"),
            "{error}"
        );
    }
}
