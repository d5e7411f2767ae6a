//! Halls that partitions divide. Floor and ceiling are one plane beneath them.
use super::parts::{FAR, HEIGHT, Paints, SUNK, THIN, ceiling_panel, look, outside, room, upright};
use crate::builtin::assemble::Assembly;
use crate::builtin::shapes::shell;
use crate::view::View;
use gibs_passes::scene::Scene;
use glam::Vec3;

/// Half the depth of the hall with pillars, metres.
pub(super) const DEPTH: f32 = 2.5;

/// Half the width of a pillar, metres.
pub(super) const PILLAR: f32 = 0.15;

/// Where the pillars stand, metres.
pub(super) const PILLARS: [f32; 3] = [-1.4, 0.0, 1.4];

/// An empty hall of this depth, lit from above its left part.
pub(super) fn hall(name: &str, depth: f32, light: [f32; 2]) -> (Assembly, Paints) {
    let mut a = Assembly::new(name);
    let paints = Paints::new(&mut a);
    let low = Vec3::new(-FAR, 0.0, -depth);
    let high = Vec3::new(FAR, HEIGHT, depth);
    outside(&mut a, &paints, low, high);
    room(&mut a, &paints, "hall", paints.orange, low, high);
    ceiling_panel(&mut a, &paints, light[0], light[1]);
    (a, paints)
}

/// Draws the pillars, and on both sides thin columns and fins.
pub(super) fn furnish(a: &mut Assembly, paints: &Paints) {
    for z in PILLARS {
        let shape = upright([-PILLAR, z - PILLAR], [PILLAR, z + PILLAR]);
        a.draw("pillar", paints.white, &shape);
    }
    for side in [-1.0_f32, 1.0] {
        for (x, z) in [(1.2, -1.6), (1.8, 0.9)] {
            let shape = upright([side * x - 0.02, z - 0.02], [side * x + 0.02, z + 0.02]);
            a.draw("column", paints.white, &shape);
        }
        // Free-standing, and one that stands on the partition's line, between two pillars.
        for (near, far, z) in [(1.0, 1.9, -0.3), (0.2, 0.8, 0.7)] {
            let (one, other) = (side * near, side * far);
            let shape = upright(
                [one.min(other), z - THIN / 2.0],
                [one.max(other), z + THIN / 2.0],
            );
            a.draw("fin", paints.blue, &shape);
        }
    }
}

/// Views of the hall with pillars from its left and from its right part.
pub(super) fn hall_views() -> [View; 2] {
    [-1.0, 1.0].map(|side| look([side * 3.9, 1.6, 1.9], [side * 0.2, 1.0, -0.6], 70.0))
}

/// A hall that a row of pillars, with partitions of 1 mm between them, divides into a lit and a dark part.
pub(super) fn pillars() -> (Scene, View, View) {
    let (mut a, paints) = hall("sealed-pillars", DEPTH, [-FAR / 2.0, 0.0]);
    furnish(&mut a, &paints);
    let inside = PILLAR - SUNK;
    let ends = [
        (-DEPTH - SUNK, PILLARS[0] - inside),
        (PILLARS[0] + inside, PILLARS[1] - inside),
        (PILLARS[1] + inside, PILLARS[2] - inside),
        (PILLARS[2] + inside, DEPTH + SUNK),
    ];
    for (from, to) in ends {
        let shape = upright([-THIN / 2.0, from], [THIN / 2.0, to]);
        a.draw("partition", paints.white, &shape);
    }
    let [bright, dark] = hall_views();
    (a.scene, bright, dark)
}

/// A square hall of which two partitions that meet in an L cut a quarter off; the rest is lit.
pub(super) fn bend() -> (Scene, View, View) {
    let (mut a, paints) = hall("sealed-bend", FAR, [-FAR / 2.0, -FAR / 2.0]);
    let (half, end) = (THIN / 2.0, FAR + SUNK);
    // Each goes on into the other, a little less far than its face, so that no two faces coincide.
    let within = 0.2 * half;
    for (low, high) in [
        ([-half, -within], [half, end]),
        ([-within, -half], [end, half]),
    ] {
        a.draw("partition", paints.white, &upright(low, high));
    }
    (
        a.scene,
        look([-4.0, 1.7, -3.2], [0.3, 0.9, 0.4], 70.0),
        look([4.2, 1.7, 3.6], [0.2, 0.9, 0.2], 70.0),
    )
}

/// A lit hall and in it a box of 1.6 x 1.8 x 1.6 m with walls of 1 mm, which has no floor of its own.
pub(super) fn closet() -> (Scene, View, View) {
    let (mut a, paints) = hall("sealed-box", DEPTH, [-1.0, 0.6]);
    let (low, high) = (Vec3::new(-0.8, -SUNK, -1.6), Vec3::new(0.8, 1.8, 0.0));
    let wall = Vec3::splat(THIN);
    let (outer, inner) = shell([low + wall, high - wall], [low, high], None);
    let mut shape = outer;
    for face in &inner {
        shape.append(face);
    }
    a.draw("box", paints.blue, &shape);
    (
        a.scene,
        look([-3.6, 1.7, 1.8], [0.1, 0.7, -0.8], 70.0),
        look([0.65, 1.5, -0.15], [-0.5, 0.3, -1.3], 90.0),
    )
}
