//! A room that is lit through one window only.
use super::assemble::{Assembly, sky, sun, view};
use super::shapes::{Shape, bevelled, cuboid, cylinder, shell};
use crate::view::View;
use gibs_passes::scene::Scene;
use glam::Vec3;

/// Inner corners of the room, metres. The window is in the +z side.
const INNER: [Vec3; 2] = [Vec3::new(-2.5, 0.0, -3.0), Vec3::new(2.5, 2.8, 3.0)];

/// Outer corners.
const OUTER: [Vec3; 2] = [Vec3::new(-2.85, -0.35, -3.35), Vec3::new(2.85, 3.15, 3.35)];

/// Least and greatest x and y of the window.
const WINDOW: [[f32; 2]; 2] = [[-0.6, 0.7], [0.95, 2.35]];

/// A furnished room of 5 x 2.8 x 6 m with thick walls; sun and sky reach it through a window of 1.3 x 1.4 m.
pub(super) fn window_room() -> (Scene, View) {
    let mut a = Assembly::new("window-room");
    let white = a.paint("white", [0.78, 0.76, 0.72]);
    let boards = a.paint("floor", [0.56, 0.42, 0.28]);
    let teal = a.paint("teal", [0.16, 0.46, 0.47]);
    let red = a.paint("red", [0.60, 0.11, 0.07]);
    let wood = a.paint("wood", [0.55, 0.36, 0.20]);

    let (outside, inside) = shell(INNER, OUTER, Some(WINDOW));
    a.draw("outside", white, &outside);
    let names = [
        "left wall",
        "right wall",
        "floor",
        "ceiling",
        "back wall",
        "window wall",
    ];
    let paints = [teal, white, boards, white, white, white];
    for i in 0..6 {
        a.draw(names[i], paints[i], &inside[i]);
    }
    a.draw("window frame", wood, &window_frame());
    a.draw("table", wood, &table());
    a.draw(
        "rug",
        red,
        &bevelled(
            Vec3::new(-1.4, -0.01, -0.9),
            Vec3::new(1.4, 0.012, 0.9),
            0.004,
        ),
    );
    let mut cupboard = bevelled(
        Vec3::new(0.9, -0.01, -2.95),
        Vec3::new(2.3, 1.9, -2.45),
        0.015,
    );
    cupboard.append(&bevelled(
        Vec3::new(0.86, 1.89, -2.97),
        Vec3::new(2.34, 1.94, -2.41),
        0.01,
    ));
    a.draw("cupboard", red, &cupboard);

    let mut view = view([2.0, 1.6, -2.0], [-1.6, 0.95, 2.2], 68.0, [960, 540]);
    view.sun = sun([0.38, -0.62, -1.0], [14.0, 12.8, 11.0]);
    view.environment = sky([1.2, 1.5, 2.0]);
    view.exposure = 3.0;
    (a.scene, view)
}

/// A frame in the middle of the reveal, with a cross.
fn window_frame() -> Shape {
    let [[x0, x1], [y0, y1]] = WINDOW;
    let (x, y) = ((x0 + x1) / 2.0, (y0 + y1) / 2.0);
    let bar = |x: [f32; 2], y: [f32; 2], z: [f32; 2]| {
        bevelled(
            Vec3::new(x[0], y[0], z[0]),
            Vec3::new(x[1], y[1], z[1]),
            0.004,
        )
    };
    // Ends and backs are sunk into the wall; uprights are deeper than crossbars, so that no two faces coincide.
    let (deep, flat) = ([3.13, 3.21], [3.135, 3.205]);
    let mut frame = bar([x0 - 0.05, x0 + 0.06], [y0 - 0.05, y1 + 0.05], deep);
    frame.append(&bar([x1 - 0.06, x1 + 0.05], [y0 - 0.05, y1 + 0.05], deep));
    frame.append(&bar([x0 - 0.04, x1 + 0.04], [y0 - 0.04, y0 + 0.06], flat));
    frame.append(&bar([x0 - 0.04, x1 + 0.04], [y1 - 0.06, y1 + 0.04], flat));
    frame.append(&bar(
        [x - 0.025, x + 0.025],
        [y0 - 0.03, y1 + 0.03],
        [3.15, 3.19],
    ));
    frame.append(&bar(
        [x0 - 0.03, x1 + 0.03],
        [y + 0.2, y + 0.24],
        [3.155, 3.185],
    ));
    frame
}

fn table() -> Shape {
    let mut table = bevelled(
        Vec3::new(-0.9, 0.71, -0.45),
        Vec3::new(0.9, 0.75, 0.45),
        0.01,
    );
    for (x, z) in [(-0.8, -0.36), (0.8, -0.36), (-0.8, 0.36), (0.8, 0.36)] {
        table.append(&cylinder(
            Vec3::new(x, -0.02, z),
            Vec3::new(x, 0.72, z),
            0.03,
            12,
        ));
    }
    table.append(&cuboid(
        Vec3::new(-0.79, 0.62, -0.35),
        Vec3::new(0.79, 0.715, -0.33),
    ));
    table.append(&cuboid(
        Vec3::new(-0.79, 0.62, 0.33),
        Vec3::new(0.79, 0.715, 0.35),
    ));
    table
}
