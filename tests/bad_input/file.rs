//! The sound file that every test breaks in its own way.
use serde_json::{Value, json};
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

/// A folder of one test's own, gone when the test is over.
pub struct Folder(pub PathBuf);

impl Folder {
    pub fn new() -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let name = format!("gibs-bad-input-{}-{number}", std::process::id());
        let path = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
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

/// Positions of the square from -1 to 1 in the plane z = 0; it faces +z.
pub const SQUARE: [f32; 12] = [-1., -1., 0., 1., -1., 0., 1., 1., 0., -1., 1., 0.];

/// Radiance of the square: albedo 0.5 under an irradiance of pi.
pub const BRIGHT: f32 = 0.5;

/// Pixels of the square in a picture of 24x24: it fills the middle two thirds, pixels 4 to 19 each way.
pub const SQUARE_PIXELS: usize = 16 * 16;

/// A document and its one buffer.
#[derive(Clone)]
pub struct Doc {
    pub root: Value,
    pub bin: Vec<u8>,
}

impl Doc {
    /// The square, lit straight from the camera's side by a light of irradiance pi, with texture coordinates.
    ///
    /// Node 0 draws, node 1 is the camera, node 2 the light. Accessor 0 has positions, 1 indices, 2 normals, 3 texture
    /// coordinates.
    pub fn square() -> Self {
        let mut doc = Self {
            root: json!({
                "asset": {"version": "2.0"},
                "buffers": [{}], "bufferViews": [], "accessors": [],
                "materials": [{"name": "grey", "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1]}}],
                "cameras": [{
                    "type": "perspective",
                    // Half of the picture's height is 1.5 at the square's distance of 3.
                    "perspective": {"yfov": 2.0 * 0.5f64.atan(), "znear": 0.1},
                }],
                "extensionsUsed": ["KHR_lights_punctual"],
                "extensions": {"KHR_lights_punctual": {
                    "lights": [{"type": "directional", "intensity": std::f32::consts::PI}],
                }},
                "nodes": [
                    {"mesh": 0},
                    {"camera": 0, "translation": [0, 0, 3]},
                    {"extensions": {"KHR_lights_punctual": {"light": 0}}},
                ],
                "scenes": [{"nodes": [0, 1, 2]}],
                "scene": 0,
            }),
            bin: Vec::new(),
        };
        let positions = doc.floats("VEC3", &SQUARE);
        let indices = doc.shorts(&[0, 1, 2, 0, 2, 3]);
        let normals = doc.floats("VEC3", &[0., 0., 1.].repeat(4));
        let uvs = doc.floats("VEC2", &[0., 1., 1., 1., 1., 0., 0., 0.]);
        doc.root["meshes"] = json!([{"name": "wall", "primitives": [{
            "attributes": {"POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs},
            "indices": indices,
            "material": 0,
        }]}]);
        doc
    }

    /// The value at a JSON pointer.
    pub fn at(&mut self, pointer: &str) -> &mut Value {
        self.root
            .pointer_mut(pointer)
            .unwrap_or_else(|| panic!("no {pointer}"))
    }

    /// Adds an element to a list and returns its index.
    pub fn push(&mut self, list: &str, element: Value) -> usize {
        let list = self.at(list).as_array_mut().unwrap();
        list.push(element);
        list.len() - 1
    }

    /// Adds a node to the scene.
    pub fn node(&mut self, node: Value) {
        let index = self.push("/nodes", node);
        self.push("/scenes/0/nodes", json!(index));
    }

    /// Appends bytes as a buffer view.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let view = json!({"buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len()});
        self.bin.extend_from_slice(bytes);
        self.push("/bufferViews", view)
    }

    /// Appends an accessor of floats.
    pub fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let width = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            _ => 3,
        };
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let view = self.view(&bytes);
        let count = values.len() / width;
        self.push(
            "/accessors",
            json!({"bufferView": view, "componentType": 5126, "type": kind, "count": count}),
        )
    }

    /// Appends an accessor of indices.
    pub fn shorts(&mut self, values: &[u16]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let view = self.view(&bytes);
        self.push(
            "/accessors",
            json!({"bufferView": view, "componentType": 5123, "type": "SCALAR", "count": values.len()}),
        )
    }

    /// Writes other floats over an accessor's elements, from component `at` on.
    pub fn overwrite(&mut self, accessor: usize, at: usize, values: &[f32]) {
        let view = self.root["accessors"][accessor]["bufferView"]
            .as_u64()
            .unwrap();
        let start = self.root["bufferViews"][view as usize]["byteOffset"]
            .as_u64()
            .unwrap();
        let start = start as usize + 4 * at;
        for (bytes, value) in self.bin[start..].chunks_exact_mut(4).zip(values) {
            bytes.copy_from_slice(&value.to_le_bytes());
        }
    }

    /// Sets the primitive's positions and indices, without other attributes.
    pub fn shape(&mut self, positions: &[f32], indices: &[u16]) {
        let positions = self.floats("VEC3", positions);
        let indices = self.shorts(indices);
        *self.at("/meshes/0/primitives/0") =
            json!({"attributes": {"POSITION": positions}, "indices": indices, "material": 0});
    }

    /// Writes `scene.gltf` and `scene.bin`.
    pub fn write(&self, folder: &Folder) -> PathBuf {
        folder.write("scene.bin", &self.bin);
        let mut root = self.root.clone();
        if root["buffers"] == json!([{}]) {
            root["buffers"] = json!([{"byteLength": self.bin.len(), "uri": "scene.bin"}]);
        }
        folder.write("scene.gltf", root.to_string())
    }

    /// The same as GLB.
    pub fn glb(&self) -> Vec<u8> {
        let mut root = self.root.clone();
        root["buffers"] = json!([{"byteLength": self.bin.len()}]);
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
}
