//! One primitive: its attributes and indices.
use super::accessor::Elements;
use super::error::ImportError;
use super::geometry::Job;
use super::source::Source;
use super::triangles::{Vertices, triangles};
use super::warnings::Warnings;
use gibs_passes::scene::{Mesh, SkinVertex};
use glam::{Vec2, Vec3};
use gltf::json::accessor::Type;
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;

/// Reads one primitive.
pub(super) struct Reader<'a> {
    source: &'a Source,
    job: &'a Job,
    name: Option<&'a str>,
    primitive: &'a Primitive,
}

impl<'a> Reader<'a> {
    pub(super) fn new(source: &'a Source, job: &'a Job) -> Self {
        let mesh = &source.root.meshes[job.mesh];
        let primitive = &mesh.primitives[job.primitive];
        Self {
            source,
            job,
            name: mesh.name.as_deref(),
            primitive,
        }
    }

    fn element(&self) -> String {
        format!(
            "meshes[{}].primitives[{}]",
            self.job.mesh, self.job.primitive
        )
    }

    /// The mesh; `None` where nothing would be drawn.
    pub(super) fn read(
        &self,
        uv_set: Option<u32>,
        warnings: &mut Warnings,
    ) -> Result<Option<Mesh>, ImportError> {
        self.check_storage()?;
        let Some(positions) = self.attribute(Semantic::Positions, &[Type::Vec3])? else {
            warnings.once("no positions", || {
                format!("{} has no positions and is left out", self.element())
            });
            return Ok(None);
        };
        let corners = self.corners(positions.count)?;
        if self.job.mode == Mode::Triangles && corners.len() % 3 != 0 {
            warnings.once("leftover corners", || {
                format!(
                    "{} has {} corners, not a multiple of three; the rest is ignored",
                    self.element(),
                    corners.len()
                )
            });
        }
        let mut triangles = triangles(self.job.mode, &corners);
        if triangles.is_empty() {
            warnings.once("no triangles", || {
                format!("{} has no triangles and is left out", self.element())
            });
            return Ok(None);
        }
        let vertices = Vertices::used(&mut triangles, positions.count);

        let normals = self.attribute(Semantic::Normals, &[Type::Vec3])?;
        let uvs = match uv_set {
            Some(set) => {
                let uvs = self.attribute(Semantic::TexCoords(set), &[Type::Vec2])?;
                if uvs.is_none() {
                    warnings.once("no texture coordinates", || {
                        format!(
                            "{} has a texture, but no TEXCOORD_{set} to place it",
                            self.element()
                        )
                    });
                }
                uvs
            }
            None => None,
        };
        self.warn_unsupported(warnings);
        Ok(Some(Mesh {
            name: self.name.map_or_else(|| self.element(), str::to_owned),
            positions: vertices.map(|i| Vec3::from(positions.real::<3>(i))),
            normals: normals.map_or(Vec::new(), |normals| {
                vertices.map(|i| Vec3::from(normals.real::<3>(i)))
            }),
            uvs: uvs.map_or(Vec::new(), |uvs| {
                vertices.map(|i| Vec2::from(uvs.real::<2>(i)))
            }),
            skin: self.skin(&vertices)?,
            triangles,
            material: self.job.material,
        }))
    }

    /// Refuses vertices that exist only in a compressed form; with a plain form beside it, that one is read.
    fn check_storage(&self) -> Result<(), ImportError> {
        let draco = self.primitive.extensions.as_ref();
        let draco = draco.is_some_and(|e| e.others.contains_key("KHR_draco_mesh_compression"));
        let positions = self
            .primitive
            .attributes
            .get(&Checked::Valid(Semantic::Positions));
        let accessor = positions.and_then(|index| self.source.root.accessors.get(index.value()));
        if draco && accessor.is_some_and(|a| a.buffer_view.is_none() && a.sparse.is_none()) {
            let problem =
                "is compressed with Draco, which gibs does not support; export the file without it";
            return Err(self.source.error(self.element(), problem));
        }
        Ok(())
    }

    fn warn_unsupported(&self, warnings: &mut Warnings) {
        if self
            .primitive
            .targets
            .as_ref()
            .is_some_and(|targets| !targets.is_empty())
        {
            warnings.once("morph", || {
                "morph targets are not supported; meshes keep their base shape".to_owned()
            });
        }
        if self
            .primitive
            .attributes
            .contains_key(&Checked::Valid(Semantic::Colors(0)))
        {
            warnings.once("vertex colours", || {
                "vertex colours are not supported and have no effect".to_owned()
            });
        }
    }

    /// An attribute of the primitive, which must be as long as its positions.
    fn attribute(
        &self,
        semantic: Semantic,
        types: &[Type],
    ) -> Result<Option<Elements<'a>>, ImportError> {
        let Some(&index) = self
            .primitive
            .attributes
            .get(&Checked::Valid(semantic.clone()))
        else {
            return Ok(None);
        };
        let owner = || format!("{}.attributes.{}", self.element(), semantic.to_string());
        let integer = matches!(semantic, Semantic::Joints(_));
        let elements = match types {
            &[kind] if integer => self.source.integers(index, kind, &owner)?,
            _ => self.source.reals(index, types, &owner)?,
        };
        self.check_count(&elements, &owner)?;
        Ok(Some(elements))
    }

    fn check_count(
        &self,
        elements: &Elements,
        owner: &dyn Fn() -> String,
    ) -> Result<(), ImportError> {
        let positions = self
            .primitive
            .attributes
            .get(&Checked::Valid(Semantic::Positions));
        let expected = positions
            .and_then(|index| self.source.root.accessors.get(index.value()))
            .map(|a| a.count.0);
        if expected == Some(elements.count as u64) {
            return Ok(());
        }
        let problem = format!(
            "has {} elements beside {} positions; give one for each position",
            elements.count,
            expected.unwrap_or(0)
        );
        Err(self.source.error(owner(), problem))
    }

    /// Vertex of each corner.
    fn corners(&self, vertices: usize) -> Result<Vec<u32>, ImportError> {
        if vertices > u32::MAX as usize {
            return Err(self.source.error(
                self.element(),
                "has more vertices than 32-bit indices can reach; split it",
            ));
        }
        let Some(accessor) = self.primitive.indices else {
            return Ok((0..vertices as u32).collect());
        };
        let owner = || format!("{}.indices", self.element());
        let indices = self.source.integers(accessor, Type::Scalar, &owner)?;
        let corners: Vec<u32> = (0..indices.count)
            .map(|i| indices.integer::<1>(i)[0])
            .collect();
        if let Some(at) = corners
            .iter()
            .position(|&corner| corner as usize >= vertices)
        {
            let problem = format!(
                "has vertex {} at place {at}, but there are {vertices} vertices; correct the index or export the file again",
                corners[at]
            );
            return Err(self.source.error(owner(), problem));
        }
        Ok(corners)
    }

    /// Joints and weights of the vertices, from however many sets of four there are.
    fn skin(&self, vertices: &Vertices) -> Result<Vec<SkinVertex>, ImportError> {
        let mut skin = Vec::new();
        if !self.job.skinned {
            return Ok(skin);
        }
        for set in 0.. {
            let joints = self.attribute(Semantic::Joints(set), &[Type::Vec4])?;
            let weights = self.attribute(Semantic::Weights(set), &[Type::Vec4])?;
            let (Some(joints), Some(weights)) = (joints, weights) else {
                break;
            };
            let pairs = vertices.map(|i| (joints.integer::<4>(i), weights.real::<4>(i)));
            skin.resize_with(pairs.len(), SkinVertex::default);
            for (vertex, (joints, weights)) in skin.iter_mut().zip(pairs) {
                for (joint, weight) in joints
                    .into_iter()
                    .zip(weights)
                    .filter(|&(_, weight)| weight != 0.0)
                {
                    let Ok(joint) = u16::try_from(joint) else {
                        let problem = format!(
                            "has joint {joint}; at most 65535 joints are supported, so split the skin"
                        );
                        return Err(self.source.error(self.element(), problem));
                    };
                    // A joint named twice counts once, with both weights.
                    match vertex.weights.iter_mut().find(|(other, _)| *other == joint) {
                        Some((_, sum)) => *sum += weight,
                        None => vertex.weights.push((joint, weight)),
                    }
                }
            }
        }
        Ok(skin)
    }
}
