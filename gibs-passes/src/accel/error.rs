//! What can be wrong with the geometry that a tree is built from.
use thiserror::Error;

/// Geometry that no tree can be built from.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum BuildError {
    /// A triangle names a vertex that its part does not have.
    #[error(
        "bottom level {blas}, part {part}, triangle {triangle}: vertex index {index} is out of range, the part has {vertices} vertices; correct the mesh's indices"
    )]
    VertexIndex {
        /// Index of the bottom level.
        blas: usize,
        /// Index of the part in it.
        part: usize,
        /// Index of the triangle in the part.
        triangle: usize,
        /// The index.
        index: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// A vertex is not finite or too far away.
    #[error(
        "bottom level {blas}, part {part}, vertex {vertex}: {position:?} is not a finite position below 1e12 in magnitude; remove or rescale the vertex"
    )]
    Position {
        /// Index of the bottom level.
        blas: usize,
        /// Index of the part in it.
        part: usize,
        /// Index of the vertex in the part.
        vertex: u32,
        /// The vertex.
        position: [f32; 3],
    },
    /// A list that goes with another one has a different length.
    #[error(
        "bottom level {blas}, part {part}: {what} has {found} entries instead of {expected}; give one entry for each"
    )]
    Length {
        /// Index of the bottom level.
        blas: usize,
        /// Index of the part in it.
        part: usize,
        /// The list.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The length it needs.
        expected: usize,
    },
    /// A material index that does not fit beside the alpha flag.
    #[error(
        "bottom level {blas}, part {part}: material {material} is out of range; use an index below 2^31"
    )]
    Material {
        /// Index of the bottom level.
        blas: usize,
        /// Index of the part in it.
        part: usize,
        /// The index.
        material: u32,
    },
    /// An instance or a refit names a bottom level that does not exist.
    #[error(
        "{what} {index} names bottom level {blas}, of which there are {count}; use a smaller index"
    )]
    BottomLevel {
        /// What names it.
        what: &'static str,
        /// Index of what names it.
        index: usize,
        /// The bottom level named.
        blas: u32,
        /// Number of bottom levels.
        count: usize,
    },
    /// A list of transforms or parts does not match what the tree was built from.
    #[error("{what}: {found} given, but the tree was built from {expected}; rebuild the tree")]
    Changed {
        /// The list.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The length at the time of the build.
        expected: usize,
    },
    /// More primitives than indices reach.
    #[error("{count} {what} exceed the limit of {limit}; split or simplify the scene")]
    TooMany {
        /// What there are too many of.
        what: &'static str,
        /// Their number.
        count: usize,
        /// The limit.
        limit: usize,
    },
}

/// Why no ray can hit an instance.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum LeftOut {
    /// Its transform flattens space.
    #[error("its transform is singular; give every axis a scale other than zero")]
    Singular,
    /// Its transform is not finite or moves it out of the range of `f32`.
    #[error("its transform is not finite or moves it out of range; bring it closer to the origin")]
    OutOfRange,
    /// Its bottom level has no triangles.
    #[error("its mesh has no triangles")]
    Empty,
}
