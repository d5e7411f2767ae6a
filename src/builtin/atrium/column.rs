//! Columns: plinth, Attic base, shaft with entasis, Tuscan capital.
use crate::builtin::shapes::{Shape, arc, bevelled, lathe};
use glam::Vec3;

/// Segments around a column.
const SEGMENTS: usize = 18;

/// Half the side of the abacus of a column of 1 m diameter.
pub(super) const ABACUS: f32 = 0.68;

/// How deep parts are sunk into each other, metres, so that no two faces coincide.
const SUNK: f32 = 0.01;

/// A column that stands on y = 0 and carries at y = `height`; its foot and its top reach [`SUNK`] beyond.
///
/// Proportions in diameters after Vignola's Tuscan order, with the Attic base (two tori about a hollow).
pub(super) fn column(height: f32, diameter: f32) -> Shape {
    // The parts are drawn for a diameter of 1.
    let top = height / diameter;
    let (plinth, abacus) = (0.70, ABACUS);
    let square = |half: f32, from: f32, to: f32| {
        bevelled(
            Vec3::new(-half, from, -half),
            Vec3::new(half, to, half),
            0.025,
        )
    };
    let sunk = SUNK / diameter;
    let mut shape = square(plinth, -sunk, 0.26);
    shape.append(&square(abacus, top - 0.2, top + sunk));

    let mut profile = vec![[0.0, 0.25]];
    profile.extend(arc([0.57, 0.37], 0.12, -90.0, 90.0, 4));
    profile.push([0.60, 0.49]);
    profile.push([0.60, 0.52]);
    // The hollow: a quarter ellipse is near enough to a scotia.
    profile.extend((1..4).map(|i| {
        let t = i as f32 / 4.0;
        [
            0.60 - 0.05 * (t * std::f32::consts::PI).sin() - 0.03 * t,
            0.52 + 0.1 * t,
        ]
    }));
    profile.push([0.57, 0.62]);
    profile.extend(arc([0.54, 0.69], 0.07, -90.0, 90.0, 4));
    profile.push([0.56, 0.76]);
    profile.push([0.56, 0.79]);
    // The shaft leaves its fillet in a cove, and narrows towards the top.
    profile.extend([[0.525, 0.82], [0.508, 0.86]]);
    let (shaft_foot, shaft_top) = (0.92, top - 0.62);
    profile.extend((0..=3).map(|i| {
        let t = i as f32 / 3.0;
        [
            0.5 - 0.075 * t.powf(1.8),
            shaft_foot + (shaft_top - shaft_foot) * t,
        ]
    }));
    let neck = 0.425;
    profile.push([neck + 0.035, shaft_top + 0.03]);
    profile.extend(arc([neck + 0.035, shaft_top + 0.07], 0.035, -90.0, 90.0, 3));
    profile.push([neck, shaft_top + 0.11]);
    profile.push([neck, top - 0.40]);
    profile.push([neck + 0.04, top - 0.40]);
    profile.push([neck + 0.04, top - 0.36]);
    profile.extend(arc([neck + 0.05, top - 0.19], 0.16, -75.0, 0.0, 3));
    profile.push([0.0, top - 0.19]);

    shape.append(&lathe(&profile, SEGMENTS, false));
    let scale = glam::Affine3A::from_scale(Vec3::splat(diameter));
    let mut shape = shape.transformed(scale);
    shape.uvs.iter_mut().for_each(|uv| *uv *= diameter);
    shape
}

/// A baluster from y = 0 to `height`.
pub(super) fn baluster(height: f32) -> Shape {
    let profile = [
        [0.0, 0.0],
        [0.062, 0.0],
        [0.062, 0.06],
        [0.04, 0.085],
        [0.075, 0.27],
        [0.068, 0.36],
        [0.042, 0.52],
        [0.032, 0.70],
        [0.05, 0.78],
        [0.055, 0.90],
        [0.055, 1.0],
        [0.0, 1.0],
    ];
    lathe(&profile.map(|[r, y]| [r, y * height]), 8, false)
}
