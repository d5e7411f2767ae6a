//! The two-level acceleration structure and its traversals on the CPU.
//!
//! Bottom levels hold the triangles of one rigid or skinned object in object space, the top level holds instances of
//! them. [`TwoLevel`] is the plain data that the WGSL traversal and [`scalar`] share; [`Wide`] is the same tree,
//! eight children to a node, for the fast traversal on CPUs ([`wide`]).
//!
//! **What counts as a hit does not depend on the tree.** A triangle is hit when the formulas of [`intersect`] say so
//! for the triangle *and* for its own padded box and its instance's padded box. Every node's box is a union of those
//! boxes and the box test is monotone under rounding, so that any traversal that culls by boxes finds the same
//! hits; of equal distances the smallest (instance, triangle) wins. Hence [`scalar`] and [`wide`] agree to the bit.
mod avx2;
mod build;
mod collapse;
mod error;
pub mod hardware;
pub mod intersect;
mod level;
mod place;
mod portable;
pub mod scalar;
mod two_level;
mod types;
mod walk;
pub mod wide;

#[cfg(test)]
mod tests;

pub use build::{BlasInput, InstanceInput, MeshPart};
pub use collapse::Wide;
pub use error::{BuildError, LeftOut};
pub use place::MAX_WORLD_COORDINATE;
pub use two_level::{Stats, TwoLevel};
pub use types::{
    AccelView, BvhNode, Hit, Instance, MAX_COORDINATE, NONE, PACKET, Ray, Triangle, WideNode,
    WidePacket, WideView,
};
