//! The two-level tree: building it, moving instances, refitting skinned meshes.
use std::ops::Range;

use glam::{DAffine3, Vec3};
use rayon::prelude::*;

use super::build::{BlasInput, InstanceInput, MeshPart, edges, gather};
use super::error::{BuildError, LeftOut};
use super::level::{self, Bounds, Level, MAX_INSTANCES, MAX_TRIANGLES};
use super::place::place_instance;
use super::types::{AccelView, BvhNode, Instance, Triangle};

/// Where a bottom level lies in the buffers.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Bottom {
    pub nodes: Range<usize>,
    pub triangles: Range<usize>,
}

/// Facts about a tree, for reports.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stats {
    /// Inner nodes above the deepest leaf of the top level.
    pub top_depth: usize,
    /// Inner nodes above the deepest leaf of any bottom level.
    pub bottom_depth: usize,
    /// Instances that no ray can hit, with the reason.
    pub left_out: Vec<(u32, LeftOut)>,
}

/// A two-level tree; see [`super`] for the layout of its buffers.
#[derive(Clone, Debug, Default)]
pub struct TwoLevel {
    /// Top level, then every bottom level.
    pub nodes: Vec<BvhNode>,
    /// Triangles of all bottom levels, in leaf order.
    pub triangles: Vec<Triangle>,
    /// `(part of its bottom level, triangle of that part)` of each triangle.
    pub triangle_source: Vec<(u32, u32)>,
    /// Instances, in the order in which they were given.
    pub instances: Vec<Instance>,
    /// Facts for reports.
    pub stats: Stats,
    pub(super) bottoms: Vec<Bottom>,
    instance_blas: Vec<u32>,
}

impl TwoLevel {
    /// Builds all bottom levels (in parallel; the result does not depend on the number of threads) and the top level.
    ///
    /// # Errors
    /// When indices, positions or list lengths are wrong or limits exceeded. Instances with unusable transforms and empty
    /// bottom levels are no error: they are left out and listed in [`Stats::left_out`].
    pub fn build(blases: &[BlasInput], instances: &[InstanceInput]) -> Result<Self, BuildError> {
        check_counts(blases, instances)?;
        let levels = blases
            .par_iter()
            .enumerate()
            .map(|(index, input)| build_bottom(index, input))
            .collect::<Result<Vec<_>, _>>()?;

        let top_capacity = (2 * instances.len()).max(4);
        let node_count: usize = levels.iter().map(|built| built.level.nodes.len()).sum();
        let triangle_count: usize = levels.iter().map(|built| built.triangles.len()).sum();
        let mut tree = TwoLevel {
            nodes: Vec::with_capacity(top_capacity + node_count),
            triangles: Vec::with_capacity(triangle_count),
            triangle_source: Vec::with_capacity(triangle_count),
            ..Self::default()
        };
        tree.nodes.resize(top_capacity, BvhNode::default());
        for built in levels {
            tree.append(built);
        }
        tree.instances.resize(instances.len(), Instance::default());
        tree.instance_blas = instances.iter().map(|instance| instance.blas).collect();
        for (slot, input) in tree.instances.iter_mut().zip(instances) {
            let bottom = &tree.bottoms[input.blas as usize];
            slot.root = bottom.nodes.start as u32;
            slot.first_triangle = bottom.triangles.start as u32;
            slot.transform_id = input.transform_id;
        }
        tree.place(instances.iter().map(|instance| instance.object_to_world));
        Ok(tree)
    }

    /// Moves the instances and rebuilds the top level; bottom levels stay. One transform (object to world) per instance.
    ///
    /// # Errors
    /// When the number of transforms differs from the number of instances.
    pub fn rebuild_top(&mut self, transforms: &[DAffine3]) -> Result<(), BuildError> {
        if transforms.len() != self.instances.len() {
            return Err(BuildError::Changed {
                what: "transforms",
                found: transforms.len(),
                expected: self.instances.len(),
            });
        }
        self.place(transforms.iter().copied());
        Ok(())
    }

    /// Gives a bottom level new vertex positions (one slice per part, as at the build) and refits its boxes. The top
    /// level is stale until [`Self::rebuild_top`].
    ///
    /// # Errors
    /// When parts or triangles changed or positions are unusable; the tree is then unchanged.
    pub fn refit_bottom(&mut self, blas: u32, parts: &[MeshPart]) -> Result<(), BuildError> {
        let count = self.bottoms.len();
        let bottom = self
            .bottoms
            .get(blas as usize)
            .ok_or(BuildError::BottomLevel {
                what: "refit of bottom level",
                index: blas as usize,
                blas,
                count,
            })?;
        let found = parts.iter().map(|part| part.triangles.len()).sum();
        if found != bottom.triangles.len() {
            return Err(BuildError::Changed {
                what: "triangles of the bottom level",
                found,
                expected: bottom.triangles.len(),
            });
        }
        let sources = &self.triangle_source[bottom.triangles.clone()];
        let moved = sources
            .par_iter()
            .map(|&(part, triangle)| {
                let index = triangle as usize;
                let changed = BuildError::Changed {
                    what: "parts of the bottom level",
                    found: parts.len(),
                    expected: part as usize + 1,
                };
                let input = parts.get(part as usize).ok_or(changed.clone())?;
                let corners = input.triangles.get(index).ok_or(changed)?;
                edges(
                    blas as usize,
                    part as usize,
                    index,
                    input.positions,
                    corners,
                )
            })
            .collect::<Result<Vec<_>, _>>()?;
        for (triangle, (v0, e1, e2)) in self.triangles[bottom.triangles.clone()]
            .iter_mut()
            .zip(moved)
        {
            (triangle.v0, triangle.e1, triangle.e2) = (v0, e1, e2);
        }
        let triangles = &self.triangles;
        let base = bottom.nodes.start as u32;
        level::refit(&mut self.nodes[bottom.nodes.clone()], base, |index| {
            triangles[index as usize].bounds()
        });
        Ok(())
    }

    /// The buffers for [`super::scalar`].
    pub fn view(&self) -> AccelView<'_> {
        AccelView {
            nodes: &self.nodes,
            triangles: &self.triangles,
            instances: &self.instances,
        }
    }

    /// Number of nodes that the top level may use.
    pub fn top_capacity(&self) -> usize {
        (2 * self.instances.len()).max(4)
    }

    /// Triangles of an instance's bottom level, in leaf order.
    pub fn triangles_of(&self, instance: u32) -> &[Triangle] {
        let bottom = &self.bottoms[self.instance_blas[instance as usize] as usize];
        &self.triangles[bottom.triangles.clone()]
    }

    /// Bottom level of an instance.
    pub(super) fn bottom_of(&self, instance: u32) -> u32 {
        self.instance_blas[instance as usize]
    }

    fn append(&mut self, built: Built) {
        let (node_base, triangle_base) = (self.nodes.len(), self.triangles.len());
        self.nodes.extend(built.level.nodes.iter().map(|node| {
            let base = if node.count == 0 {
                node_base
            } else {
                triangle_base
            };
            BvhNode {
                first: node.first + base as u32,
                ..*node
            }
        }));
        let order = &built.level.order;
        self.triangles
            .extend(order.iter().map(|&i| built.triangles[i as usize]));
        self.triangle_source
            .extend(order.iter().map(|&i| built.sources[i as usize]));
        self.stats.bottom_depth = self.stats.bottom_depth.max(built.level.depth);
        self.bottoms.push(Bottom {
            nodes: node_base..self.nodes.len(),
            triangles: triangle_base..self.triangles.len(),
        });
    }

    fn place(&mut self, transforms: impl Iterator<Item = DAffine3>) {
        self.stats.left_out.clear();
        let mut boxes: Vec<Bounds> = Vec::with_capacity(self.instances.len());
        let mut present: Vec<u32> = Vec::with_capacity(self.instances.len());
        for (index, (instance, transform)) in self.instances.iter_mut().zip(transforms).enumerate()
        {
            let bottom = &self.bottoms[self.instance_blas[index] as usize];
            let root = self
                .nodes
                .get(bottom.nodes.start)
                .filter(|_| !bottom.nodes.is_empty());
            match place_instance(instance, root, &transform) {
                Ok(bounds) => {
                    boxes.push(bounds);
                    present.push(index as u32);
                }
                Err(reason) => {
                    instance.flags = Instance::LEFT_OUT;
                    self.stats.left_out.push((index as u32, reason));
                }
            }
        }
        let level = level::top(&boxes);
        self.stats.top_depth = level.depth;
        write_top(&mut self.nodes, &level, &present);
    }
}

/// A bottom level before it has a place in the buffers.
struct Built {
    level: Level,
    triangles: Vec<Triangle>,
    sources: Vec<(u32, u32)>,
}

fn build_bottom(index: usize, input: &BlasInput) -> Result<Built, BuildError> {
    let (triangles, sources) = gather(index, input)?;
    let boxes: Vec<Bounds> = triangles.iter().map(Triangle::bounds).collect();
    Ok(Built {
        level: level::bottom(&boxes),
        triangles,
        sources,
    })
}

fn check_counts(blases: &[BlasInput], instances: &[InstanceInput]) -> Result<(), BuildError> {
    let parts = blases.iter().flat_map(|blas| blas.parts);
    let triangles: usize = parts.map(|part| part.triangles.len()).sum();
    for (what, count, limit) in [
        ("triangles", triangles, MAX_TRIANGLES),
        ("instances", instances.len(), MAX_INSTANCES),
        ("bottom levels", blases.len(), MAX_INSTANCES),
    ] {
        if count > limit {
            return Err(BuildError::TooMany { what, count, limit });
        }
    }
    let wrong = instances
        .iter()
        .position(|instance| instance.blas as usize >= blases.len());
    wrong.map_or(Ok(()), |index| {
        Err(BuildError::BottomLevel {
            what: "instance",
            index,
            blas: instances[index].blas,
            count: blases.len(),
        })
    })
}

/// Writes the top level to the start of the node buffer; without instances, a root that no ray enters.
fn write_top(nodes: &mut [BvhNode], level: &Level, present: &[u32]) {
    if level.nodes.is_empty() {
        let nothing = BvhNode {
            min: Vec3::splat(1e30),
            max: Vec3::splat(-1e30),
            first: 2,
            count: 0,
        };
        // The children are never entered either; they are leaves so that no walk can go astray in them.
        let leaf = BvhNode {
            first: 0,
            count: 1,
            ..nothing
        };
        nodes[..4].copy_from_slice(&[nothing, leaf, leaf, leaf]);
        return;
    }
    for (slot, node) in nodes.iter_mut().zip(&level.nodes) {
        *slot = *node;
        if node.count > 0 {
            slot.first = present[level.order[node.first as usize] as usize];
        }
    }
}
