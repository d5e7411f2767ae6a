//! Images that cannot be read: the surface keeps its plain factor, and the warning says which and why.
use super::file::{Doc, Folder};
use super::run::{Drawn, drawn_file, refused};
use serde_json::{Value, json};
use std::io::Cursor;

/// A PNG with all texels alike.
pub fn png(width: u32, height: u32, texel: [u8; 4]) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    let image = image::RgbaImage::from_pixel(width, height, image::Rgba(texel));
    image.write_to(&mut out, image::ImageFormat::Png).unwrap();
    out.into_inner()
}

/// A PNG that cannot be packed into a few bytes, so that it can be cut within its pixels.
fn noise() -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    let image = image::RgbaImage::from_fn(32, 32, |x, y| {
        let value = (x * 7919 + y * 104_729).wrapping_mul(2_654_435_761);
        image::Rgba([
            (value >> 8) as u8,
            (value >> 16) as u8,
            (value >> 24) as u8,
            255,
        ])
    });
    image.write_to(&mut out, image::ImageFormat::Png).unwrap();
    out.into_inner()
}

/// The square with an image as its base colour.
fn textured(image: Value) -> Doc {
    let mut doc = Doc::square();
    doc.root["images"] = json!([image]);
    doc.root["textures"] = json!([{"source": 0}]);
    doc.at("/materials/0/pbrMetallicRoughness")["baseColorTexture"] = json!({"index": 0});
    doc
}

/// The square with a file of these bytes as its base colour.
fn with_file(name: &str, bytes: &[u8]) -> Drawn {
    let folder = Folder::new();
    folder.write(name, bytes);
    drawn_file(&textured(json!({"uri": name})).write(&folder), [24, 24])
}

/// An image that can be read colours the square, so that the others would be seen if they did.
#[test]
fn sound_images_colour_the_square() {
    let drawn = with_file("red.png", &png(3, 5, [255, 0, 0, 255])).warns(&[]);
    let [red, green, blue] = drawn.color("", 12, 12);
    assert!((red - 0.5).abs() < 2e-3 && green == 0.0 && blue == 0.0);
}

#[test]
fn files_that_are_no_images_leave_the_plain_factor() {
    let whole = noise();
    let webp = b"RIFF\x10\0\0\0WEBPVP8 \0\0\0\0";
    let jpeg = [&[0xff, 0xd8, 0xff, 0xe0][..], &[0; 40]].concat();
    let mut damaged = whole.clone();
    damaged[20] ^= 0x55;
    let cannot = "cannot be decoded";
    for (name, bytes, parts) in [
        ("empty.png", &[][..], &["unknown format", "convert it"][..]),
        (
            "text.png",
            b"not an image",
            &["unknown format", "convert it"],
        ),
        ("picture.png", webp, &["is WebP", "convert it"]),
        ("head.png", &whole[..10], &[cannot, "save it again"]),
        ("size.png", &whole[..24], &[cannot, "save it again"]),
        (
            "half.png",
            &whole[..whole.len() / 2],
            &[cannot, "save it again"],
        ),
        ("checksum.png", &damaged, &[cannot, "save it again"]),
        ("broken.jpg", &jpeg, &[cannot, "save it again"]),
    ] {
        let common = ["scene.gltf", "images[0]", name, "keep their plain factor"];
        let drawn = with_file(name, bytes).warns(&[&[&common[..], parts].concat()]);
        drawn.is_the_square();
    }
}

#[test]
fn images_that_are_not_there_leave_the_plain_factor() {
    for (image, parts) in [
        (
            json!({"uri": "gone.png"}),
            &["gone.png", "add the file"][..],
        ),
        (
            json!({"uri": "https://a.example/a.png"}),
            &["https", "download the file"],
        ),
        (
            json!({"uri": "data:image/png;base64,AA*A"}),
            &["'*'", "export the file again"],
        ),
        (
            json!({"bufferView": 99}),
            &["bufferView 99", "there are 4", "correct the index"],
        ),
        (json!({}), &["neither a uri nor a bufferView", "add one"]),
    ] {
        let folder = Folder::new();
        let path = textured(image).write(&folder);
        let common = ["scene.gltf", "images[0]", "keep their plain factor"];
        let drawn = drawn_file(&path, [24, 24]).warns(&[&[&common[..], parts].concat()]);
        drawn.is_the_square();
    }
    let folder = Folder::new();
    let mut doc = textured(json!({"uri": "gone.png"}));
    doc.root["textures"] = json!([{}]);
    let drawn = drawn_file(&doc.write(&folder), [24, 24])
        .warns(&[&["textures[0] names no image", "keep their plain factor"]]);
    drawn.is_the_square();
}

/// One bad image takes no other one away.
#[test]
fn images_beside_a_bad_one_are_used() {
    let folder = Folder::new();
    folder.write("good.png", png(2, 2, [0, 255, 0, 255]));
    let mut doc = textured(json!({"uri": "gone.png"}));
    doc.push("/images", json!({"uri": "good.png"}));
    doc.push("/textures", json!({"source": 1}));
    doc.root["materials"][0]["emissiveTexture"] = json!({"index": 0});
    doc.root["materials"][0]["emissiveFactor"] = json!([0, 0, 1]);
    doc.at("/materials/0/pbrMetallicRoughness/baseColorTexture")["index"] = json!(1);
    let drawn = drawn_file(&doc.write(&folder), [24, 24]).warns(&[&["images[0]", "gone.png"]]);
    let [red, green, blue] = drawn.color("", 12, 12);
    assert!(red == 0.0 && (green - 0.5).abs() < 2e-3 && (blue - 1.0).abs() < 2e-3);
}

#[test]
fn a_texture_without_coordinates_is_told() {
    let folder = Folder::new();
    folder.write("white.png", png(2, 2, [255; 4]));
    let mut doc = textured(json!({"uri": "white.png"}));
    let attributes = doc.at("/meshes/0/primitives/0/attributes").as_object_mut();
    attributes.unwrap().remove("TEXCOORD_0");
    let drawn =
        drawn_file(&doc.write(&folder), [24, 24]).warns(&[&["primitives[0]", "no TEXCOORD_0"]]);
    drawn.is_the_square();
}

#[test]
fn images_of_any_small_size_are_sampled() {
    for (width, height) in [(1, 1), (7, 3), (17, 31), (1, 500)] {
        let drawn = with_file("blue.png", &png(width, height, [0, 0, 255, 255])).warns(&[]);
        let [red, green, blue] = drawn.color("", 12, 12);
        assert!(red == 0.0 && green == 0.0 && (blue - 0.5).abs() < 2e-3);
    }
}

#[test]
fn images_that_are_too_long_are_refused() {
    let mut doc = textured(json!({}));
    let view = doc.view(&png(40_000, 1, [255; 4]));
    doc.root["images"] = json!([{"bufferView": view, "name": "strip"}]);
    refused(
        &doc,
        &[
            "texture 0 \"strip\"",
            "40000x1",
            "at most 32768",
            "scale the image down",
        ],
    );
}
