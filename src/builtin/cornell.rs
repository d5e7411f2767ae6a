//! The Cornell box.
//!
//! Measurements: Cornell University Program of Computer Graphics, "Cornell Box Data" (1998), in millimetres. Here one
//! unit of the data is a centimetre, which makes the box the size of a room; the light hangs half a unit below the
//! ceiling, so that the two do not coincide. Reflectances are the usual RGB stand-ins for the measured spectra.
use super::assemble::{Assembly, view};
use super::shapes::Shape;
use crate::view::View;
use gibs_passes::scene::Scene;
use glam::Vec3;

/// A quad in the units of the data, counter-clockwise from the front.
type Quad = [[f32; 3]; 4];

const FLOOR: Quad = [
    [552.8, 0.0, 0.0],
    [0.0, 0.0, 0.0],
    [0.0, 0.0, 559.2],
    [549.6, 0.0, 559.2],
];
const CEILING: Quad = [
    [556.0, 548.8, 0.0],
    [556.0, 548.8, 559.2],
    [0.0, 548.8, 559.2],
    [0.0, 548.8, 0.0],
];
const BACK: Quad = [
    [549.6, 0.0, 559.2],
    [0.0, 0.0, 559.2],
    [0.0, 548.8, 559.2],
    [556.0, 548.8, 559.2],
];
const RIGHT: Quad = [
    [0.0, 0.0, 559.2],
    [0.0, 0.0, 0.0],
    [0.0, 548.8, 0.0],
    [0.0, 548.8, 559.2],
];
const LEFT: Quad = [
    [552.8, 0.0, 0.0],
    [549.6, 0.0, 559.2],
    [556.0, 548.8, 559.2],
    [556.0, 548.8, 0.0],
];
const LIGHT: Quad = [
    [343.0, 548.3, 227.0],
    [343.0, 548.3, 332.0],
    [213.0, 548.3, 332.0],
    [213.0, 548.3, 227.0],
];

/// The tops of the two blocks: corners (x, z), counter-clockwise from above, and height.
const BLOCKS: [(&str, [[f32; 2]; 4], f32); 2] = [
    (
        "short block",
        [[130.0, 65.0], [82.0, 225.0], [240.0, 272.0], [290.0, 114.0]],
        165.0,
    ),
    (
        "tall block",
        [
            [423.0, 247.0],
            [265.0, 296.0],
            [314.0, 456.0],
            [472.0, 406.0],
        ],
        330.0,
    ),
];

fn quad(corners: Quad) -> Shape {
    let mut shape = Shape::default();
    shape.polygon(&corners.map(|c| Vec3::from_array(c) / 100.0));
    shape
}

/// A block that stands on the floor, so without an underside.
fn block(top: [[f32; 2]; 4], height: f32) -> Shape {
    let corner = |i: usize, y: f32| Vec3::new(top[i % 4][0], y, top[i % 4][1]) / 100.0;
    let mut shape = Shape::default();
    shape.polygon(&[0, 1, 2, 3].map(|i| corner(i, height)));
    for i in 0..4 {
        shape.polygon(&[
            corner(i + 1, height),
            corner(i, height),
            corner(i, 0.0),
            corner(i + 1, 0.0),
        ]);
    }
    shape
}

/// The empty box with its light; returns the index of the white material too.
pub(super) fn walls(name: &str) -> (Assembly, u32) {
    let mut a = Assembly::new(name);
    let white = a.paint("white", [0.73, 0.73, 0.73]);
    let green = a.paint("green", [0.105, 0.378, 0.076]);
    let red = a.paint("red", [0.570, 0.043, 0.044]);
    let light = a.glow("light", 0.78, [18.4, 15.6, 8.0]);
    for (name, material, corners) in [
        ("floor", white, FLOOR),
        ("ceiling", white, CEILING),
        ("back wall", white, BACK),
        ("right wall", green, RIGHT),
        ("left wall", red, LEFT),
        ("light", light, LIGHT),
    ] {
        a.draw(name, material, &quad(corners));
    }
    (a, white)
}

/// The camera of the data: 0.035 m focal length, 0.025 m square film.
pub(super) fn camera() -> View {
    let vfov = 2.0 * (0.025_f64 / 2.0 / 0.035).atan().to_degrees();
    view([2.78, 2.73, -8.0], [2.78, 2.73, 0.0], vfov, [512, 512])
}

/// The box with both blocks: 32 triangles.
pub(super) fn cornell() -> (Scene, View) {
    let (mut a, white) = walls("cornell");
    for (name, top, height) in BLOCKS {
        a.draw(name, white, &block(top, height));
    }
    (a.scene, camera())
}
