//! Profiles moved along paths: mouldings, walls with arches, rails.
use super::{Shape, flat_uv};
use glam::{Vec2, Vec3};

/// Profile edges that turn by less than this are smooth: its cosine (40 degrees).
const SMOOTH: f32 = 0.766;

/// Where a profile stands: profile point (a, b) is `origin + a u + b v`. The path must run along u x v.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    pub origin: Vec3,
    pub u: Vec3,
    pub v: Vec3,
}

impl Frame {
    fn place(&self, point: [f32; 2]) -> Vec3 {
        self.origin + self.u * point[0] + self.v * point[1]
    }
}

/// How the frames of a path belong together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Path {
    /// Open and smooth; the ends are capped.
    Smooth,
    /// Back to the first frame, with straight pieces that meet in mitres.
    Mitred,
}

/// The outward normals of a closed counter-clockwise profile at both ends of each edge, and the edges' lengths.
pub(super) fn profile_normals(profile: &[[f32; 2]]) -> Vec<([Vec2; 2], f32)> {
    let n = profile.len();
    let edge = |i: usize| Vec2::from(profile[(i + 1) % n]) - Vec2::from(profile[i % n]);
    let normal = |i: usize| edge(i).normalize_or_zero().perp() * -1.0;
    let blend = |a: Vec2, b: Vec2| {
        if a.dot(b) > SMOOTH {
            (a + b).normalize_or(a)
        } else {
            a
        }
    };
    (0..n)
        .map(|i| {
            let own = normal(i);
            let ends = [blend(own, normal(i + n - 1)), blend(own, normal(i + 1))];
            (ends, edge(i).length())
        })
        .collect()
}

/// Moves a closed counter-clockwise profile along a path of frames. The result is closed.
pub(crate) fn sweep(profile: &[[f32; 2]], frames: &[Frame], path: Path) -> Shape {
    let mut shape = Shape::default();
    let edges = profile_normals(profile);
    let segments = if path == Path::Mitred {
        frames.len()
    } else {
        frames.len() - 1
    };
    let mut along = 0.0;
    for k in 0..segments {
        let (near, far) = (&frames[k], &frames[(k + 1) % frames.len()]);
        let middle = profile[0];
        let step = far.place(middle) - near.place(middle);
        let tangent = step.normalize_or_zero();
        let normal_at = |frame: &Frame, n: Vec2| match path {
            Path::Smooth => (frame.u * n.x + frame.v * n.y).normalize_or(frame.u),
            Path::Mitred => {
                let square = |axis: Vec3| (axis - tangent * axis.dot(tangent)).normalize_or_zero();
                (square(frame.u) * n.x + square(frame.v) * n.y).normalize_or(frame.u)
            }
        };
        let mut around = 0.0;
        for (i, (normals, length)) in edges.iter().enumerate() {
            let ends = [profile[i], profile[(i + 1) % profile.len()]];
            let face = normal_at(near, (normals[0] + normals[1]) / 2.0);
            let level = path == Path::Mitred && face.y.abs() > 0.9;
            let corner = |end: usize, frame: &Frame, distance: f32| {
                let p = frame.place(ends[end]);
                // Level faces keep the ground plan, so that tiles and boards do not turn with the path.
                let uv = match level {
                    true => flat_uv(p, face),
                    false => Vec2::new(distance, -(around + length * end as f32)),
                };
                (p, normal_at(frame, normals[end]), uv)
            };
            let end = along + step.length();
            let quad = [
                corner(0, near, along),
                corner(1, near, along),
                corner(1, far, end),
                corner(0, far, end),
            ]
            .map(|(p, n, uv)| shape.vertex(p, n, uv));
            shape.triangle([quad[0], quad[1], quad[2]]);
            shape.triangle([quad[0], quad[2], quad[3]]);
            around += length;
        }
        along += step.length();
    }
    if path == Path::Smooth {
        let faces = triangulate(profile);
        for (frame, is_end) in [(&frames[0], false), (&frames[frames.len() - 1], true)] {
            let outward =
                frame.u.cross(frame.v).normalize_or(Vec3::Y) * if is_end { 1.0 } else { -1.0 };
            let base = shape.positions.len() as u32;
            for &point in profile {
                let p = frame.place(point);
                shape.vertex(p, outward, flat_uv(p, outward));
            }
            for &[a, b, c] in &faces {
                let t = if is_end { [a, b, c] } else { [a, c, b] };
                shape.triangle(t.map(|i| i + base));
            }
        }
    }
    shape
}

/// A closed prism: the counter-clockwise outline (x, y) from z = `from` to z = `to`.
pub(crate) fn extrude(outline: &[[f32; 2]], from: f32, to: f32) -> Shape {
    let frame = |z: f32| Frame {
        origin: Vec3::Z * z,
        u: Vec3::X,
        v: Vec3::Y,
    };
    sweep(outline, &[frame(from), frame(to)], Path::Smooth)
}

/// A closed ring around the axis y over the rectangle of the given half sides (x, z). Profile points are (distance
/// inwards from the rectangle, y), counter-clockwise; so -1 is a metre outside of the rectangle.
pub(crate) fn ring(half: [f32; 2], profile: &[[f32; 2]]) -> Shape {
    let frames =
        [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]].map(|[x, z]: [f32; 2]| Frame {
            origin: Vec3::new(x * half[0], 0.0, z * half[1]),
            u: Vec3::new(-x, 0.0, -z),
            v: Vec3::Y,
        });
    sweep(profile, &frames, Path::Mitred)
}

/// Triangles of a simple counter-clockwise polygon, by cutting ears; the ear with the widest smallest angle first
/// would be prettier, but flat faces do not show it.
pub(super) fn triangulate(outline: &[[f32; 2]]) -> Vec<[u32; 3]> {
    let point = |i: u32| Vec2::from(outline[i as usize]);
    let area = |a: u32, b: u32, c: u32| (point(b) - point(a)).perp_dot(point(c) - point(a));
    let mut left: Vec<u32> = (0..outline.len() as u32).collect();
    let mut triangles = Vec::with_capacity(outline.len());
    while left.len() > 3 {
        let n = left.len();
        let at = |i: usize| left[i % n];
        let is_ear = |i: usize| {
            let [a, b, c] = [at(i + n - 1), at(i), at(i + 1)];
            area(a, b, c) > 0.0
                && (2..n - 1)
                    .map(|k| at(i + k))
                    .all(|p| area(a, b, p) < 0.0 || area(b, c, p) < 0.0 || area(c, a, p) < 0.0)
        };
        // A polygon that crosses itself has no ear at some point; cutting anything still ends.
        let ear = (0..n).find(|&i| is_ear(i)).unwrap_or(0);
        triangles.push([at(ear + n - 1), at(ear), at(ear + 1)]);
        left.remove(ear);
    }
    triangles.push([left[0], left[1], left[2]]);
    triangles
}
