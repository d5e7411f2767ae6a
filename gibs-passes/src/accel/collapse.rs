//! The wide tree: eight children to a node, collapsed from the binary one.
use std::ops::Range;

use rayon::prelude::*;

use super::two_level::TwoLevel;
use super::types::{BvhNode, NONE, PACKET, Triangle, WideNode, WidePacket, WideView};

/// Cost of visiting a node. The ratio to [`PACKET_COST`] hardly matters: from 0.4 to 2 the visits of incoherent rays
/// change by one percent.
const NODE_COST: f32 = 1.0;
/// Cost of testing a packet of triangles.
const PACKET_COST: f32 = 1.0;

/// A wide tree over the same triangles and instances as a [`TwoLevel`].
#[derive(Clone, Debug, Default)]
pub struct Wide {
    /// Top level (as many nodes as there are instances, at least one), then every bottom level.
    pub nodes: Vec<WideNode>,
    /// Leaves of all bottom levels.
    pub packets: Vec<WidePacket>,
    bottoms: Vec<WideBottom>,
}

#[derive(Clone, Debug)]
struct WideBottom {
    /// Child word of the root; [`NONE`] if there are no triangles.
    root: u32,
    nodes: Range<usize>,
    packets: Range<usize>,
}

impl Wide {
    /// Collapses a whole tree, bottom levels in parallel.
    pub fn build(tree: &TwoLevel) -> Self {
        let collapsed: Vec<Collapsed> = tree
            .bottoms
            .par_iter()
            .map(|bottom| {
                let nodes = &tree.nodes[bottom.nodes.clone()];
                collapse(nodes, bottom.nodes.start as u32, PACKET as u32)
            })
            .collect();
        let mut wide = Wide::default();
        wide.nodes
            .resize(tree.instances.len().max(1), WideNode::EMPTY);
        for part in collapsed {
            wide.append(part, &tree.triangles);
        }
        wide.update_top(tree);
        wide
    }

    /// Follows [`TwoLevel::rebuild_top`].
    pub fn update_top(&mut self, tree: &TwoLevel) {
        let capacity = tree.instances.len().max(1);
        self.nodes[..capacity].fill(WideNode::EMPTY);
        if tree.stats.left_out.len() == tree.instances.len() {
            return;
        }
        let top = collapse(&tree.nodes[..tree.top_capacity()], 0, 1);
        let mut finish = |mut node: WideNode, slot: usize| {
            for lane in 0..8 {
                let word = node.children[lane];
                if word != NONE && word & WideNode::LEAF != 0 {
                    let instance = top.leaves[(word & !WideNode::LEAF) as usize].start;
                    node.children[lane] = WideNode::LEAF | instance;
                    node.sources[lane] = self.bottoms[tree.bottom_of(instance) as usize].root;
                }
            }
            self.nodes[slot] = node;
        };
        if top.nodes.is_empty() {
            // One instance: a root with a single child.
            let mut root = WideNode::EMPTY;
            set_child(&mut root, 0, &tree.nodes[0], top.root, 0);
            finish(root, 0);
        }
        for (slot, node) in top.nodes.iter().enumerate() {
            finish(*node, slot);
        }
    }

    /// Follows [`TwoLevel::refit_bottom`].
    pub fn refit_bottom(&mut self, tree: &TwoLevel, blas: u32) {
        let Some(bottom) = self.bottoms.get(blas as usize) else {
            return;
        };
        for node in &mut self.nodes[bottom.nodes.clone()] {
            for lane in 0..8 {
                if node.children[lane] != NONE {
                    let source = node.sources[lane];
                    let child = node.children[lane];
                    set_child(node, lane, &tree.nodes[source as usize], child, source);
                }
            }
        }
        for packet in &mut self.packets[bottom.packets.clone()] {
            *packet = pack(&tree.triangles, packet.first..packet.first + packet.count);
        }
    }

    /// The buffers for [`super::wide`].
    pub fn view<'a>(&'a self, tree: &'a TwoLevel) -> WideView<'a> {
        WideView {
            nodes: &self.nodes,
            packets: &self.packets,
            instances: &tree.instances,
        }
    }

    fn append(&mut self, part: Collapsed, triangles: &[Triangle]) {
        let (node_base, packet_base) = (self.nodes.len() as u32, self.packets.len() as u32);
        let rebase = |word: u32| match word {
            NONE => NONE,
            leaf if leaf & WideNode::LEAF != 0 => leaf + packet_base,
            inner => inner + node_base,
        };
        self.nodes.extend(part.nodes.into_iter().map(|mut node| {
            node.children = node.children.map(rebase);
            node
        }));
        let packets = part.leaves.into_iter().map(|leaf| pack(triangles, leaf));
        self.packets.extend(packets);
        self.bottoms.push(WideBottom {
            root: rebase(part.root),
            nodes: node_base as usize..self.nodes.len(),
            packets: packet_base as usize..self.packets.len(),
        });
    }
}

/// A collapsed level with indices relative to itself.
struct Collapsed {
    root: u32,
    nodes: Vec<WideNode>,
    /// Primitives of each leaf, by the index that the binary leaves hold.
    leaves: Vec<Range<u32>>,
}

/// What the cost of a binary subtree depends on, bottom up.
#[derive(Clone, Copy, Default)]
struct Plan {
    /// Lowest cost of the subtree as at most `i + 1` children of a wide node.
    cost: [f32; 8],
    /// How many of those children the left subtree takes; zero: no more than with one child fewer.
    left: [u8; 8],
    /// As `left`, for the subtree as a wide node of its own; zero if it is a leaf.
    inner: u8,
    first: u32,
    count: u32,
}

/// Chooses the wide tree of least expected cost by dynamic programming over the binary one: H. Ylitie, T. Karras and S.
/// Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", HPG 2017, section 3.2.
///
/// `nodes` start at index `base` of the node buffer; a leaf takes up to `capacity` primitives.
fn collapse(nodes: &[BvhNode], base: u32, capacity: u32) -> Collapsed {
    let mut result = Collapsed {
        root: NONE,
        nodes: Vec::new(),
        leaves: Vec::new(),
    };
    if nodes.is_empty() {
        return result;
    }
    let plans = plan(nodes, base, capacity);
    let mut leaf = |plan: &Plan| {
        result.leaves.push(plan.first..plan.first + plan.count);
        WideNode::LEAF | (result.leaves.len() - 1) as u32
    };
    if plans[0].inner == 0 {
        result.root = leaf(&plans[0]);
        return result;
    }
    result.root = 0;
    result.nodes.push(WideNode::EMPTY);
    let mut pending = vec![(0_u32, 0_usize)];
    let mut children: Vec<u32> = Vec::with_capacity(8);
    while let Some((binary, slot)) = pending.pop() {
        children.clear();
        let first = nodes[binary as usize].first - base;
        let split = plans[binary as usize].inner;
        choose(nodes, base, &plans, first, split, &mut children);
        choose(nodes, base, &plans, first + 1, 8 - split, &mut children);
        // Shadow rays visit the last child first: the largest is the likeliest to hide the light.
        let size = |child: &u32| area(&nodes[*child as usize]);
        children.sort_by(|a, b| size(a).total_cmp(&size(b)));
        let mut node = WideNode::EMPTY;
        let inner_start = pending.len();
        for (lane, &child) in children.iter().enumerate() {
            let plan = &plans[child as usize];
            let word = if plan.inner == 0 {
                leaf(plan)
            } else {
                result.nodes.push(WideNode::EMPTY);
                let word = (result.nodes.len() - 1) as u32;
                pending.push((child, word as usize));
                word
            };
            set_child(&mut node, lane, &nodes[child as usize], word, child + base);
        }
        // The first child comes next, so that its children lie near.
        pending[inner_start..].reverse();
        result.nodes[slot] = node;
    }
    result
}

/// Lists the binary nodes that stand for the subtree of `node` as at most `slots` children.
fn choose(nodes: &[BvhNode], base: u32, plans: &[Plan], node: u32, slots: u8, out: &mut Vec<u32>) {
    let plan = &plans[node as usize];
    let slots = (1..=slots)
        .rev()
        .find(|&s| s == 1 || plan.left[s as usize - 1] != 0)
        .unwrap_or(1);
    if slots == 1 {
        out.push(node);
        return;
    }
    let left = plan.left[slots as usize - 1];
    let first = nodes[node as usize].first - base;
    choose(nodes, base, plans, first, left, out);
    choose(nodes, base, plans, first + 1, slots - left, out);
}

fn plan(nodes: &[BvhNode], base: u32, capacity: u32) -> Vec<Plan> {
    let mut plans = vec![Plan::default(); nodes.len()];
    for index in (0..nodes.len()).rev() {
        let node = &nodes[index];
        if node.count > 0 {
            plans[index] = Plan {
                cost: [area(node) * PACKET_COST; 8],
                first: node.first,
                count: node.count,
                ..Plan::default()
            };
            continue;
        }
        // A place that no parent uses (node 1, spare places of the top level) has no children to plan for.
        let child = (node.first.wrapping_sub(base)) as usize;
        if child <= index || child + 1 >= nodes.len() {
            continue;
        }
        let (left, right) = (plans[child], plans[child + 1]);
        let best = |slots: usize| {
            (1..slots)
                .map(|l| (left.cost[l - 1] + right.cost[slots - l - 1], l as u8))
                .fold((f32::INFINITY, 1), |a, b| if b.0 < a.0 { b } else { a })
        };
        let mut plan = Plan {
            first: left.first,
            count: left.count + right.count,
            ..Plan::default()
        };
        let (below, split) = best(8);
        let as_node = below + area(node) * NODE_COST;
        let as_leaf = area(node) * PACKET_COST;
        if plan.count <= capacity && as_leaf <= as_node {
            plan.cost[0] = as_leaf;
        } else {
            plan.cost[0] = as_node;
            plan.inner = split;
        }
        for slots in 2..=8 {
            let (cost, split) = best(slots);
            plan.cost[slots - 1] = plan.cost[slots - 2];
            if cost < plan.cost[slots - 1] {
                plan.cost[slots - 1] = cost;
                plan.left[slots - 1] = split;
            }
        }
        plans[index] = plan;
    }
    plans
}

/// Half the surface of a node's box.
fn area(node: &BvhNode) -> f32 {
    let size = node.max - node.min;
    size.x * size.y + size.y * size.z + size.z * size.x
}

fn set_child(node: &mut WideNode, lane: usize, source: &BvhNode, word: u32, source_index: u32) {
    for axis in 0..3 {
        node.planes[axis][lane] = source.min[axis];
        node.planes[axis + 3][lane] = source.max[axis];
    }
    node.children[lane] = word;
    node.sources[lane] = source_index;
}

fn pack(triangles: &[Triangle], range: Range<u32>) -> WidePacket {
    let mut packet = WidePacket {
        first: range.start,
        count: range.len() as u32,
        ..WidePacket::default()
    };
    let source = &triangles[range.start as usize..range.end as usize];
    for (lane, triangle) in source.iter().enumerate() {
        packet.alpha |= u32::from(triangle.needs_alpha_test()) << lane;
        for axis in 0..3 {
            packet.v0[axis][lane] = triangle.v0[axis];
            packet.e1[axis][lane] = triangle.e1[axis];
            packet.e2[axis][lane] = triangle.e2[axis];
        }
    }
    packet
}
