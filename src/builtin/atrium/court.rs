//! The floor of the court and the fountain in its middle.
use super::palette::Palette;
use super::{BACK_WALL, GROUND, HALF, SIDES};
use crate::builtin::assemble::Assembly;
use crate::builtin::shapes::{Shape, arc, bevelled, cuboid, lathe};
use glam::Vec3;

pub(super) fn court(a: &mut Assembly, palette: &Palette) {
    let [x, z] = HALF.map(|half| half - 0.3);
    a.draw(
        "court",
        palette.pavement,
        &cuboid(Vec3::new(-x, -0.5, -z), Vec3::new(x, 0.0, z)),
    );
    fountain(a, palette);
    benches(a, palette);
}

fn fountain(a: &mut Assembly, palette: &Palette) {
    let mut stone = Shape::default();
    // Two steps and the basin, octagonal; parts are sunk into each other by a centimetre.
    stone.append(&lathe(&step(2.45, -0.05, 0.15), 8, true));
    stone.append(&lathe(&step(2.10, 0.14, 0.30), 8, true));
    let basin = [
        [1.42, 0.29],
        [1.74, 0.29],
        [1.74, 0.38],
        [1.66, 0.44],
        [1.62, 0.72],
        [1.66, 0.78],
        [1.72, 0.82],
        [1.72, 0.88],
        [1.69, 0.90],
        [1.45, 0.90],
        [1.42, 0.87],
    ];
    stone.append(&lathe(&basin, 8, true));
    let mut pillar = vec![[0.0, 0.25], [0.34, 0.25], [0.34, 0.55], [0.28, 0.60]];
    pillar.extend([
        [0.16, 0.72],
        [0.13, 0.80],
        [0.16, 0.86],
        [0.24, 0.98],
        [0.27, 1.10],
        [0.24, 1.24],
    ]);
    pillar.extend([
        [0.15, 1.40],
        [0.11, 1.52],
        [0.15, 1.56],
        [0.15, 1.60],
        [0.0, 1.60],
    ]);
    stone.append(&lathe(&pillar, 24, false));
    // The bowl has an outside, a rim and an inside.
    let bowl = [
        [0.0, 1.59],
        [0.16, 1.59],
        [0.40, 1.64],
        [0.62, 1.73],
        [0.76, 1.83],
        [0.82, 1.85],
        [0.82, 1.89],
        [0.76, 1.90],
        [0.71, 1.88],
        [0.58, 1.79],
        [0.38, 1.71],
        [0.0, 1.68],
    ];
    stone.append(&lathe(&bowl, 32, false));
    let mut finial = vec![
        [0.0, 1.66],
        [0.10, 1.66],
        [0.07, 1.80],
        [0.06, 2.0],
        [0.10, 2.06],
        [0.06, 2.10],
    ];
    finial.extend(arc([0.0, 2.22], 0.11, -55.0, 70.0, 6));
    finial.push([0.0, 2.36]);
    stone.append(&lathe(&finial, 20, false));
    a.draw("fountain", palette.stone, &stone);

    let mut water = lathe(
        &[[0.0, 0.28], [1.5, 0.28], [1.5, 0.76], [0.0, 0.76]],
        8,
        true,
    );
    water.append(&lathe(
        &[[0.0, 1.70], [0.65, 1.80], [0.69, 1.855], [0.0, 1.855]],
        32,
        false,
    ));
    a.draw("water", palette.water, &water);
}

/// An octagonal step with a chamfered edge.
fn step(radius: f32, low: f32, high: f32) -> [[f32; 2]; 5] {
    [
        [0.0, low],
        [radius, low],
        [radius, high - 0.03],
        [radius - 0.03, high],
        [0.0, high],
    ]
}

/// Stone benches along the gallery's back wall, where there is no door.
fn benches(a: &mut Assembly, palette: &Palette) {
    let y = GROUND.floor;
    let mut bench = bevelled(
        Vec3::new(-0.9, y + 0.40, -0.5),
        Vec3::new(0.9, y + 0.48, -0.04),
        0.015,
    );
    for x in [-0.65, 0.65] {
        bench.append(&bevelled(
            Vec3::new(x - 0.07, y - 0.01, -0.44),
            Vec3::new(x + 0.07, y + 0.41, -0.07),
            0.01,
        ));
    }
    let bench = a.mesh("bench", palette.stone, &bench);
    for side in &SIDES {
        for along in side.bays().skip(1).step_by(2) {
            a.place("bench", &[bench], side.at(along, BACK_WALL, 0.0), side.turn);
        }
    }
}
