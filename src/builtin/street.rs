//! A street at night under strings of small lamps: very many point lights.
use super::assemble::{Assembly, sky, view};
use super::noise::chance;
use super::shapes::{Frame, Path, Shape, bevelled, cuboid, cylinder, extrude, sweep};
use crate::view::View;
use gibs_passes::scene::{Light, LightKind, Scene};
use glam::Vec3;
use std::f64::consts::FRAC_PI_2;

/// Strings across the street, and lamps on each.
const STRINGS: i32 = 40;
const LAMPS: i32 = 35;

/// Distance between strings, metres.
const STRING_SPACING: f32 = 2.0;

/// Half the distance between the house fronts, metres.
const HALF_WIDTH: f32 = 6.5;

/// Height of the ends of the strings, metres, and how far they sag.
const STRING_HEIGHT: f32 = 6.2;
const SAG: f32 = 0.9;

/// Houses on each side and the width of each, metres.
const HOUSES: i32 = 8;
const HOUSE_WIDTH: f32 = 11.0;

/// Height of a storey, metres.
const STOREY: f32 = 3.2;

/// A street of 88 m with 1400 point lights of 0.1 to 0.5 W/sr in warm and some coloured hues, under a nearly black sky.
pub(super) fn many_lights() -> (Scene, View) {
    let mut a = Assembly::new("many-lights");
    ground(&mut a);
    houses(&mut a);
    strings(&mut a);
    let mut view = view([1.2, 1.75, 2.0], [-0.6, 3.4, -22.0], 62.0, [960, 540]);
    view.environment = sky([0.002, 0.003, 0.006]);
    view.exposure = 2.0;
    (a.scene, view)
}

fn ground(a: &mut Assembly) {
    let asphalt = a.paint("road", [0.16, 0.16, 0.17]);
    let stone = a.paint("pavement", [0.38, 0.36, 0.33]);
    let end = -(HOUSE_WIDTH * HOUSES as f32) - 8.0;
    a.draw(
        "road",
        asphalt,
        &cuboid(Vec3::new(-20.0, -0.5, end), Vec3::new(20.0, 0.0, 12.0)),
    );
    let (kerb, back) = (HALF_WIDTH - 2.4, HALF_WIDTH + 2.0);
    for (from, to) in [(-back, -kerb), (kerb, back)] {
        let slab = bevelled(
            Vec3::new(from, -0.2, end + 0.5),
            Vec3::new(to, 0.14, 11.5),
            0.03,
        );
        a.draw("pavement", stone, &slab);
    }
    let wall = cuboid(
        Vec3::new(-19.0, -0.3, end + 1.0),
        Vec3::new(19.0, 11.0, end + 2.5),
    );
    a.draw("end of the street", stone, &wall);
}

/// Houses in local space: x along the front, z out of it.
fn houses(a: &mut Assembly) {
    let paints = [
        [0.66, 0.48, 0.30],
        [0.55, 0.24, 0.16],
        [0.62, 0.58, 0.50],
        [0.34, 0.42, 0.46],
    ]
    .map(|color| a.paint("plaster", color));
    let trim = a.paint("trim", [0.60, 0.58, 0.54]);
    let pane = a.paint("window pane", [0.06, 0.07, 0.08]);
    let door_paint = a.paint("door", [0.12, 0.20, 0.14]);
    let awnings = [[0.62, 0.08, 0.06], [0.08, 0.30, 0.14], [0.75, 0.55, 0.14]]
        .map(|color| a.paint("awning", color));

    let window = [
        a.mesh("window frame", trim, &window_frame()),
        a.mesh("window pane", pane, &window_pane()),
    ];
    let leaf = bevelled(
        Vec3::new(-0.55, -0.1, -0.05),
        Vec3::new(0.55, 2.3, 0.03),
        0.01,
    );
    let door = [
        a.mesh("door frame", trim, &door_frame()),
        a.mesh("door", door_paint, &leaf),
    ];
    let slope = [[0.0, 2.62], [1.3, 2.15], [1.3, 2.22], [0.0, 2.72]];
    // Extruded along z with the slope in x; turned so that it comes out of the front.
    let awning_shape = extrude(&slope, -1.5, 1.5);
    let awnings = awnings.map(|paint| a.mesh("awning", paint, &awning_shape));

    for side in [-1.0_f32, 1.0] {
        let turn = f64::from(-side) * FRAC_PI_2;
        for house in 0..HOUSES {
            let seed = if side > 0.0 { 7 } else { 11 };
            let random = |what: i32| chance(house, what, seed);
            let storeys = 3 + (random(0) * 3.0) as i32;
            let height = 0.75 + 0.3 * random(7) + STOREY * storeys as f32;
            let set_back = random(1) * 0.4;
            let middle = -(house as f32 + 0.5) * HOUSE_WIDTH + 4.0;
            // Maps (along the front, up, out of it) to the street.
            let at = |along: f32, up: f32, out: f32| {
                let x = side * (HALF_WIDTH + set_back - out);
                [
                    f64::from(x),
                    f64::from(up),
                    f64::from(middle - side * along),
                ]
            };
            // Neighbours overlap, and differ in depth and height, so that no two faces coincide.
            let half = HOUSE_WIDTH / 2.0 + 0.05 + random(2) * 0.1;
            let mut body = cuboid(
                Vec3::new(-half, -0.3 - 0.1 * random(8), -8.0 - random(3)),
                Vec3::new(half, height, 0.0),
            );
            body.append(&bevelled(
                Vec3::new(-half + 0.02, -0.05 - 0.1 * random(8), -1.0),
                Vec3::new(half - 0.02, 0.6 + random(4) * 0.2, 0.06),
                0.02,
            ));
            let paint = paints[(house + i32::from(side > 0.0)) as usize % paints.len()];
            let body = a.mesh("house", paint, &body);
            let cornice = a.mesh("cornice", trim, &cornice(half, height));
            a.place("house", &[body, cornice], at(0.0, 0.0, 0.0), turn);
            for column in 0..4 {
                let along = (column as f32 - 1.5) * 2.6;
                for storey in 1..storeys {
                    let up = STOREY * storey as f32 + 1.0;
                    a.place("window", &window, at(along, up, 0.0), turn);
                }
                match column == (random(5) * 4.0) as i32 {
                    true => a.place("door", &door, at(along, 0.14, 0.0), turn),
                    false => a.place("window", &window, at(along, 1.15, 0.0), turn),
                };
            }
            if house % 2 == i32::from(side > 0.0) {
                let awning = awnings[(random(6) * 3.0) as usize % awnings.len()];
                // The awning's slope runs along its own x, which is this much further round than the front.
                a.place("awning", &[awning], at(1.3, 0.35, -0.05), turn - FRAC_PI_2);
            }
        }
    }
}

fn window_frame() -> Shape {
    let [width, height] = [0.52, 0.85];
    let corners = [
        [-width, 0.0],
        [width, 0.0],
        [width, 2.0 * height],
        [-width, 2.0 * height],
    ];
    let frames = corners.map(|[x, y]: [f32; 2]| Frame {
        origin: Vec3::new(x, y, 0.0),
        u: Vec3::new(x.signum(), (y - height).signum(), 0.0),
        v: Vec3::Z,
    });
    // Around the opening counter-clockwise, u outwards: u x v runs backwards, so the path does too.
    let reversed = [frames[0], frames[3], frames[2], frames[1]];
    let outline = [
        [-0.06, -0.05],
        [0.1, -0.05],
        [0.1, 0.05],
        [0.05, 0.09],
        [-0.06, 0.09],
    ];
    // Parts are sunk into the wall by different depths, so that no two faces coincide.
    let mut shape = sweep(&outline, &reversed, Path::Mitred);
    shape.append(&bevelled(
        Vec3::new(-0.75, -0.2, -0.045),
        Vec3::new(0.75, -0.11, 0.2),
        0.015,
    ));
    shape.append(&bevelled(
        Vec3::new(-0.02, -0.02, -0.03),
        Vec3::new(0.02, 1.72, 0.05),
        0.005,
    ));
    shape.append(&bevelled(
        Vec3::new(-0.49, 1.1, -0.035),
        Vec3::new(0.49, 1.14, 0.045),
        0.005,
    ));
    shape
}

fn window_pane() -> Shape {
    cuboid(Vec3::new(-0.5, 0.02, -0.04), Vec3::new(0.5, 1.68, 0.02))
}

fn door_frame() -> Shape {
    let mut shape = bevelled(
        Vec3::new(-0.75, -0.1, -0.05),
        Vec3::new(-0.54, 2.32, 0.1),
        0.015,
    );
    shape.append(&bevelled(
        Vec3::new(0.54, -0.1, -0.05),
        Vec3::new(0.75, 2.32, 0.1),
        0.015,
    ));
    shape.append(&bevelled(
        Vec3::new(-0.85, 2.29, -0.05),
        Vec3::new(0.85, 2.55, 0.14),
        0.02,
    ));
    shape
}

fn cornice(half: f32, height: f32) -> Shape {
    let low = Vec3::new(-half - 0.03, height - 0.35, -8.0);
    let mut shape = bevelled(low, Vec3::new(half + 0.03, height - 0.1, 0.18), 0.04);
    let low = Vec3::new(-half - 0.05, height - 0.12, -8.2);
    shape.append(&bevelled(
        low,
        Vec3::new(half + 0.05, height + 0.1, 0.34),
        0.03,
    ));
    shape
}

/// Height of a string at `t` from 0 to 1 across the street.
fn string_point(string: i32, t: f32) -> Vec3 {
    let z = -STRING_SPACING * string as f32 - 1.0;
    let sag = SAG * (0.8 + 0.4 * chance(string, 0, 5));
    // A parabola is close to a catenary this flat.
    let drop = sag * (1.0 - (2.0 * t - 1.0).powi(2));
    Vec3::new(
        (2.0 * t - 1.0) * (HALF_WIDTH + 0.6),
        STRING_HEIGHT - drop,
        z,
    )
}

fn strings(a: &mut Assembly) {
    let black = a.paint("cable", [0.03, 0.03, 0.03]);
    let mut cables = Shape::default();
    for string in 0..STRINGS {
        for piece in 0..12 {
            let [from, to] = [piece, piece + 1].map(|i| string_point(string, i as f32 / 12.0));
            cables.append(&cylinder(from, to, 0.012, 5));
        }
        for lamp in 0..LAMPS {
            // Lamps hang below the cable, and stay clear of the houses.
            let t = 0.07 + 0.86 * lamp as f32 / (LAMPS - 1) as f32;
            let at = string_point(string, t) - Vec3::Y * 0.1;
            let node = a.place("lamp", &[], at.as_dvec3().to_array(), 0.0);
            let intensity = hue(chance(lamp, string, 21)) * (0.1 + 0.4 * chance(lamp, string, 22));
            a.scene.lights.push(Light {
                node,
                kind: LightKind::Point,
                intensity,
            });
        }
    }
    a.draw("cables", black, &cables);
}

/// Two in three lamps are warm white, the others red, green, blue or violet.
fn hue(draw: f32) -> Vec3 {
    match draw {
        d if d < 0.66 => Vec3::new(1.0, 0.72, 0.42),
        d if d < 0.76 => Vec3::new(1.0, 0.22, 0.12),
        d if d < 0.85 => Vec3::new(0.25, 1.0, 0.35),
        d if d < 0.93 => Vec3::new(0.25, 0.45, 1.0),
        _ => Vec3::new(0.8, 0.3, 1.0),
    }
}
