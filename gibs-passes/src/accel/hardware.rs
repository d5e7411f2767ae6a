//! What devices that trace rays themselves build their acceleration structure from: the triangles and the instances of
//! the tree, in its order, so that what a ray finds are indices into its buffers.
use super::TwoLevel;
use super::types::{Instance, Triangle};
use gibs_graph::{AccelerationInstance, AccelerationTriangle};

/// The corners of every triangle, the second and the third as the tree's own boxes have them: first corner plus edge.
pub fn triangles(tree: &TwoLevel) -> Vec<AccelerationTriangle> {
    let corners = |triangle: &Triangle| {
        let v0 = triangle.v0;
        let [a, b, c] = [v0, v0 + triangle.e1, v0 + triangle.e2].map(|v| v.to_array());
        [a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2]]
    };
    tree.triangles.iter().map(corners).collect()
}

/// Every instance; one that no ray can hit has no triangles. The custom index is that of its leaf in the top level,
/// whose box bounds the distance of a hit.
pub fn instances(tree: &TwoLevel) -> Vec<AccelerationInstance> {
    let mut placed = vec![AccelerationInstance::default(); tree.instances.len()];
    let mut waiting = vec![0_u32];
    while let Some(index) = waiting.pop() {
        let Some(node) = tree.nodes.get(index as usize) else {
            continue;
        };
        if node.count == 0 {
            // Where there is nothing to hit, the root has no children, and its box is inverted.
            if node.min.cmple(node.max).all() {
                waiting.extend([node.first, node.first + 1]);
            }
            continue;
        }
        let instance = tree.instances.get(node.first as usize);
        let (Some(instance), Some(place)) = (instance, placed.get_mut(node.first as usize)) else {
            continue;
        };
        if instance.flags & Instance::LEFT_OUT == 0 {
            let triangles = tree.triangles_of(node.first);
            let asks = triangles.iter().any(Triangle::needs_alpha_test);
            *place = AccelerationInstance {
                to_world: instance.object_to_world,
                first: instance.first_triangle,
                count: triangles.len() as u32,
                custom: index,
                flags: if asks { AccelerationInstance::ASKS } else { 0 },
            };
        }
    }
    placed
}
