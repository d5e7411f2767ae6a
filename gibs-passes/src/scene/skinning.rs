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
    /// # Panics
    /// If `node` or `mesh` is out of range, `pose` is another scene's, or the scene does not pass
    /// [`Scene::validate`].
    pub fn skinned_positions(&self, pose: &Pose, node: NodeId, mesh: u32) -> SkinnedMesh {
        let drawn = &self.meshes[mesh as usize];
        let skin = self.nodes[node as usize]
            .skin
            .map(|skin| &self.skins[skin as usize]);
        match skin {
            Some(skin) if !drawn.skin.is_empty() => skinned(drawn, skin, pose),
            _ => rigid(drawn, pose.world[node as usize], node),
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

fn skinned(mesh: &Mesh, skin: &Skin, pose: &Pose) -> SkinnedMesh {
    let joints: Vec<DAffine3> = skin
        .joints
        .iter()
        .zip(&skin.inverse_bind)
        .map(|(&joint, &inverse_bind)| pose.world[joint as usize] * inverse_bind)
        .collect();
    let mut out = SkinnedMesh {
        positions: vec![DVec3::ZERO; mesh.positions.len()],
        normals: mesh.normals.clone(),
        dominant_joint: vec![0; mesh.positions.len()],
    };
    out.positions
        .par_iter_mut()
        .with_min_len(GRAIN)
        .zip(&mut out.dominant_joint)
        .enumerate()
        .for_each(|(i, (position, joint))| {
            let matrix = blend(&joints, &mesh.skin[i].weights);
            *position = matrix.transform_point3(mesh.positions[i].as_dvec3());
            *joint = skin.joints[dominant(&mesh.skin[i].weights)];
        });
    out.normals
        .par_iter_mut()
        .with_min_len(GRAIN)
        .enumerate()
        .for_each(|(i, normal)| {
            *normal = map_normal(
                normal_map(blend(&joints, &mesh.skin[i].weights).matrix3),
                *normal,
            );
        });
    out
}

/// Weighted sum of joint transforms.
fn blend(joints: &[DAffine3], weights: &[(u16, f32)]) -> DAffine3 {
    // One joint is the common case of rigid parts, and stays exact this way.
    if let [(joint, _)] = weights {
        return joints[usize::from(*joint)];
    }
    let mut sum = DAffine3 {
        matrix3: DMat3::ZERO,
        translation: DVec3::ZERO,
    };
    let mut total = 0.0;
    for &(joint, weight) in weights {
        let (matrix, weight) = (joints[usize::from(joint)], f64::from(weight));
        sum.matrix3 += matrix.matrix3 * weight;
        sum.translation += matrix.translation * weight;
        total += weight;
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
