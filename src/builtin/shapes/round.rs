//! Solids of revolution.
use super::{Shape, sweep::profile_normals};
use glam::{Affine3A, Quat, Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// Points of an arc about `centre`, from one angle to another in degrees, both ends included.
pub(crate) fn arc(
    centre: [f32; 2],
    radius: f32,
    from: f32,
    to: f32,
    pieces: usize,
) -> Vec<[f32; 2]> {
    (0..=pieces)
        .map(|i| {
            let angle = (from + (to - from) * i as f32 / pieces as f32).to_radians();
            [
                centre[0] + radius * angle.cos(),
                centre[1] + radius * angle.sin(),
            ]
        })
        .collect()
}

/// Turns the profile (radius, y) about the y axis. The profile goes counter-clockwise: up on the outside; where it does
/// not begin and end on the axis, it is closed from its end to its beginning. So the result is closed. With `faceted`,
/// the sides are flat.
pub(crate) fn lathe(profile: &[[f32; 2]], segments: usize, faceted: bool) -> Shape {
    let on_axis = |p: [f32; 2]| p[0] == 0.0;
    let is_open = profile.len() > 1 && on_axis(profile[0]) && on_axis(profile[profile.len() - 1]);
    let normals = profile_normals(profile);
    let edges = if is_open {
        profile.len() - 1
    } else {
        profile.len()
    };
    let widest = profile.iter().map(|p| p[0]).fold(0.0, f32::max);
    let spoke = |j: usize| Vec2::from_angle((j % segments) as f32 / segments as f32 * TAU);
    let half_turn = Vec2::from_angle(PI / segments as f32);
    let mut shape = Shape::default();
    let mut height = 0.0;
    for (i, (ends, length)) in normals.iter().take(edges).enumerate() {
        let points = [profile[i], profile[(i + 1) % profile.len()]];
        let row = |end: usize, j: usize, facet: Vec2| {
            let [radius, y] = points[end];
            let (direction, n) = (spoke(j), ends[end]);
            let normal = Vec3::new(facet.x * n.x, n.y, -facet.y * n.x);
            // A texture's u grows to the right, seen from outside.
            let uv = Vec2::new(
                j as f32 / segments as f32 * TAU * widest,
                -(height + length * end as f32),
            );
            (
                Vec3::new(direction.x * radius, y, -direction.y * radius),
                normal,
                uv,
            )
        };
        if faceted {
            for j in 0..segments {
                let facet = spoke(j).rotate(half_turn);
                shape.grid(2, 2, |a, b| row(a, j + b, facet));
            }
        } else {
            shape.grid(2, segments + 1, |a, j| row(a, j, spoke(j)));
        }
        height += length;
    }
    shape
}

/// A closed cylinder between two points.
pub(crate) fn cylinder(from: Vec3, to: Vec3, radius: f32, segments: usize) -> Shape {
    let length = (to - from).length();
    let profile = [[0.0, 0.0], [radius, 0.0], [radius, length], [0.0, length]];
    let turn = Quat::from_rotation_arc(Vec3::Y, (to - from).normalize_or(Vec3::Y));
    lathe(&profile, segments, false).transformed(Affine3A::from_rotation_translation(turn, from))
}

/// A closed sphere about the origin.
pub(crate) fn sphere(radius: f32, segments: usize) -> Shape {
    let mut profile = arc([0.0, 0.0], radius, -90.0, 90.0, segments / 2);
    // The cosine of 90 degrees is not zero in floating point, and the poles must lie on the axis.
    let last = profile.len() - 1;
    (profile[0][0], profile[last][0]) = (0.0, 0.0);
    lathe(&profile, segments, false)
}
