//! A scene at a moment: the world transform of every node.
use super::{LocalTransform, Sample, Scene};
use glam::{DAffine3, DQuat, DVec3};

/// World transform of every node, in the order of [`Scene::nodes`].
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    /// Node to world.
    pub world: Vec<DAffine3>,
}

impl Scene {
    /// The pose with each `(clip, seconds)` of `clips` applied in order. A time beyond a clip's ends holds its first
    /// or last keyframe; an index without a clip is ignored.
    ///
    /// Where two clips move the same property of a node, the later one wins. A clip that moves a node with a fixed
    /// affine map replaces that part of the map's decomposition.
    pub fn pose(&self, clips: &[(usize, f64)]) -> Pose {
        let mut locals: Vec<LocalTransform> = self.nodes.iter().map(|node| node.local).collect();
        for &(clip, seconds) in clips {
            let Some(animation) = self.animations.get(clip) else {
                continue;
            };
            for channel in &animation.channels {
                let target = locals.get_mut(channel.node as usize);
                if let (Some(local), Some(sample)) = (target, channel.sample(seconds)) {
                    apply(local, sample);
                }
            }
        }
        let mut world: Vec<DAffine3> = Vec::with_capacity(locals.len());
        for (node, local) in self.nodes.iter().zip(&locals) {
            // Parents stand before their children, so the parent's product is there already.
            let parent = node.parent.and_then(|parent| world.get(parent as usize));
            world.push(match parent {
                Some(&parent) => parent * local.affine(),
                None => local.affine(),
            });
        }
        Pose { world }
    }
}

/// Replaces one part of a transform.
fn apply(local: &mut LocalTransform, sample: Sample) {
    let (mut translation, mut rotation, mut scale) = parts(local);
    match sample {
        Sample::Translation(value) => translation = value,
        Sample::Rotation(value) => rotation = value,
        Sample::Scale(value) => scale = value,
    }
    *local = LocalTransform::Parts {
        translation,
        rotation,
        scale,
    };
}

/// Translation, rotation and scale of a transform; shear of an affine map is lost.
fn parts(local: &LocalTransform) -> (DVec3, DQuat, DVec3) {
    match *local {
        LocalTransform::Parts {
            translation,
            rotation,
            scale,
        } => (translation, rotation, scale),
        LocalTransform::Affine(affine) if affine.matrix3.determinant() != 0.0 => {
            let (scale, rotation, translation) = affine.to_scale_rotation_translation();
            (translation, rotation, scale)
        }
        // A flattened map has no unique rotation; its column lengths at least keep the extent.
        LocalTransform::Affine(affine) => {
            let m = affine.matrix3;
            let scale = DVec3::new(m.x_axis.length(), m.y_axis.length(), m.z_axis.length());
            (affine.translation, DQuat::IDENTITY, scale)
        }
    }
}
