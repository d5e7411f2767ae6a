//! Reads glTF 2.0 files (`.gltf`, `.glb`) into a [`Scene`].
//!
//! The `gltf` crate supplies the document's types; everything that touches bytes (buffers, accessors, images) is read
//! here with checked arithmetic, so that a broken file is an error or a warning and never a panic.
//!
//! Supported: node transforms, triangle lists, strips and fans, base colour and emission with textures, alpha modes,
//! skins, animations of nodes, perspective cameras, sparse and quantized accessors, data URIs, GLB, and the extensions
//! KHR_lights_punctual, KHR_materials_emissive_strength, KHR_materials_pbrSpecularGlossiness (diffuse part),
//! KHR_materials_transmission, KHR_mesh_quantization and KHR_texture_transform. Lights' `range` is only a hint and is not read: falloff is the inverse
//! square. Metal, roughness and everything else that only shapes reflections has no effect on Lambertian surfaces and
//! is passed over in silence; anything else that is not supported is named in a warning, once.
mod accessor;
mod animation;
mod buffers;
mod document;
mod error;
mod geometry;
mod hierarchy;
mod images;
mod material;
mod node_items;
mod primitive;
mod source;
#[cfg(test)]
mod tests;
mod triangles;
mod uri;
mod warnings;

pub use error::ImportError;

use gibs_passes::scene::{Scene, Texture, TextureRef};
use source::Source;
use std::path::Path;
use warnings::Warnings;

/// A scene and what its file asked for in vain.
#[derive(Clone, Debug)]
pub struct Imported {
    /// The scene; it has passed [`Scene::validate`].
    pub scene: Scene,
    /// What was left out or repaired, one sentence each, each once.
    pub warnings: Vec<String>,
}

/// Reads the default scene of a glTF file (else its first scene, else every root node).
///
/// A glTF primitive becomes one mesh; clips keep their indices; only materials, textures and skins that the scene uses
/// are read. What has no name is named by its place in the file, as in `nodes[3]`. Images that cannot be decoded are a warning, and the surface keeps its plain factor. Vertex positions stay
/// in mesh space, intensities are taken as they stand (candela as W/sr, lux as W/m^2).
///
/// # Errors
/// A file that cannot be read, is not glTF 2.0, needs an extension that is not supported, or contradicts itself (an
/// index or accessor out of bounds, a truncated buffer, a node inside itself, positions that are not finite, ...).
pub fn load(path: &Path) -> Result<Imported, ImportError> {
    let mut warnings = Warnings::default();
    let document = document::read(path, &mut warnings)?;
    let source = Source::open(document)?;
    let tree = hierarchy::Tree::select(&source, &mut warnings)?;
    let plan = geometry::Plan::new(&source, &tree, &mut warnings)?;

    // Decoding images takes most of the time, so geometry is read beside it.
    let (images, meshes) = rayon::join(
        || images::decode(&source, &plan.materials.images),
        || geometry::read(&source, &plan),
    );
    let textures = Textures::new(images, &mut warnings);
    let meshes = meshes?;

    let mut scene = Scene {
        name: path
            .file_stem()
            .map(|stem| stem.to_string_lossy().into_owned())
            .unwrap_or_default(),
        materials: plan.materials.materials,
        nodes: tree.scene_nodes(&source, &mut warnings),
        ..Scene::default()
    };
    for material in &mut scene.materials {
        textures.place(&mut material.base_color_texture);
        textures.place(&mut material.emission_texture);
    }
    scene.textures = textures.decoded;
    meshes.attach(&source, &tree, &mut scene, &mut warnings);
    node_items::attach(&source, &tree, &mut scene, &mut warnings)?;
    scene.animations = animation::read(&source, &tree, &mut warnings)?;

    let repairs = scene.validate().map_err(|problem| ImportError::Scene {
        file: source.file.clone(),
        source: problem,
    })?;
    let mut warnings = warnings.into_lines();
    warnings.extend(repairs);
    Ok(Imported { scene, warnings })
}

/// The images that could be decoded, and where each requested one went.
struct Textures {
    decoded: Vec<Texture>,
    /// Index into `decoded` of each requested image.
    slots: Vec<Option<u32>>,
}

impl Textures {
    fn new(images: Vec<Result<Texture, String>>, warnings: &mut Warnings) -> Self {
        let mut textures = Self {
            decoded: Vec::new(),
            slots: Vec::new(),
        };
        for image in images {
            textures.slots.push(match image {
                Ok(texture) => {
                    textures.decoded.push(texture);
                    Some(textures.decoded.len() as u32 - 1)
                }
                Err(problem) => {
                    warnings.push(problem);
                    None
                }
            });
        }
        textures
    }

    /// Turns the number of a requested image into that of a decoded one; without one the texture goes away.
    fn place(&self, texture: &mut Option<TextureRef>) {
        *texture = texture.and_then(|used| {
            let slot = self.slots.get(used.texture as usize).copied().flatten()?;
            Some(TextureRef {
                texture: slot,
                ..used
            })
        });
    }
}
