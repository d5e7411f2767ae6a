//! Imports of small files made here.
mod damage;
mod geometry;
mod malformed;
mod materials;
mod motion;
mod shared;
mod storage;

use super::{ImportError, Imported, load};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

const BYTE: u32 = 5120;
const UNSIGNED_BYTE: u32 = 5121;
const SHORT: u32 = 5122;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const FLOAT: u32 = 5126;

/// A folder of its own, gone when dropped.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let name = format!(
            "gibs-gltf-{}-{}",
            std::process::id(),
            NEXT.fetch_add(1, Ordering::Relaxed)
        );
        let path = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // A folder left behind is no reason to fail.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// A document under construction, with one buffer.
#[derive(Clone)]
struct Gltf {
    root: Value,
    bin: Vec<u8>,
}

impl Gltf {
    fn new() -> Self {
        let root = json!({
            "asset": {"version": "2.0"},
            "buffers": [{"byteLength": 0}], "bufferViews": [], "accessors": [],
            "meshes": [], "nodes": [],
        });
        Self {
            root,
            bin: Vec::new(),
        }
    }

    /// A node that draws the triangle (0, 0, 0), (1, 0, 0), (0, 1, 0); accessor 0 has its positions.
    fn triangle() -> Self {
        let mut gltf = Self::new();
        let positions = gltf.floats("VEC3", &[0., 0., 0., 1., 0., 0., 0., 1., 0.]);
        gltf.root["meshes"] = json!([{"primitives": [{"attributes": {"POSITION": positions}}]}]);
        gltf.root["nodes"] = json!([{"mesh": 0}]);
        gltf
    }

    /// Appends bytes as a buffer view.
    fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let view = json!({"buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len()});
        self.bin.extend_from_slice(bytes);
        push(&mut self.root["bufferViews"], view)
    }

    /// Appends an accessor over its own buffer view.
    fn accessor(&mut self, component: u32, kind: &str, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        let accessor =
            json!({"bufferView": view, "componentType": component, "type": kind, "count": count});
        push(&mut self.root["accessors"], accessor)
    }

    fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let width = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        self.accessor(FLOAT, kind, values.len() / width, &little_endian(values))
    }

    fn primitive(&mut self) -> &mut Value {
        &mut self.root["meshes"][0]["primitives"][0]
    }

    /// The JSON text, with the buffer inside.
    fn text(&self) -> String {
        let mut root = self.root.clone();
        root["buffers"][0]["byteLength"] = json!(self.bin.len());
        root["buffers"][0]["uri"] = json!(data_uri(&self.bin));
        root.to_string()
    }

    /// The GLB, with the buffer as chunk.
    fn glb(&self) -> Vec<u8> {
        let mut root = self.root.clone();
        root["buffers"][0]["byteLength"] = json!(self.bin.len());
        let mut text = root.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut bin = self.bin.clone();
        bin.resize(bin.len().next_multiple_of(4), 0);
        let mut out = b"glTF".to_vec();
        for word in [2, 28 + (text.len() + bin.len()) as u32, text.len() as u32] {
            out.extend(word.to_le_bytes());
        }
        out.extend(b"JSON");
        out.extend(text);
        out.extend((bin.len() as u32).to_le_bytes());
        out.extend(b"BIN\0");
        out.extend(bin);
        out
    }

    fn try_import(&self) -> Result<Imported, ImportError> {
        let folder = Folder::new();
        load(&folder.write("test.gltf", self.text()))
    }

    fn import(&self) -> Imported {
        self.try_import().unwrap()
    }

    /// Imports a document that must raise no warning.
    fn scene(&self) -> gibs_passes::scene::Scene {
        let imported = self.import();
        assert_eq!(imported.warnings, [""; 0]);
        imported.scene
    }
}

fn push(list: &mut Value, element: Value) -> usize {
    let list = list.as_array_mut().unwrap();
    list.push(element);
    list.len() - 1
}

fn little_endian(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn data_uri(bytes: &[u8]) -> String {
    const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = "data:application/octet-stream;base64,".to_owned();
    for chunk in bytes.chunks(3) {
        let word =
            chunk.iter().fold(0u32, |word, &b| word << 8 | u32::from(b)) << (8 * (3 - chunk.len()));
        for place in 0..4 {
            let six = (word >> (18 - 6 * place)) as usize & 63;
            out.push(if place <= chunk.len() {
                char::from(ALPHABET[six])
            } else {
                '='
            });
        }
    }
    out
}

/// A PNG of the given size with all texels alike.
fn png(width: u32, height: u32, texel: [u8; 4]) -> Vec<u8> {
    let mut out = std::io::Cursor::new(Vec::new());
    let image = image::RgbaImage::from_pixel(width, height, image::Rgba(texel));
    image.write_to(&mut out, image::ImageFormat::Png).unwrap();
    out.into_inner()
}

/// The one warning that has the given part; there must be no other.
fn only_warning(imported: &Imported, part: &str) {
    let warnings = &imported.warnings;
    assert!(
        warnings.len() == 1 && warnings[0].contains(part),
        "{warnings:?} is not one warning with {part:?}"
    );
}

/// The message of a file that must be refused.
fn refusal(path: &Path) -> String {
    match load(path) {
        Ok(_) => panic!("{} was accepted", path.display()),
        Err(error) => error.to_string(),
    }
}
