//! What the sealed scenes are put together from.
use crate::builtin::assemble::{Assembly, view};
use crate::builtin::shapes::{Shape, cuboid};
use crate::view::View;
use glam::{DVec3, Vec3};

/// From the middle of a building to the inside of its outer walls, metres.
pub(super) const FAR: f32 = 4.7;

/// Thickness of outer walls, metres.
pub(super) const OUTER: f32 = 0.3;

/// Height of rooms, metres.
pub(super) const HEIGHT: f32 = 3.0;

/// Thickness of thin walls and partitions, metres.
pub(super) const THIN: f32 = 0.001;

/// How far partitions and pillars are sunk into what they stand on, metres.
pub(super) const SUNK: f32 = 0.05;

/// The colours that every sealed scene has.
pub(super) struct Paints {
    pub white: u32,
    pub orange: u32,
    pub blue: u32,
    pub light: u32,
}

impl Paints {
    pub fn new(a: &mut Assembly) -> Self {
        Self {
            white: a.paint("white", [0.75, 0.75, 0.73]),
            orange: a.paint("orange", [0.75, 0.36, 0.11]),
            blue: a.paint("blue", [0.14, 0.28, 0.62]),
            light: a.glow("ceiling panel", 0.7, [10.0, 9.3, 8.0]),
        }
    }
}

/// Draws the outside of a building whose rooms lie between these corners.
pub(super) fn outside(a: &mut Assembly, paints: &Paints, low: Vec3, high: Vec3) {
    let walls = Vec3::splat(OUTER);
    a.draw("outside", paints.white, &cuboid(low - walls, high + walls));
}

/// Draws a room as a hollow in the building: its back wall (-z) in a colour, the others white.
pub(super) fn room(
    a: &mut Assembly,
    paints: &Paints,
    name: &str,
    accent: u32,
    low: Vec3,
    high: Vec3,
) {
    let (plain, colored) = hollow(low, high);
    let meshes = [
        a.mesh(name, paints.white, &plain),
        a.mesh(name, accent, &colored),
    ];
    a.place(name, &meshes, [0.0; 3], 0.0);
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

/// Draws an emissive square of 1.2 m just below the ceiling.
pub(super) fn ceiling_panel(a: &mut Assembly, paints: &Paints, x: f32, z: f32) {
    let corners = [[-0.6, -0.6], [0.6, -0.6], [0.6, 0.6], [-0.6, 0.6]]
        .map(|[dx, dz]: [f32; 2]| Vec3::new(x + dx, HEIGHT - 0.01, z + dz));
    let mut shape = Shape::default();
    shape.polygon(&corners);
    a.draw("ceiling panel", paints.light, &shape);
}

/// A box from floor to ceiling, sunk into both, between two places on the ground.
pub(super) fn upright(low: [f32; 2], high: [f32; 2]) -> Shape {
    cuboid(
        Vec3::new(low[0], -SUNK, low[1]),
        Vec3::new(high[0], HEIGHT + SUNK, high[1]),
    )
}

/// A view from one place to another, as bright as suits the lit part.
pub(super) fn look(from: [f64; 3], to: [f64; 3], vfov_degrees: f64) -> View {
    let mut view = view([0.0; 3], [0.0; 3], vfov_degrees, [640, 360]);
    view.exposure = 0.35;
    view.camera.position = DVec3::from_array(from);
    view.camera.target = DVec3::from_array(to);
    view
}
