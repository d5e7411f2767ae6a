//! Where the vertices of a mesh are in a pose.
use super::{Mesh, NodeId, Pose, Scene, Skin};
use glam::{DAffine3, DMat3, DVec3, Vec3};
use rayon::prelude::*;

/// The vertices of one mesh as one node draws it, in world space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SkinnedMesh {
    /// Position of each vertex, metres.
    pub positions: Vec<DVec3>,
    /// Unit normal of each vertex; empty where the mesh has no normals.
    pub normals: Vec<Vec3>,
    /// The node that each vertex follows most: the joint with the highest weight (of equal ones the first in the
    /// skin), or the drawing node for a rigid mesh.
    pub dominant_joint: Vec<NodeId>,
}

/// Vertices per task: enough work to outweigh handing it to a thread.
const GRAIN: usize = 2048;

impl Scene {
    /// World-space vertices of `mesh` as drawn by `node` in `pose`.
    ///
    /// With a skin the vertex transform is the sum of `weight * joint world * inverse bind` over the vertex's joints
    /// and the node's own transform does not count (glTF 2.0, 3.7.3.3); without one, or where the mesh has no weights,
    /// it is the node's transform. Normals go through the inverse transpose. Blending is in f64.
    ///
    /// In a scene that does not pass [`Scene::validate`], a mesh that does not exist has no vertices, and a node or joint
    /// that does not exist moves nothing.
    pub fn skinned_positions(&self, pose: &Pose, node: NodeId, mesh: u32) -> SkinnedMesh {
        let Some(mesh) = self.meshes.get(mesh as usize) else {
            return SkinnedMesh::default();
        };
        let skin = self.nodes.get(node as usize).and_then(|node| node.skin);
        let skin = skin.and_then(|skin| self.skins.get(skin as usize));
        posed(mesh, skin, pose, node)
    }
}

/// As [`Scene::skinned_positions`], of a mesh that `node` draws with this skin.
pub(crate) fn posed(mesh: &Mesh, skin: Option<&Skin>, pose: &Pose, node: NodeId) -> SkinnedMesh {
    match skin {
        Some(skin) if !mesh.skin.is_empty() => skinned(mesh, skin, pose, node),
        _ => {
            let world = pose.world.get(node as usize);
            rigid(mesh, world.copied().unwrap_or(DAffine3::IDENTITY), node)
        }
    }
}

fn rigid(mesh: &Mesh, world: DAffine3, node: NodeId) -> SkinnedMesh {
    let normal_map = normal_map(world.matrix3);
    SkinnedMesh {
        positions: mesh
            .positions
            .par_iter()
            .with_min_len(GRAIN)
            .map(|p| world.transform_point3(p.as_dvec3()))
            .collect(),
        normals: mesh
            .normals
            .par_iter()
            .with_min_len(GRAIN)
            .map(|&n| map_normal(normal_map, n))
            .collect(),
        dominant_joint: vec![node; mesh.positions.len()],
    }
}

fn skinned(mesh: &Mesh, skin: &Skin, pose: &Pose, node: NodeId) -> SkinnedMesh {
    let world = |joint: NodeId| pose.world.get(joint as usize);
    let joints: Vec<DAffine3> = skin
        .joints
        .iter()
        .zip(&skin.inverse_bind)
        .map(|(&joint, &bind)| world(joint).map_or(DAffine3::IDENTITY, |&world| world * bind))
        .collect();
    let mut out = SkinnedMesh {
        positions: mesh.positions.iter().map(|p| p.as_dvec3()).collect(),
        normals: mesh.normals.clone(),
        dominant_joint: vec![node; mesh.positions.len()],
    };
    out.positions
        .par_iter_mut()
        .with_min_len(GRAIN)
        .zip(&mut out.dominant_joint)
        .zip(&mesh.skin)
        .for_each(|((position, joint), vertex)| {
            *position = blend(&joints, &vertex.weights).transform_point3(*position);
            let followed = skin.joints.get(dominant(&vertex.weights));
            *joint = followed.copied().unwrap_or(node);
        });
    out.normals
        .par_iter_mut()
        .with_min_len(GRAIN)
        .zip(&mesh.skin)
        .for_each(|(normal, vertex)| {
            let map = normal_map(blend(&joints, &vertex.weights).matrix3);
            *normal = map_normal(map, *normal);
        });
    out
}

/// Weighted mean of joint transforms; the first joint's without weights.
fn blend(joints: &[DAffine3], weights: &[(u16, f32)]) -> DAffine3 {
    let at = |joint: u16| {
        let joint = joints.get(usize::from(joint));
        joint.copied().unwrap_or(DAffine3::IDENTITY)
    };
    // One joint is the common case of rigid parts, and stays exact this way.
    if let [(joint, _)] = weights {
        return at(*joint);
    }
    let mut sum = DAffine3 {
        matrix3: DMat3::ZERO,
        translation: DVec3::ZERO,
    };
    let mut total = 0.0;
    for &(joint, weight) in weights {
        let (matrix, weight) = (at(joint), f64::from(weight));
        sum.matrix3 += matrix.matrix3 * weight;
        sum.translation += matrix.translation * weight;
        total += weight;
    }
    if total <= 0.0 {
        return at(0);
    }
    // f32 weights sum to one only within rounding; far from the origin the rest would show.
    sum.matrix3 *= total.recip();
    sum.translation *= total.recip();
    sum
}

/// Index into the skin of the joint with the highest weight; of equal ones the smallest.
fn dominant(weights: &[(u16, f32)]) -> usize {
    let mut best = (u16::MAX, f32::NEG_INFINITY);
    for &(joint, weight) in weights {
        if weight > best.1 || (weight == best.1 && joint < best.0) {
            best = (joint, weight);
        }
    }
    usize::from(best.0)
}

/// A positive multiple of the inverse transpose: the cofactor matrix with the determinant's sign, which also serves a
/// map that flattens space.
fn normal_map(m: DMat3) -> DMat3 {
    let cofactors = DMat3::from_cols(
        m.y_axis.cross(m.z_axis),
        m.z_axis.cross(m.x_axis),
        m.x_axis.cross(m.y_axis),
    );
    if m.determinant() < 0.0 {
        cofactors * -1.0
    } else {
        cofactors
    }
}

/// A normal mapped and made unit again; kept as it is where the map sends it to nothing.
fn map_normal(map: DMat3, normal: Vec3) -> Vec3 {
    (map * normal.as_dvec3())
        .try_normalize()
        .map_or(normal, |n| n.as_vec3())
}
