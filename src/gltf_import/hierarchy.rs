//! Which nodes the scene has, and their order.
use super::error::ImportError;
use super::source::Source;
use super::warnings::Warnings;
use gibs_passes::scene::{LocalTransform, Node, NodeId};
use glam::{DAffine3, DMat3, DQuat, DVec3};
use gltf::json;

/// The nodes of the selected scene, parents before children.
pub(super) struct Tree {
    /// Index in the file of each scene node.
    pub(super) order: Vec<usize>,
    parents: Vec<Option<NodeId>>,
    /// Scene node of each node of the file.
    ids: Vec<Option<NodeId>>,
}

impl Tree {
    /// Walks the default scene, else the first scene, else all nodes that are nobody's child.
    pub(super) fn select(source: &Source, warnings: &mut Warnings) -> Result<Self, ImportError> {
        let nodes = &source.root.nodes;
        let mut tree = Self {
            order: Vec::new(),
            parents: Vec::new(),
            ids: vec![None; nodes.len()],
        };
        // Reversed, so that the stack hands nodes out in the file's order.
        let mut stack: Vec<(usize, Option<NodeId>)> = roots(source)?
            .into_iter()
            .rev()
            .map(|root| (root, None))
            .collect();
        while let Some((node, parent)) = stack.pop() {
            if tree.ids[node].is_some() {
                return Err(tree.reached_twice(source, node, parent));
            }
            let id = tree.order.len() as NodeId;
            tree.ids[node] = Some(id);
            tree.order.push(node);
            tree.parents.push(parent);
            for &child in nodes[node].children.iter().flatten().rev() {
                source.get(nodes, "node", child, || format!("nodes[{node}].children"))?;
                stack.push((child.value(), Some(id)));
            }
        }
        if tree.order.is_empty() {
            warnings.push("the file's scene has no nodes".to_owned());
        }
        Ok(tree)
    }

    fn reached_twice(&self, source: &Source, node: usize, parent: Option<NodeId>) -> ImportError {
        let mut ancestor = parent;
        while let Some(id) = ancestor {
            if self.order[id as usize] == node {
                return source.error(
                    format!("nodes[{node}]"),
                    "is its own ancestor; remove the cycle",
                );
            }
            ancestor = self.parents[id as usize];
        }
        source.error(
            format!("nodes[{node}]"),
            "stands in the hierarchy twice; give every node one parent",
        )
    }

    /// Scene node of a node of the file; `None` where the scene does not have it.
    pub(super) fn id(&self, node: json::Index<json::Node>) -> Option<NodeId> {
        self.ids.get(node.value()).copied().flatten()
    }

    /// Every scene node with the file's node.
    pub(super) fn nodes<'a>(
        &'a self,
        source: &'a Source,
    ) -> impl Iterator<Item = (NodeId, usize, &'a json::Node)> {
        self.order
            .iter()
            .enumerate()
            .map(|(id, &node)| (id as NodeId, node, &source.root.nodes[node]))
    }

    /// The nodes without meshes and skins.
    pub(super) fn scene_nodes(&self, source: &Source, warnings: &mut Warnings) -> Vec<Node> {
        self.nodes(source)
            .zip(&self.parents)
            .map(|((_, index, node), &parent)| Node {
                name: (node.name.clone()).unwrap_or_else(|| format!("nodes[{index}]")),
                parent,
                local: local(index, node, warnings),
                meshes: Vec::new(),
                skin: None,
            })
            .collect()
    }
}

fn roots(source: &Source) -> Result<Vec<usize>, ImportError> {
    let root = &source.root;
    let scene = match root.scene {
        Some(default) => Some(source.get(&root.scenes, "scene", default, || "scene".to_owned())?),
        None => root.scenes.first(),
    };
    if let Some(scene) = scene {
        for &node in &scene.nodes {
            source.get(&root.nodes, "node", node, || "the scene".to_owned())?;
        }
        return Ok(scene.nodes.iter().map(json::Index::value).collect());
    }
    let mut is_child = vec![false; root.nodes.len()];
    for child in root
        .nodes
        .iter()
        .flat_map(|node| node.children.iter().flatten())
    {
        if let Some(is_child) = is_child.get_mut(child.value()) {
            *is_child = true;
        }
    }
    let roots: Vec<usize> = (0..root.nodes.len())
        .filter(|&node| !is_child[node])
        .collect();
    if roots.is_empty() && !root.nodes.is_empty() {
        return Err(source.error(
            "nodes",
            "every node is another one's child; remove the cycle",
        ));
    }
    Ok(roots)
}

fn local(index: usize, node: &json::Node, warnings: &mut Warnings) -> LocalTransform {
    match &node.matrix {
        Some(matrix) => {
            if [matrix[3], matrix[7], matrix[11], matrix[15]] != [0.0, 0.0, 0.0, 1.0] {
                warnings.once("projective node", || {
                    format!("nodes[{index}].matrix is not affine; its last row is ignored")
                });
            }
            LocalTransform::Affine(affine(matrix))
        }
        None => LocalTransform::Parts {
            translation: node
                .translation
                .map_or(DVec3::ZERO, |v| DVec3::from(v.map(f64::from))),
            rotation: node.rotation.map_or(DQuat::IDENTITY, |q| rotation(q.0)),
            scale: node
                .scale
                .map_or(DVec3::ONE, |v| DVec3::from(v.map(f64::from))),
        },
    }
}

/// A rotation made unit beyond f32; validation judges those that cannot be.
fn rotation(q: [f32; 4]) -> DQuat {
    let q = DQuat::from_array(q.map(f64::from));
    let length = q.length();
    if length > 0.0 && length.is_finite() {
        q / length
    } else {
        q
    }
}

/// The affine part of a column-major 4x4 matrix.
pub(super) fn affine(m: &[f32; 16]) -> DAffine3 {
    let column = |c: usize| DVec3::new(m[4 * c].into(), m[4 * c + 1].into(), m[4 * c + 2].into());
    DAffine3 {
        matrix3: DMat3::from_cols(column(0), column(1), column(2)),
        translation: column(3),
    }
}
