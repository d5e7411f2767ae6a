//! Meshes: which primitives the scene draws, and where they hang.
use super::error::ImportError;
use super::hierarchy::Tree;
use super::material::MaterialSet;
use super::primitive::Reader;
use super::source::Source;
use super::warnings::Warnings;
use gibs_passes::scene::{Mesh, Scene};
use gltf::json::mesh::Mode;
use gltf::json::validation::Checked;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// What to read: the triangles that the scene's nodes draw, and their materials.
pub(super) struct Plan {
    pub(super) materials: MaterialSet,
    jobs: Vec<Job>,
}

/// One primitive to read.
pub(super) struct Job {
    /// Mesh of the file.
    pub(super) mesh: usize,
    /// Primitive of the mesh.
    pub(super) primitive: usize,
    /// One of those that make triangles.
    pub(super) mode: Mode,
    /// Material of the scene.
    pub(super) material: u32,
    /// Some node draws it with a skin.
    pub(super) skinned: bool,
}

impl Plan {
    pub(super) fn new(
        source: &Source,
        tree: &Tree,
        warnings: &mut Warnings,
    ) -> Result<Self, ImportError> {
        let mut drawn: BTreeMap<usize, bool> = BTreeMap::new();
        for (_, index, node) in tree.nodes(source) {
            if let Some(mesh) = node.mesh {
                source.get(&source.root.meshes, "mesh", mesh, || {
                    format!("nodes[{index}]")
                })?;
                *drawn.entry(mesh.value()).or_default() |= node.skin.is_some();
            }
        }
        let mut plan = Self {
            materials: MaterialSet::default(),
            jobs: Vec::new(),
        };
        for (mesh, skinned) in drawn {
            if source.root.meshes[mesh].primitives.is_empty() {
                warnings.once("no primitives", || {
                    format!("meshes[{mesh}] has no primitives and is left out")
                });
            }
            for (p, primitive) in source.root.meshes[mesh].primitives.iter().enumerate() {
                let element = || format!("meshes[{mesh}].primitives[{p}]");
                let Checked::Valid(mode) = primitive.mode else {
                    let found = source.stated(&format!("/meshes/{mesh}/primitives/{p}/mode"));
                    let problem = format!("has mode {found}; it must be 0 to 6");
                    return Err(source.error(element(), problem));
                };
                if !matches!(
                    mode,
                    Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan
                ) {
                    warnings.once("points", || {
                        "points and lines are not supported and left out".to_owned()
                    });
                    continue;
                }
                let material =
                    plan.materials
                        .number(source, primitive.material, element, warnings)?;
                plan.jobs.push(Job {
                    mesh,
                    primitive: p,
                    mode,
                    material,
                    skinned,
                });
            }
        }
        Ok(plan)
    }
}

/// The meshes that were read, each with the mesh of the file that it belongs to.
pub(super) struct Meshes {
    meshes: Vec<(usize, Mesh)>,
    warnings: Warnings,
}

/// Reads the planned primitives in parallel.
pub(super) fn read(source: &Source, plan: &Plan) -> Result<Meshes, ImportError> {
    let read: Vec<(Option<Mesh>, Warnings)> = plan
        .jobs
        .par_iter()
        .map(|job| {
            let mut warnings = Warnings::default();
            let uv_set = plan
                .materials
                .uv_sets
                .get(job.material as usize)
                .copied()
                .flatten();
            let mesh = Reader::new(source, job).read(uv_set, &mut warnings)?;
            Ok((mesh, warnings))
        })
        .collect::<Result<_, ImportError>>()?;
    let mut out = Meshes {
        meshes: Vec::with_capacity(read.len()),
        warnings: Warnings::default(),
    };
    for (job, (mesh, warnings)) in plan.jobs.iter().zip(read) {
        out.warnings.merge(warnings);
        out.meshes.extend(mesh.map(|mesh| (job.mesh, mesh)));
    }
    Ok(out)
}

impl Meshes {
    /// Moves the meshes into the scene and hangs them on the nodes that draw them.
    pub(super) fn attach(
        self,
        source: &Source,
        tree: &Tree,
        scene: &mut Scene,
        warnings: &mut Warnings,
    ) {
        warnings.merge(self.warnings);
        let mut parts: BTreeMap<usize, Vec<u32>> = BTreeMap::new();
        for (number, (origin, mesh)) in self.meshes.into_iter().enumerate() {
            parts.entry(origin).or_default().push(number as u32);
            scene.meshes.push(mesh);
        }
        for (id, _, node) in tree.nodes(source) {
            if let Some(parts) = node.mesh.and_then(|mesh| parts.get(&mesh.value())) {
                scene.nodes[id as usize].meshes.clone_from(parts);
            }
        }
    }
}
