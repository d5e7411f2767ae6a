//! Small orange trees in terracotta pots around the court.
use super::palette::Palette;
use super::{BAY, SIDES};
use crate::builtin::assemble::Assembly;
use crate::builtin::noise::chance;
use crate::builtin::shapes::{Shape, cylinder, lathe, sphere};
use glam::{Quat, Vec3};
use std::f32::consts::TAU;

pub(super) fn plants(a: &mut Assembly, palette: &Palette) {
    let pot = [
        [0.0, -0.01],
        [0.24, -0.01],
        [0.26, 0.04],
        [0.24, 0.08],
        [0.33, 0.40],
        [0.36, 0.50],
        [0.41, 0.52],
        [0.41, 0.60],
        [0.38, 0.62],
        [0.34, 0.60],
        [0.33, 0.53],
        [0.0, 0.53],
    ];
    let soil = [[0.0, 0.50], [0.335, 0.50], [0.335, 0.55], [0.0, 0.58]];
    let pot = a.mesh("pot", palette.terracotta, &lathe(&pot, 24, false));
    let soil = a.mesh("soil", palette.soil, &lathe(&soil, 24, false));
    let trunk = cylinder(
        Vec3::new(0.0, 0.52, 0.0),
        Vec3::new(0.03, 1.4, 0.02),
        0.035,
        10,
    );
    let trunk = a.mesh("trunk", palette.dark_wood, &trunk);
    for side in SIDES.iter().filter(|side| side.is_long) {
        for along in [-2.0 * BAY, 0.0, 2.0 * BAY] {
            let seed = (side.depth * 10.0 + along * 7.0 + side.turn as f32 * 3.0) as i32;
            let crown = a.mesh("leaves", palette.leaves, &crown(seed));
            let fruit = a.mesh("oranges", palette.orange, &fruit(seed));
            let at = side.at(along, 1.35, 0.0);
            a.place(
                "orange tree",
                &[pot, soil, trunk, crown, fruit],
                at,
                chance(seed, 0, 81).into(),
            );
        }
    }
}

const MIDDLE: Vec3 = Vec3::new(0.03, 1.72, 0.02);

/// A direction that fills the sphere evenly as `i` runs from 0 to `n` (a Fibonacci lattice).
fn direction(i: i32, n: i32) -> Vec3 {
    let y = 1.0 - (2 * i + 1) as f32 / n as f32;
    let angle = i as f32 * 0.618_034 * TAU;
    let r = (1.0 - y * y).sqrt();
    Vec3::new(r * angle.cos(), y, r * angle.sin())
}

/// How far the crown reaches in a direction.
fn reach(d: Vec3, seed: i32) -> f32 {
    let phase = chance(seed, 1, 82) * TAU;
    0.52 * (1.0 + 0.10 * (3.0 * d.x + phase).sin() + 0.08 * (4.0 * d.z - phase).cos() + 0.05 * d.y)
}

/// Folded leaves around a dense core.
fn crown(seed: i32) -> Shape {
    const LEAVES: i32 = 580;
    let mut shape = sphere(0.36, 16).at(MIDDLE.x, MIDDLE.y, MIDDLE.z);
    for i in 0..LEAVES {
        let random = |what: i32| chance(i, seed * 8 + what, 83);
        let d = direction(i, LEAVES);
        let at = MIDDLE + d * reach(d, seed) * (0.66 + 0.38 * random(0));
        let jitter = Vec3::new(random(1) - 0.5, random(2) - 0.2, random(3) - 0.5);
        let normal = (d + 0.9 * jitter).normalize_or(d);
        let turn =
            Quat::from_rotation_arc(Vec3::Y, normal) * Quat::from_rotation_y(random(4) * TAU);
        let size = 0.09 + 0.04 * random(5);
        let point = |x: f32, y: f32, z: f32| at + turn * (Vec3::new(x, y, z) * size);
        let (stem, tip) = (point(-0.8, 0.0, 0.0), point(0.8, -0.15, 0.0));
        shape.polygon(&[stem, point(0.0, 0.12, 0.38), tip]);
        shape.polygon(&[tip, point(0.0, 0.12, -0.38), stem]);
    }
    shape
}

fn fruit(seed: i32) -> Shape {
    const ORANGES: i32 = 14;
    let orange = sphere(0.042, 8);
    let mut shape = Shape::default();
    for i in 0..ORANGES {
        let d = direction(i, ORANGES);
        let d =
            (d + Vec3::new(chance(i, seed, 84), chance(i, seed, 85), 0.0) * 0.4).normalize_or(d);
        let at = MIDDLE + d * reach(d, seed) * 0.98;
        shape.append(&orange.at(at.x, at.y, at.z));
    }
    shape
}
