//! What a tree is built from, and the checks on it.
use glam::{DAffine3, Vec3};

use super::error::BuildError;
use super::types::{MAX_COORDINATE, Triangle};

/// One mesh of a bottom level.
#[derive(Clone, Copy, Debug, Default)]
pub struct MeshPart<'a> {
    /// Vertices in the space of the bottom level.
    pub positions: &'a [Vec3],
    /// Three vertex indices per triangle.
    pub triangles: &'a [[u32; 3]],
    /// Material index, below 2^31.
    pub material: u32,
    /// Whether the traversal's filter decides about hits (masked or blended materials).
    pub alpha_test: bool,
    /// Added to the triangle's index in the part to give [`Triangle::primitive`].
    pub first_primitive: u32,
    /// Transform that moves the part.
    pub transform_id: u32,
    /// Transform of each triangle instead of `transform_id`; empty, or one for each triangle.
    pub transform_ids: &'a [u32],
}

/// One bottom level: parts that move together.
#[derive(Clone, Copy, Debug, Default)]
pub struct BlasInput<'a> {
    /// Meshes. None, or none with triangles, make an empty bottom level that no ray hits.
    pub parts: &'a [MeshPart<'a>],
}

/// A bottom level placed in the world.
#[derive(Clone, Copy, Debug)]
pub struct InstanceInput {
    /// Index of the bottom level.
    pub blas: u32,
    /// Object to world, the latter relative to the floating origin.
    pub object_to_world: DAffine3,
    /// Transform that moves the instance.
    pub transform_id: u32,
}

/// Triangles, and the part and triangle of that part that each came from.
pub(super) type Gathered = (Vec<Triangle>, Vec<(u32, u32)>);

/// Triangles of a bottom level in the order of the input.
pub(super) fn gather(blas: usize, input: &BlasInput) -> Result<Gathered, BuildError> {
    let count = input.parts.iter().map(|part| part.triangles.len()).sum();
    let mut triangles = Vec::with_capacity(count);
    let mut sources = Vec::with_capacity(count);
    for (part_index, part) in input.parts.iter().enumerate() {
        let per_triangle = part.transform_ids;
        if !per_triangle.is_empty() && per_triangle.len() != part.triangles.len() {
            return Err(BuildError::Length {
                blas,
                part: part_index,
                what: "transform_ids",
                found: per_triangle.len(),
                expected: part.triangles.len(),
            });
        }
        if part.material & Triangle::ALPHA_TEST != 0 {
            return Err(BuildError::Material {
                blas,
                part: part_index,
                material: part.material,
            });
        }
        let alpha = if part.alpha_test {
            Triangle::ALPHA_TEST
        } else {
            0
        };
        for (index, corners) in part.triangles.iter().enumerate() {
            let (v0, e1, e2) = edges(blas, part_index, index, part.positions, corners)?;
            triangles.push(Triangle {
                v0,
                primitive: part.first_primitive.wrapping_add(index as u32),
                e1,
                material_flags: part.material | alpha,
                e2,
                transform_id: per_triangle
                    .get(index)
                    .copied()
                    .unwrap_or(part.transform_id),
            });
            sources.push((part_index as u32, index as u32));
        }
    }
    Ok((triangles, sources))
}

/// First vertex and edges of a triangle, checked.
pub(super) fn edges(
    blas: usize,
    part: usize,
    triangle: usize,
    positions: &[Vec3],
    corners: &[u32; 3],
) -> Result<(Vec3, Vec3, Vec3), BuildError> {
    let vertex = |index: u32| {
        let position = positions
            .get(index as usize)
            .ok_or(BuildError::VertexIndex {
                blas,
                part,
                triangle,
                index,
                vertices: positions.len(),
            })?;
        // Not `>`: the comparison must also fail for NaN.
        if position.abs().cmplt(Vec3::splat(MAX_COORDINATE)).all() {
            Ok(*position)
        } else {
            Err(BuildError::Position {
                blas,
                part,
                vertex: index,
                position: position.to_array(),
            })
        }
    };
    let (v0, v1, v2) = (
        vertex(corners[0])?,
        vertex(corners[1])?,
        vertex(corners[2])?,
    );
    Ok((v0, v1 - v0, v2 - v0))
}
