//! Triangle meshes.
use glam::{Vec2, Vec3};

/// A triangle mesh with one material.
///
/// Positions are in the space of the node that draws the mesh. `normals`, `uvs` and `skin` are either empty or as
/// long as `positions`; without normals, the geometric normals of the triangles are used.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Name for reports; may be empty.
    pub name: String,
    /// Vertex positions, in metres.
    pub positions: Vec<Vec3>,
    /// Vertex normals, of any length but zero; may be empty.
    pub normals: Vec<Vec3>,
    /// Texture coordinates of the base colour, before the material's texture transform; may be empty.
    pub uvs: Vec<Vec2>,
    /// Bones of each vertex; empty for a rigid mesh.
    pub skin: Vec<SkinVertex>,
    /// Three vertices per triangle, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Index into [`super::Scene::materials`].
    pub material: u32,
}

/// The bones that move one vertex, each by its share of the sum of the weights.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SkinVertex {
    /// `(index into Skin::joints, weight)`; no weight is negative, and one is above zero.
    pub weights: Vec<(u16, f32)>,
}
