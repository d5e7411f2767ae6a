//! What is lit: meshes, materials, lights, cameras and their animation, as plain host data.
//!
//! A [`Scene`] is built by a loader (glTF, built-in code) or by an engine from its own data. Lengths are in scene
//! units ("metres" below), radiometry is linear RGB with Rec. 709 primaries, transforms are `f64`.
mod animation;
mod camera;
mod light;
mod material;
mod mesh;
mod pose;
mod skinning;
#[cfg(test)]
mod tests;
mod validate;

pub use animation::{Animation, Channel, Interpolation, Keyframes, Sample};
pub use camera::Camera;
pub use light::{
    Environment, EnvironmentMap, Light, LightKind, MOST_RADIANCE, Sun, clamp_radiance,
};
pub use material::{AlphaMode, Material, Sampler, Texture, TextureRef, Wrap};
pub use mesh::{Mesh, SkinVertex};
pub use pose::Pose;
pub use skinning::SkinnedMesh;
pub(crate) use skinning::posed;
pub use validate::SceneDataError;
pub(crate) use validate::{Lighting, Sound, environment, label, sun};

use glam::{DAffine3, DQuat, DVec3};

/// Index of a node in [`Scene::nodes`]; also the *transform id* that surfels remember.
pub type NodeId = u32;

/// A whole scene at rest: hierarchy, geometry, materials, lights and clips.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Name for reports.
    pub name: String,
    /// Triangle meshes. A glTF primitive is one mesh here.
    pub meshes: Vec<Mesh>,
    /// Materials that [`Mesh::material`] indexes. Without any, all meshes have a white one, of index 0.
    pub materials: Vec<Material>,
    /// Decoded images.
    pub textures: Vec<Texture>,
    /// Hierarchy. A parent always stands before its children.
    pub nodes: Vec<Node>,
    /// Skins that [`Node::skin`] indexes.
    pub skins: Vec<Skin>,
    /// Animation clips.
    pub animations: Vec<Animation>,
    /// Lights; each sits in a node.
    pub lights: Vec<Light>,
    /// Cameras of the scene file, with the node that carries each.
    pub cameras: Vec<(NodeId, Camera)>,
}

/// One element of the hierarchy.
#[derive(Clone, Debug, Default)]
pub struct Node {
    /// Name for reports; may be empty.
    pub name: String,
    /// Parent, which stands before this node; `None` for a root.
    pub parent: Option<NodeId>,
    /// Transform to the parent.
    pub local: LocalTransform,
    /// Meshes drawn here.
    pub meshes: Vec<u32>,
    /// Skin that deforms the meshes; then the node's own transform does not apply to them (glTF 2.0, 3.7.3.3).
    pub skin: Option<u32>,
}

/// Transform of a node to its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum LocalTransform {
    /// Separate parts, which clips may animate.
    Parts {
        /// Translation, in metres.
        translation: DVec3,
        /// Rotation; its length counts for nothing, and without any it is no rotation.
        rotation: DQuat,
        /// Scale per axis; may be negative.
        scale: DVec3,
    },
    /// A fixed affine map.
    Affine(DAffine3),
}

impl LocalTransform {
    /// No movement at all.
    pub const IDENTITY: Self = Self::Parts {
        translation: DVec3::ZERO,
        rotation: DQuat::IDENTITY,
        scale: DVec3::ONE,
    };

    /// The affine map from the node to its parent.
    pub fn affine(&self) -> DAffine3 {
        match *self {
            Self::Parts {
                translation,
                rotation,
                scale,
            } => {
                let rotation = unit_rotation(rotation);
                DAffine3::from_scale_rotation_translation(scale, rotation, translation)
            }
            Self::Affine(affine) => affine,
        }
    }
}

/// Whether a rotation is longer than any rounding of a unit quaternion, and safe to divide by.
fn has_length(rotation: DQuat) -> bool {
    let length = rotation.length();
    length.is_finite() && length > 1e-30
}

/// The rotation at unit length: as it is where that is so within rounding, none at all where it has no length.
fn unit_rotation(rotation: DQuat) -> DQuat {
    if (rotation.length() - 1.0).abs() <= 1e-12 {
        rotation
    } else if has_length(rotation) {
        rotation / rotation.length()
    } else {
        DQuat::IDENTITY
    }
}

impl Default for LocalTransform {
    fn default() -> Self {
        Self::IDENTITY
    }
}

/// Joints of a skinned mesh and the maps from the mesh's rest space into each joint's space.
#[derive(Clone, Debug, Default)]
pub struct Skin {
    /// Nodes that act as bones.
    pub joints: Vec<NodeId>,
    /// Inverse bind matrix per joint.
    pub inverse_bind: Vec<DAffine3>,
}
