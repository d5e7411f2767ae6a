//! Cloth banners that hang from the balustrade into the court.
use super::arcade::pole;
use super::palette::Palette;
use super::{BAY, SIDES};
use crate::builtin::assemble::Assembly;
use crate::builtin::shapes::{cylinder, sheet, sphere};
use glam::Vec3;

/// Width and length of a banner, metres.
const WIDTH: f32 = 1.35;
const LENGTH: f32 = 2.9;

/// Thickness of the cloth, metres.
const THICKNESS: f32 = 0.012;

pub(super) fn banners(a: &mut Assembly, palette: &Palette) {
    let half = WIDTH / 2.0 + 0.12;
    let mut shape = cylinder(Vec3::X * -half, Vec3::X * half, 0.025, 12);
    for x in [-half, half] {
        shape.append(&sphere(0.05, 12).at(x, 0.0, 0.0));
    }
    for x in [-half + 0.06, half - 0.06] {
        // Arms back to the balustrade.
        shape.append(&cylinder(
            Vec3::new(x, 0.0, 0.0),
            Vec3::new(x, 0.42, 0.55),
            0.014,
            8,
        ));
    }
    let iron = a.mesh("pole", palette.iron, &shape);
    for (s, side) in SIDES.iter().enumerate() {
        let bays: Vec<f32> = if side.is_long {
            vec![-2.0, 0.0, 2.0]
        } else {
            vec![-1.0, 1.0]
        };
        for (i, bay) in bays.into_iter().enumerate() {
            let along = if side.is_long {
                bay * BAY - BAY / 2.0
            } else {
                bay * BAY / 2.0
            };
            let color = palette.cloths[(i + s) % palette.cloths.len()];
            let phase = (i * 3 + s * 5) as f32;
            let cloth = a.mesh(
                "banner",
                color,
                &sheet(18, 20, THICKNESS, |s, t| hang(s, t, phase)),
            );
            a.place("banner", &[iron, cloth], pole(side, along), side.turn);
        }
    }
}

/// The hanging cloth: folds that deepen downwards, and a swallow tail. It faces the court, -z.
fn hang(s: f32, t: f32, phase: f32) -> Vec3 {
    // Seen from the court, x runs to the left.
    let across = 0.5 - s;
    let fold = 0.075 * t.powf(0.7) * (across * 15.0 + phase + 0.8 * t).sin();
    let drift = 0.10 * t * t * (phase * 1.7).sin();
    let narrowing = 1.0 - 0.06 * t;
    let tail = 0.28 * t * t * (1.0 - (2.0 * across).abs());
    let x = across * WIDTH * narrowing + 0.02 * t * (phase + 3.0 * t).sin();
    Vec3::new(x, -LENGTH * t + tail, -0.012 + fold + drift)
}
