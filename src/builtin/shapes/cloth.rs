//! Sheets of cloth.
use super::Shape;
use glam::{Vec2, Vec3};

/// A closed sheet of `thickness` about the surface `at(s, t)`, s and t from 0 to 1. Seen from its front, s runs to the
/// right and t down. Texture coordinates are (s, t).
pub(crate) fn sheet(
    columns: usize,
    rows: usize,
    thickness: f32,
    at: impl Fn(f32, f32) -> Vec3,
) -> Shape {
    let coordinates =
        |i: usize, j: usize| Vec2::new(j as f32 / columns as f32, i as f32 / rows as f32);
    let normal = |i: usize, j: usize| {
        let (c, h) = (coordinates(i, j), 1e-2);
        let along_s = at((c.x + h).min(1.0), c.y) - at((c.x - h).max(0.0), c.y);
        let along_t = at(c.x, (c.y + h).min(1.0)) - at(c.x, (c.y - h).max(0.0));
        along_t.cross(along_s).normalize_or(Vec3::Z)
    };
    let point = |i: usize, j: usize, side: f32| {
        let c = coordinates(i, j);
        at(c.x, c.y) + normal(i, j) * (side * thickness / 2.0)
    };
    let mut shape = Shape::default();
    shape.grid(columns + 1, rows + 1, |j, i| {
        (
            point(rows - i, j, -1.0),
            -normal(rows - i, j),
            coordinates(rows - i, j),
        )
    });
    shape.grid(rows + 1, columns + 1, |i, j| {
        let i = rows - i;
        (point(i, j, 1.0), normal(i, j), coordinates(i, j))
    });
    // The rim, counter-clockwise seen from the front: down the left side, along the bottom, up, and back.
    let left = (0..rows).map(|i| (i, 0));
    let bottom = (0..columns).map(|j| (rows, j));
    let right = (1..=rows).rev().map(|i| (i, columns));
    let top = (1..=columns).rev().map(|j| (0, j));
    let rim: Vec<(usize, usize)> = left.chain(bottom).chain(right).chain(top).collect();
    for k in 0..rim.len() {
        let ((i, j), (m, n)) = (rim[k], rim[(k + 1) % rim.len()]);
        let corners = [
            point(i, j, -1.0),
            point(m, n, -1.0),
            point(m, n, 1.0),
            point(i, j, 1.0),
        ];
        let outward = super::area_vector(&corners).normalize_or(Vec3::Y);
        let [a, b] = [coordinates(i, j), coordinates(m, n)];
        let quad =
            [(0, a), (1, b), (2, b), (3, a)].map(|(c, uv)| shape.vertex(corners[c], outward, uv));
        shape.triangle([quad[0], quad[1], quad[2]]);
        shape.triangle([quad[0], quad[2], quad[3]]);
    }
    shape
}
