//! Rooms that are hollows in one solid, so that every wall is as thick as the distance between its faces.
use super::parts::{FAR, HEIGHT, Paints, THIN, ceiling_panel, look, outside, room};
use crate::builtin::assemble::Assembly;
use crate::builtin::shapes::bevelled;
use crate::view::View;
use gibs_passes::scene::Scene;
use glam::Vec3;

/// Depth of each of two rooms beside each other, metres.
const DEPTH: f32 = 4.0;

/// Thickness of the shared wall in the built-in scene `sealed-rooms`, metres.
pub const SEALED_ROOMS_WALL: f64 = 0.1;

/// Two closed rooms, 3 m high and 4 m deep, in a building 10 m across, that share a wall `wall` metres thick (kept
/// within 0.001 to 0.5), and a view into the bright and into the dark one. Nothing connects them, so the irradiance in the dark
/// room is exactly zero.
pub fn sealed_rooms(wall: f64) -> (Scene, View, View) {
    let half = wall.clamp(0.001, 0.5) as f32 / 2.0;
    let mut a = Assembly::new("sealed-rooms");
    let paints = Paints::new(&mut a);
    let back = -DEPTH / 2.0;
    outside(
        &mut a,
        &paints,
        Vec3::new(-FAR, 0.0, back),
        Vec3::new(FAR, HEIGHT, -back),
    );
    let sides = [
        ("bright room", -1.0, paints.orange),
        ("dark room", 1.0, paints.blue),
    ];
    for (name, side, accent) in sides {
        let (near, far): (f32, f32) = (side * half, side * FAR);
        let low = Vec3::new(near.min(far), 0.0, back);
        let high = Vec3::new(near.max(far), HEIGHT, -back);
        room(&mut a, &paints, name, accent, low, high);
        // Sunk into the floor, so that no two faces coincide.
        let box_low = Vec3::new((near + far) / 2.0 - 0.4, -0.01, -0.9);
        let box_high = box_low + Vec3::new(0.8, 0.91, 0.8);
        a.draw("box", paints.white, &bevelled(box_low, box_high, 0.02));
    }
    ceiling_panel(&mut a, &paints, -(half + FAR) / 2.0, 0.0);
    let into = |side: f64| {
        let middle = side * f64::from(half + FAR) / 2.0;
        look(
            [middle + side * 1.9, 1.7, 1.8],
            [middle - side * 0.9, 1.1, -1.2],
            70.0,
        )
    };
    (a.scene, into(-1.0), into(1.0))
}

/// Four rooms around an edge, with walls of 1 mm; one is lit, and the dark one that is seen lies across the edge.
pub(super) fn edge() -> (Scene, View, View) {
    let mut a = Assembly::new("sealed-edge");
    let paints = Paints::new(&mut a);
    let corner = Vec3::new(FAR, 0.0, FAR);
    outside(&mut a, &paints, -corner, corner.with_y(HEIGHT));
    let (near, far) = (THIN / 2.0, FAR);
    for (name, x, z, accent) in [
        ("bright room", -1.0, -1.0, paints.orange),
        ("right room", 1.0, -1.0, paints.blue),
        ("left room", -1.0, 1.0, paints.blue),
        ("dark room", 1.0, 1.0, paints.blue),
    ] {
        let (one, other) = (
            Vec3::new(x * near, 0.0, z * near),
            Vec3::new(x * far, HEIGHT, z * far),
        );
        room(
            &mut a,
            &paints,
            name,
            accent,
            one.min(other),
            one.max(other),
        );
    }
    ceiling_panel(&mut a, &paints, -FAR / 2.0, -FAR / 2.0);
    let into = |side: f64| {
        look(
            [side * 3.8, 1.7, side * 3.4],
            [side * 0.3, 1.0, side * 0.1],
            70.0,
        )
    };
    (a.scene, into(-1.0), into(1.0))
}
