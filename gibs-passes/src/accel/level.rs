//! One binary tree over boxes: built by obvhs, laid out for traversal.
use glam::Vec3;
use obvhs::aabb::Aabb;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

use super::types::BvhNode;

/// Entries of the traversal stack that the two levels share, one for each inner node above the current one.
pub(super) const STACK_SIZE: usize = 64;
/// Inner nodes above a leaf of a bottom level, at most.
pub(super) const BOTTOM_DEPTH: usize = 46;
/// Inner nodes above a leaf of the top level, at most. Together with [`BOTTOM_DEPTH`] it fills the stack.
pub(super) const TOP_DEPTH: usize = STACK_SIZE - BOTTOM_DEPTH;

/// Largest number of instances: a balanced tree of one per leaf is then no deeper than [`TOP_DEPTH`].
pub(super) const MAX_INSTANCES: usize = 1 << 18;
/// Largest number of triangles of all bottom levels: node indices and the packets' leaf bit must fit.
pub(super) const MAX_TRIANGLES: usize = 1 << 29;

/// Most triangles in a leaf.
const LEAF_SIZE: usize = 4;

/// Below this number of primitives every node is a candidate for reinsertion; a hundred overlapping instances are then
/// traversed a tenth faster.
const THOROUGH: usize = 1024;

/// Axis-aligned box.
pub(super) type Bounds = (Vec3, Vec3);

/// A binary tree with indices relative to itself: root 0, node 1 unused, siblings at `2 k` and `2 k + 1`, parents
/// before children, primitives in the order in which a depth-first walk meets them.
#[derive(Debug, Default)]
pub(super) struct Level {
    pub nodes: Vec<BvhNode>,
    /// Primitive at each place of the leaves.
    pub order: Vec<u32>,
    /// Inner nodes above the deepest leaf.
    pub depth: usize,
}

/// Builds a bottom level.
///
/// Parameters are those of obvhs's preset "medium" (with thorough reinsertion for small sets) without its second pass of
/// reinsertion, which costs time for little. Without the first pass rays visit an eighth more nodes.
pub(super) fn bottom(boxes: &[Bounds]) -> Level {
    build(boxes, LEAF_SIZE, BOTTOM_DEPTH)
}

/// Builds the top level: every leaf holds one primitive, so that its box is the primitive's.
pub(super) fn top(boxes: &[Bounds]) -> Level {
    build(boxes, 1, TOP_DEPTH)
}

fn build(boxes: &[Bounds], leaf_size: usize, max_depth: usize) -> Level {
    if boxes.is_empty() {
        return Level::default();
    }
    let aabbs: Vec<Aabb> = boxes
        .iter()
        .map(|&(min, max)| Aabb::new(min.into(), max.into()))
        .collect();
    let mut bvh = PlocBuilder::with_capacity(aabbs.len()).build(
        PlocSearchDistance::Medium,
        &aabbs,
        (0..aabbs.len() as u32).collect(),
        SortPrecision::U64,
        3,
    );
    let mut optimizer = ReinsertionOptimizer::default();
    // Small sets, above all the top level, are worth a thorough search, which takes little time there.
    let share = if boxes.len() < THOROUGH { 1.0 } else { 0.05 };
    optimizer.run(&mut bvh, share, None);
    if leaf_size > 1 {
        collapse(&mut bvh, leaf_size as u32, 3.0);
    }
    let source: Vec<BvhNode> = bvh
        .nodes
        .iter()
        .map(|node| BvhNode {
            min: Vec3::ZERO,
            first: node.first_index,
            max: Vec3::ZERO,
            count: node.prim_count,
        })
        .collect();
    let level = lay_out(&source, &bvh.primitive_indices, boxes);
    if level.depth <= max_depth {
        level
    } else {
        balance(level, boxes, leaf_size, max_depth)
    }
}

/// Copies a tree into the layout of [`Level`] and computes its boxes.
fn lay_out(source: &[BvhNode], primitives: &[u32], boxes: &[Bounds]) -> Level {
    let mut level = Level {
        nodes: Vec::with_capacity(source.len() + 1),
        order: Vec::with_capacity(boxes.len()),
        depth: 0,
    };
    level.nodes.resize(2, BvhNode::default());
    let mut pending = vec![(0_usize, 0_usize, 0_usize)];
    while let Some((from, to, depth)) = pending.pop() {
        let node = source[from];
        if node.count == 0 {
            let child = level.nodes.len();
            level.nodes.resize(child + 2, BvhNode::default());
            level.nodes[to].first = child as u32;
            let first = node.first as usize;
            pending.push((first + 1, child + 1, depth + 1));
            pending.push((first, child, depth + 1));
        } else {
            level.nodes[to].first = level.order.len() as u32;
            level.nodes[to].count = node.count;
            let range = node.first as usize..(node.first + node.count) as usize;
            level.order.extend_from_slice(&primitives[range]);
            level.depth = level.depth.max(depth);
        }
    }
    let order = &level.order;
    refit(&mut level.nodes, 0, |place| {
        boxes[order[place as usize] as usize]
    });
    level
}

/// Recomputes all boxes of a level whose `nodes` start at index `base` of the node buffer, children first. `bounds` is
/// asked for the box of a primitive by the index that the leaves hold.
pub(super) fn refit(nodes: &mut [BvhNode], base: u32, bounds: impl Fn(u32) -> Bounds) {
    let union = |a: Bounds, b: Bounds| (a.0.min(b.0), a.1.max(b.1));
    for index in (0..nodes.len()).rev().filter(|&index| index != 1) {
        let node = nodes[index];
        let (min, max) = if node.count == 0 {
            let child = (node.first - base) as usize;
            let (a, b) = (&nodes[child], &nodes[child + 1]);
            union((a.min, a.max), (b.min, b.max))
        } else {
            let rest = node.first + 1..node.first + node.count;
            rest.map(&bounds).fold(bounds(node.first), union)
        };
        nodes[index].min = min;
        nodes[index].max = max;
    }
}

/// Rebuilds the subtrees that make a level too deep, which clustering can turn into lists, as balanced ones, as far
/// down as the limit allows.
fn balance(mut level: Level, boxes: &[Bounds], leaf_size: usize, max_depth: usize) -> Level {
    let inner_above = |count: u32| {
        (count as usize)
            .div_ceil(leaf_size)
            .next_power_of_two()
            .ilog2()
    };
    // Height in inner nodes, first place and number of primitives of each subtree; children stand after parents.
    let mut facts = vec![(0_usize, 0_u32, 0_u32); level.nodes.len()];
    for (index, node) in level
        .nodes
        .iter()
        .enumerate()
        .rev()
        .filter(|&(index, _)| index != 1)
    {
        facts[index] = if node.count > 0 {
            (0, node.first, node.count)
        } else {
            let child = node.first as usize;
            let (a, b) = (facts[child], facts[child + 1]);
            (1 + a.0.max(b.0), a.1, a.2 + b.2)
        };
    }
    let mut pending = vec![(0, 0)];
    while let Some((index, depth)) = pending.pop() {
        let (height, first, count) = facts[index];
        if depth + height <= max_depth {
            continue;
        }
        let child = level.nodes[index].first as usize;
        let larger = facts[child].2.max(facts[child + 1].2);
        if depth + 1 + inner_above(larger) as usize <= max_depth {
            pending.extend([(child, depth + 1), (child + 1, depth + 1)]);
            continue;
        }
        let range = first as usize..(first + count) as usize;
        let subtree = median_split(&mut level.order[range], first, boxes, leaf_size);
        let base = level.nodes.len() as u32;
        level.nodes.extend(subtree.iter().map(|node| BvhNode {
            first: node.first + if node.count == 0 { base } else { 0 },
            ..*node
        }));
        level.nodes[index] = level.nodes[base as usize];
    }
    lay_out(&level.nodes, &level.order, boxes)
}

/// Halves primitives along the longest axis of their centres until they fit leaves, to a depth of
/// `ceil(log2(n / leaf_size))`. The places of `order` count from `first`; the root is node 0.
fn median_split(order: &mut [u32], first: u32, boxes: &[Bounds], leaf_size: usize) -> Vec<BvhNode> {
    let centre = |&index: &u32| {
        let (min, max) = boxes[index as usize];
        0.5 * min + 0.5 * max
    };
    let mut nodes = vec![BvhNode::default()];
    let mut pending = vec![(0, 0, order.len())];
    while let Some((to, start, end)) = pending.pop() {
        if end - start <= leaf_size {
            nodes[to].first = first + start as u32;
            nodes[to].count = (end - start) as u32;
            continue;
        }
        let range = &mut order[start..end];
        let (low, high) = range
            .iter()
            .map(centre)
            .fold((Vec3::MAX, Vec3::MIN), |(low, high), c| {
                (low.min(c), high.max(c))
            });
        let axis = (high - low).max_position();
        // Whole leaves on the left, so that no half needs more levels than its share of them.
        let middle = (range.len().div_ceil(leaf_size) / 2) * leaf_size;
        range.select_nth_unstable_by(middle, |a, b| {
            centre(a)[axis].total_cmp(&centre(b)[axis]).then(a.cmp(b))
        });
        let child = nodes.len();
        nodes[to].first = child as u32;
        nodes.resize(child + 2, BvhNode::default());
        pending.push((child, start, start + middle));
        pending.push((child + 1, start + middle, end));
    }
    nodes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(level: &Level, boxes: &[Bounds], leaf_size: usize) {
        let mut seen = vec![false; boxes.len()];
        let mut pending = vec![0];
        while let Some(index) = pending.pop() {
            let node = &level.nodes[index];
            if node.count == 0 {
                for child in [node.first as usize, node.first as usize + 1] {
                    assert!(child > index, "parents stand before children");
                    let inner = &level.nodes[child];
                    assert!(inner.min.cmpge(node.min).all() && inner.max.cmple(node.max).all());
                    pending.push(child);
                }
                assert_eq!(node.first % 2, 0, "siblings share a line");
            } else {
                assert!(node.count as usize <= leaf_size);
                for place in node.first..node.first + node.count {
                    let primitive = level.order[place as usize] as usize;
                    assert!(!std::mem::replace(&mut seen[primitive], true));
                    let (min, max) = boxes[primitive];
                    assert!(min.cmpge(node.min).all() && max.cmple(node.max).all());
                }
            }
        }
        assert!(seen.iter().all(|&s| s), "every primitive is in a leaf");
    }

    fn boxes(count: usize, place: impl Fn(usize) -> f32) -> Vec<Bounds> {
        (0..count)
            .map(|i| {
                let min = Vec3::new(place(i), (i % 7) as f32, (i % 3) as f32);
                (min, min + 0.5)
            })
            .collect()
    }

    #[test]
    fn small_and_duplicate_sets_are_complete_trees() {
        for count in [1, 2, 3, 5, 9, 200] {
            for spread in [0.0, 1.0] {
                let boxes = boxes(count, |i| i as f32 * spread);
                check(&bottom(&boxes), &boxes, LEAF_SIZE);
                check(&top(&boxes), &boxes, 1);
            }
        }
        assert!(bottom(&[]).nodes.is_empty());
    }

    #[test]
    fn median_split_is_balanced() {
        let boxes = boxes(1001, |i| 1.1_f32.powi(i as i32 % 300));
        for (leaf_size, depth) in [(1, 10), (4, 8)] {
            let mut order: Vec<u32> = (0..1001).collect();
            let source = median_split(&mut order, 0, &boxes, leaf_size);
            let level = lay_out(&source, &order, &boxes);
            check(&level, &boxes, leaf_size);
            assert_eq!(level.depth, depth, "ceil(log2(1001 / {leaf_size}))");
        }
    }

    #[test]
    fn geometric_growth_stays_within_the_stack() {
        // Each box contains all smaller ones: clustering joins them one by one into a list.
        let nested: Vec<Bounds> = (0..120)
            .map(|i| (Vec3::ZERO, Vec3::splat(1.2_f32.powi(i))))
            .collect();
        let free = build(&nested, 1, usize::MAX);
        assert!(
            free.depth > 16,
            "depth {}: the boxes are not awkward enough",
            free.depth
        );
        for limit in [7, 8, 11, 16] {
            let level = build(&nested, 1, limit);
            assert!(level.depth <= limit, "depth {} of {limit}", level.depth);
            check(&level, &nested, 1);
        }
    }
}
