//! Columns, arches and what lies on them: everything on the court's faces.
use super::column::{baluster, column};
use super::palette::Palette;
use super::{BAY, GROUND, HALF, SIDES, Side, Storey, UPPER};
use crate::builtin::assemble::Assembly;
use crate::builtin::shapes::{Frame, Path, Shape, arc, bevelled, extrude, lathe, ring, sweep};
use glam::{Affine3A, Quat, Vec3};
use std::f32::consts::{FRAC_PI_2, PI};

/// Pieces of an arch's half circle.
const PIECES: usize = 20;

/// The top of a pedestal and of the balustrade, and half a pedestal's side, metres.
const RAIL: f32 = 6.55;
const PEDESTAL: f32 = 0.225;

pub(super) fn arcades(a: &mut Assembly, palette: &Palette) {
    for (name, storey) in [("ground floor", &GROUND), ("upper floor", &UPPER)] {
        let shape = column(storey.spring - storey.foot, storey.column);
        let column = a.mesh("column", palette.stone, &shape);
        for is_long in [true, false] {
            // The short walls end within the long ones; a little lower, so that no two faces coincide.
            let (overhang, lower) = if is_long {
                (storey.half_wall + 0.02, 0.0)
            } else {
                (-0.11, 0.003)
            };
            let bays = SIDES[usize::from(!is_long)].bays;
            let wall = a.mesh(
                "wall",
                palette.plaster,
                &wall(storey, bays, overhang, lower),
            );
            let trim = a.mesh(
                "archivolts",
                palette.stone,
                &archivolts(storey, bays, lower),
            );
            for side in SIDES.iter().filter(|side| side.is_long == is_long) {
                a.place(name, &[wall, trim], side.at(0.0, 0.0, 0.0), side.turn);
            }
        }
        for side in &SIDES {
            for along in side.columns() {
                a.place(
                    "column",
                    &[column],
                    side.at(along, 0.0, storey.foot),
                    side.turn,
                );
            }
        }
    }
    a.draw("string course", palette.stone, &ring(HALF, &STRING_COURSE));
    a.draw("cornice", palette.stone, &ring(HALF, &CORNICE));
    balustrade(a, palette);
    roundels(a, palette);
}

/// The moulding between the storeys: (inwards, y).
const STRING_COURSE: [[f32; 2]; 12] = [
    [0.10, 5.20],
    [0.26, 5.20],
    [0.26, 5.28],
    [0.285, 5.28],
    [0.285, 5.37],
    [0.31, 5.39],
    [0.36, 5.425],
    [0.39, 5.475],
    [0.44, 5.475],
    [0.44, 5.545],
    [0.47, 5.575],
    [0.10, 5.635],
];

/// The moulding under the eaves.
const CORNICE: [[f32; 2]; 12] = [
    [0.10, 10.56],
    [0.23, 10.56],
    [0.23, 10.68],
    [0.25, 10.68],
    [0.25, 10.78],
    [0.29, 10.80],
    [0.35, 10.85],
    [0.39, 10.92],
    [0.46, 10.92],
    [0.46, 10.99],
    [0.48, 11.01],
    [0.10, 11.06],
];

/// The wall above the columns of one side, with its arches; in the space of [`Side`], the axis along z = 0.
fn wall(storey: &Storey, bays: i32, overhang: f32, lower: f32) -> Shape {
    let end = bays as f32 * BAY / 2.0 + overhang;
    let foot = storey.spring - lower;
    let mut outline = vec![[-end, foot]];
    for bay in 0..bays {
        let middle = (bay as f32 + 0.5 - bays as f32 / 2.0) * BAY;
        outline.extend(arc([middle, foot], storey.radius, 180.0, 0.0, PIECES));
    }
    outline.extend([
        [end, foot],
        [end, storey.top - lower],
        [-end, storey.top - lower],
    ]);
    extrude(&outline, -storey.half_wall, storey.half_wall)
}

/// The mouldings around the arches of one side on the court's face (-z), and their keystones.
fn archivolts(storey: &Storey, bays: i32, lower: f32) -> Shape {
    let (inner, outer, face) = (
        storey.radius - 0.012,
        storey.radius + 0.22,
        storey.half_wall,
    );
    // (radius, out of the wall)
    let profile = [
        [inner, face - 0.03],
        [outer, face - 0.03],
        [outer, face + 0.055],
        [outer - 0.025, face + 0.055],
        [outer - 0.045, face + 0.03],
        [outer - 0.12, face + 0.03],
        [outer - 0.125, face + 0.018],
        [inner, face + 0.018],
    ];
    let frames: Vec<Frame> = (0..=PIECES)
        .map(|i| {
            let angle = PI * i as f32 / PIECES as f32;
            let u = Vec3::new(angle.cos(), angle.sin(), 0.0);
            // A little lower than the arch, so that the feet do not coincide.
            Frame {
                origin: Vec3::Y * (storey.spring - lower - 0.004),
                u,
                v: Vec3::NEG_Z,
            }
        })
        .collect();
    let mut arch = sweep(&profile, &frames, Path::Smooth);
    let crown = storey.spring + storey.radius;
    let wedge = [
        [-0.09, crown - 0.03],
        [0.09, crown - 0.03],
        [0.13, crown + 0.26],
        [-0.13, crown + 0.26],
    ];
    arch.append(&extrude(&wedge, -face - 0.085, -face + 0.05));
    let mut shape = Shape::default();
    for bay in 0..bays {
        let middle = (bay as f32 + 0.5 - bays as f32 / 2.0) * BAY;
        shape.append(&arch.at(middle, 0.0, 0.0));
    }
    shape
}

fn balustrade(a: &mut Assembly, palette: &Palette) {
    let square = |half: f32, from: f32, to: f32, bevel: f32| {
        bevelled(
            Vec3::new(-half, from, -half),
            Vec3::new(half, to, half),
            bevel,
        )
    };
    let mut pedestal = square(PEDESTAL, 5.5, RAIL - 0.05, 0.01);
    pedestal.append(&square(PEDESTAL + 0.035, 5.52, 5.76, 0.03));
    pedestal.append(&square(PEDESTAL + 0.04, RAIL - 0.11, RAIL + 0.015, 0.025));
    let pedestal = a.mesh("pedestal", palette.stone, &pedestal);

    let half = BAY / 2.0 - PEDESTAL + 0.02;
    let beam =
        |y: [f32; 2], z: f32| bevelled(Vec3::new(-half, y[0], -z), Vec3::new(half, y[1], z), 0.02);
    let mut bay = beam([5.53, 5.73], 0.13);
    bay.append(&beam([RAIL - 0.13, RAIL], 0.14));
    let one = baluster(RAIL - 0.11 - 5.71);
    for i in -3..=3 {
        bay.append(&one.at(i as f32 * 0.37, 5.71, 0.0));
    }
    let bay = a.mesh("balusters", palette.stone, &bay);
    for side in &SIDES {
        side.columns().for_each(|x| {
            a.place("pedestal", &[pedestal], side.at(x, 0.0, 0.0), side.turn);
        });
        side.bays().for_each(|x| {
            a.place("balustrade", &[bay], side.at(x, 0.0, 0.0), side.turn);
        });
    }
}

/// Glazed roundels between the arches of the ground floor: a stone rim, a blue dish and a white boss.
fn roundels(a: &mut Assembly, palette: &Palette) {
    // Made about y, then turned to face the court (-z).
    let upright = Affine3A::from_quat(Quat::from_rotation_x(-FRAC_PI_2));
    let rim = [
        [0.27, -0.03],
        [0.33, -0.03],
        [0.335, 0.03],
        [0.31, 0.05],
        [0.285, 0.045],
        [0.27, 0.025],
    ];
    let dish = [
        [0.0, -0.025],
        [0.28, -0.025],
        [0.28, 0.012],
        [0.2, 0.02],
        [0.0, 0.03],
    ];
    let boss = [
        [0.0, 0.0],
        [0.13, 0.0],
        [0.13, 0.03],
        [0.1, 0.045],
        [0.05, 0.07],
        [0.0, 0.075],
    ];
    let rim = a.mesh(
        "roundel",
        palette.stone,
        &lathe(&rim, 24, false).transformed(upright),
    );
    let dish = a.mesh(
        "glaze",
        palette.glaze,
        &lathe(&dish, 24, false).transformed(upright),
    );
    let boss = a.mesh(
        "boss",
        palette.whitewash,
        &lathe(&boss, 16, false).transformed(upright),
    );
    for side in &SIDES {
        let inner = |x: &f32| x.abs() < side.bays as f32 * BAY / 2.0 - 0.1;
        for along in side.columns().filter(inner) {
            let at = side.at(along, GROUND.half_wall, GROUND.spring + 1.18);
            a.place("roundel", &[rim, dish, boss], at, side.turn);
        }
    }
}

/// Where a banner's pole is held: out of the balustrade of one bay.
pub(super) fn pole(side: &Side, along: f32) -> [f64; 3] {
    side.at(along, 0.62, 5.98)
}
