//! Shapes made by code: polygons, boxes, sweeps, lathes, sheets.
//!
//! Lengths are metres. Fronts are counter-clockwise, texture coordinates are metres along the surface with v pointing
//! down (as the rows of a texture do). What a function calls *closed* is watertight: every edge belongs to two
//! triangles that run through it in opposite directions, and the triangles face outwards.
mod cloth;
mod round;
mod solid;
mod sweep;
#[cfg(test)]
pub(crate) mod tests;

pub(crate) use cloth::sheet;
pub(crate) use round::{arc, cylinder, lathe, sphere};
pub(crate) use solid::{bevelled, cuboid, shell};
pub(crate) use sweep::{Frame, Path, extrude, ring, sweep};

use glam::{Affine3A, Mat3A, Vec2, Vec3};

/// Triangles with unit normals and texture coordinates per vertex.
#[derive(Clone, Debug, Default)]
pub(crate) struct Shape {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    pub uvs: Vec<Vec2>,
    pub triangles: Vec<[u32; 3]>,
}

impl Shape {
    /// Adds a vertex and returns its index.
    pub fn vertex(&mut self, position: Vec3, normal: Vec3, uv: Vec2) -> u32 {
        self.positions.push(position);
        self.normals.push(normal);
        self.uvs.push(uv);
        self.positions.len() as u32 - 1
    }

    /// Adds a triangle of existing vertices, unless two of its corners are the same point.
    pub fn triangle(&mut self, corners: [u32; 3]) {
        let [a, b, c] = corners.map(|i| self.positions[i as usize]);
        if a != b && b != c && c != a {
            self.triangles.push(corners);
        }
    }

    /// Adds a flat convex polygon, counter-clockwise seen from its front.
    pub fn polygon(&mut self, corners: &[Vec3]) {
        let normal = area_vector(corners).normalize_or(Vec3::Y);
        let indices: Vec<u32> = corners
            .iter()
            .map(|&p| self.vertex(p, normal, flat_uv(p, normal)))
            .collect();
        for i in 2..indices.len() {
            self.triangle([indices[0], indices[i - 1], indices[i]]);
        }
    }

    /// Adds the surface through a table of `(position, normal, uv)`; cells are counter-clockwise in the order (i, j),
    /// (i, j + 1), (i + 1, j + 1).
    pub fn grid(
        &mut self,
        rows: usize,
        columns: usize,
        at: impl Fn(usize, usize) -> (Vec3, Vec3, Vec2),
    ) {
        let base = self.positions.len() as u32;
        for i in 0..rows {
            for j in 0..columns {
                let (position, normal, uv) = at(i, j);
                self.vertex(position, normal, uv);
            }
        }
        let index = |i: usize, j: usize| base + (i * columns + j) as u32;
        for i in 1..rows {
            for j in 1..columns {
                let [a, b] = [index(i - 1, j - 1), index(i - 1, j)];
                let [c, d] = [index(i, j), index(i, j - 1)];
                self.triangle([a, b, c]);
                self.triangle([a, c, d]);
            }
        }
    }

    /// Adds a copy of another shape.
    pub fn append(&mut self, other: &Shape) {
        let base = self.positions.len() as u32;
        self.positions.extend_from_slice(&other.positions);
        self.normals.extend_from_slice(&other.normals);
        self.uvs.extend_from_slice(&other.uvs);
        self.triangles
            .extend(other.triangles.iter().map(|t| t.map(|i| i + base)));
    }

    /// The shape moved by `map`, which must be invertible; mirroring keeps fronts in front.
    pub fn transformed(&self, map: Affine3A) -> Shape {
        let normal_map: Mat3A = map.matrix3.inverse().transpose();
        let mirrored = map.matrix3.determinant() < 0.0;
        let turn = |[a, b, c]: [u32; 3]| if mirrored { [a, c, b] } else { [a, b, c] };
        Shape {
            positions: self
                .positions
                .iter()
                .map(|&p| map.transform_point3(p))
                .collect(),
            normals: self
                .normals
                .iter()
                .map(|&n| (normal_map * n).normalize_or(Vec3::Y))
                .collect(),
            uvs: self.uvs.clone(),
            triangles: self.triangles.iter().map(|&t| turn(t)).collect(),
        }
    }

    /// The shape moved by a vector.
    pub fn at(&self, x: f32, y: f32, z: f32) -> Shape {
        self.transformed(Affine3A::from_translation(Vec3::new(x, y, z)))
    }
}

/// Twice the area of a flat polygon along its normal (Newell's formula).
fn area_vector(corners: &[Vec3]) -> Vec3 {
    (0..corners.len())
        .map(|i| corners[i].cross(corners[(i + 1) % corners.len()]))
        .sum()
}

/// Texture coordinates of a point of a flat face: the two axes that the face spans best, upright on walls.
pub(crate) fn flat_uv(p: Vec3, normal: Vec3) -> Vec2 {
    let n = normal.abs();
    if n.y >= n.x && n.y >= n.z {
        Vec2::new(p.x, p.z)
    } else if n.x >= n.z {
        Vec2::new(p.z, -p.y)
    } else {
        Vec2::new(p.x, -p.y)
    }
}
