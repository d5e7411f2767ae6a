//! Two sealed rooms beside each other, one lit and one dark: no light may leak.
use super::assemble::{Assembly, view};
use super::shapes::{Shape, bevelled, cuboid};
use crate::view::View;
use gibs_passes::scene::Scene;
use glam::{DVec3, Vec3};

/// Inner size of each room, metres.
const ROOM: Vec3 = Vec3::new(4.0, 3.0, 4.0);

/// Thickness of all walls but the shared one, metres.
const OUTER: f32 = 0.3;

/// Thickness of the shared wall in the built-in scene `sealed-rooms`, metres.
pub const SEALED_ROOMS_WALL: f64 = 0.1;

/// Two closed rooms of 4 x 3 x 4 m that share a wall `wall` metres thick (kept within 0.001 to 0.5), and a view into
/// the bright and into the dark one. Nothing connects them, so the irradiance in the dark room is exactly zero.
pub fn sealed_rooms(wall: f64) -> (Scene, View, View) {
    let half = wall.clamp(0.001, 0.5) as f32 / 2.0;
    let mut a = Assembly::new("sealed-rooms");
    let white = a.paint("white", [0.75, 0.75, 0.73]);
    let orange = a.paint("orange", [0.75, 0.36, 0.11]);
    let blue = a.paint("blue", [0.14, 0.28, 0.62]);
    let light = a.glow("ceiling panel", 0.7, [10.0, 9.3, 8.0]);

    let far = half + ROOM.x;
    let low = Vec3::new(-far - OUTER, -OUTER, -ROOM.z / 2.0 - OUTER);
    let high = Vec3::new(far + OUTER, ROOM.y + OUTER, ROOM.z / 2.0 + OUTER);
    a.draw("outside", white, &cuboid(low, high));
    // Both rooms are hollows in one solid, so every wall is as thick as the distance between its faces.
    for (name, side, accent) in [("bright room", -1.0, orange), ("dark room", 1.0, blue)] {
        let (near, far) = (side * half, side * far);
        let low = Vec3::new(near.min(far), 0.0, -ROOM.z / 2.0);
        let high = Vec3::new(near.max(far), ROOM.y, ROOM.z / 2.0);
        let (plain, colored) = hollow(low, high);
        let meshes = [a.mesh(name, white, &plain), a.mesh(name, accent, &colored)];
        a.place(name, &meshes, [0.0; 3], 0.0);
        // Sunk into the floor, so that no two faces coincide.
        let box_low = Vec3::new((near + far) / 2.0 - 0.4, -0.01, -0.9);
        a.draw(
            "box",
            white,
            &bevelled(box_low, box_low + Vec3::new(0.8, 0.91, 0.8), 0.02),
        );
    }
    let middle = -half - ROOM.x / 2.0;
    let panel = [[-0.6, -0.6], [0.6, -0.6], [0.6, 0.6], [-0.6, 0.6]]
        .map(|[x, z]: [f32; 2]| Vec3::new(middle + x, ROOM.y - 0.01, z));
    let mut shape = Shape::default();
    shape.polygon(&panel);
    a.draw("ceiling panel", light, &shape);

    let into = |side: f64| {
        let middle = side * f64::from(half + ROOM.x / 2.0);
        let mut view = view([0.0; 3], [0.0; 3], 70.0, [640, 480]);
        view.exposure = 0.35;
        view.camera.position = DVec3::new(middle + side * 1.8, 1.7, 1.8);
        view.camera.target = DVec3::new(middle - side * 0.9, 1.1, -1.2);
        view
    };
    (a.scene, into(-1.0), into(1.0))
}

/// The six faces of a room, seen from inside: the back one (-z) apart from the others.
fn hollow(low: Vec3, high: Vec3) -> (Shape, Shape) {
    let mut room = cuboid(low, high);
    room.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    room.normals.iter_mut().for_each(|n| *n = -*n);
    let is_back = |t: &&[u32; 3]| room.normals[t[0] as usize].z > 0.5;
    let (back, others) = room.triangles.iter().partition(is_back);
    (
        Shape {
            triangles: others,
            ..room.clone()
        },
        Shape {
            triangles: back,
            ..room
        },
    )
}
