//! The roof over the galleries, which slopes towards the court.
use super::palette::Palette;
use super::{BACK_WALL, HALF, SIDES};
use crate::builtin::assemble::Assembly;
use crate::builtin::shapes::{bevelled, extrude, ring};
use glam::{Affine3A, Quat, Vec3};

/// Distance inwards of the eaves and of the outer edge, metres.
const EAVES: f32 = 0.95;
const EDGE: f32 = BACK_WALL - 0.9;

/// Height of the underside at the eaves, and the slope.
const EAVES_HEIGHT: f32 = 11.0;
const SLOPE: f32 = 0.31;

/// Thickness of the roof, upright.
const THICKNESS: f32 = 0.09;

/// Height of the underside at a distance inwards.
fn underside(inwards: f32) -> f32 {
    EAVES_HEIGHT + SLOPE * (EAVES - inwards)
}

pub(super) fn roof(a: &mut Assembly, palette: &Palette) {
    let layer = |eaves: f32, edge: f32, low: f32, high: f32| {
        let at = |inwards: f32, y: f32| [inwards, underside(inwards) + y];
        let profile = [
            at(edge, low),
            at(eaves, low),
            at(eaves, high),
            at(edge, high),
        ];
        ring(HALF, &profile)
    };
    let boards = layer(EAVES, EDGE, 0.0, THICKNESS - 0.02);
    a.draw("roof boards", palette.wood, &boards);
    let bed = layer(EAVES - 0.01, EDGE + 0.01, THICKNESS - 0.025, THICKNESS);
    a.draw("roof", palette.roof_tiles, &bed);
    tiles(a, palette);
    rafters(a, palette);
}

/// Rows of half round tiles down the slope.
fn tiles(a: &mut Assembly, palette: &Palette) {
    let radius = 0.085_f32;
    let spacing = 0.24;
    // A half octagon on a plate: tile and the flat channel beside it.
    let half = spacing / 2.0;
    let low = -0.02;
    let profile = [
        [-half, low],
        [half, low],
        [half, 0.015],
        [radius, 0.015],
        [radius * 0.92, radius * 0.55],
        [radius * 0.5, radius * 0.95],
        [-radius * 0.5, radius * 0.95],
        [-radius * 0.92, radius * 0.55],
        [-radius, 0.015],
        [-half, 0.015],
    ];
    let tilt = Affine3A::from_quat(Quat::from_rotation_x(-SLOPE.atan()));
    let stretch = (1.0 + SLOPE * SLOPE).sqrt();
    let length = (EAVES + 0.04 - EDGE) * stretch;
    let full = a.mesh(
        "tiles",
        palette.roof_tiles,
        &extrude(&profile, 0.0, length).transformed(tilt),
    );
    for side in &SIDES {
        let reach = if side.is_long { HALF[0] } else { HALF[1] } - EAVES;
        let rows = (2.0 * reach / spacing).floor() as i32;
        for i in 0..rows {
            let along = (i as f32 + 0.5 - rows as f32 / 2.0) * spacing;
            let inwards = EAVES + 0.04;
            let y = underside(inwards) + THICKNESS + 0.01;
            a.place("tiles", &[full], side.at(along, inwards, y), side.turn);
        }
    }
}

/// Rafter ends under the eaves.
fn rafters(a: &mut Assembly, palette: &Palette) {
    let tilt = Affine3A::from_quat(Quat::from_rotation_x(-SLOPE.atan()));
    let shape = bevelled(
        Vec3::new(-0.05, -0.13, 0.0),
        Vec3::new(0.05, 0.02, 1.0),
        0.012,
    )
    .transformed(tilt);
    let rafter = a.mesh("rafter", palette.dark_wood, &shape);
    for side in &SIDES {
        let reach = if side.is_long { HALF[0] } else { HALF[1] } - 0.45;
        let count = (2.0 * reach / 0.5).round() as i32;
        for i in 0..=count {
            let along = -reach + 2.0 * reach * i as f32 / count as f32;
            // The ends lie in the mitre of the corner; shorter ones there would not be seen.
            let inwards =
                (EAVES - 0.08).min(if side.is_long { HALF[0] } else { HALF[1] } - along.abs());
            a.place(
                "rafter",
                &[rafter],
                side.at(along, inwards, underside(inwards)),
                side.turn,
            );
        }
    }
}
