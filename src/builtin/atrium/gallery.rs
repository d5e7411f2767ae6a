//! The galleries behind the arcades: floors, vaults, ceilings, the wall with its doors.
use super::column::ABACUS;
use super::palette::Palette;
use super::{BACK_WALL, BAY, GROUND, HALF, SIDES, UPPER};
use crate::builtin::assemble::Assembly;
use crate::builtin::shapes::{Shape, arc, bevelled, extrude, flat_uv, ring};
use glam::{Affine3A, Quat, Vec2, Vec3};
use std::f32::consts::FRAC_PI_2;

/// Radius of the vaults. It is greater than that of the arches around them, which so stand out as ribs.
const VAULT: f32 = 1.5;

/// Pieces of a vault's half circle; even, so that the groins run along edges.
const PIECES: usize = 12;

pub(super) fn galleries(a: &mut Assembly, palette: &Palette) {
    let plate = |from: f32, to: f32, low: f32, high: f32| {
        [[to, low], [from, low], [from, high], [to, high]]
    };
    let beyond = BACK_WALL - 0.15;
    // A step with a rounded nosing leads up from the court.
    let mut step = vec![[beyond, -0.4], [0.47, -0.4], [0.47, 0.1], [0.49, 0.11]];
    step.extend(arc([0.49, 0.135], 0.025, -60.0, 90.0, 4));
    step.push([0.30, 0.16]);
    step.push([0.30, 0.14]);
    step.push([beyond, 0.14]);
    a.draw("step", palette.stone, &ring(HALF, &step));
    a.draw(
        "gallery floor",
        palette.brick_floor,
        &ring(
            HALF,
            &plate(0.301, beyond + 0.01, 0.0, GROUND.floor - 0.001),
        ),
    );
    a.draw(
        "upper floor",
        palette.brick_floor,
        &ring(HALF, &plate(0.05, beyond, 5.24, UPPER.floor)),
    );
    a.draw(
        "upper ceiling",
        palette.wood,
        &ring(HALF, &plate(0.02, beyond, 10.55, 10.72)),
    );
    a.draw(
        "back wall",
        palette.whitewash,
        &ring(HALF, &plate(BACK_WALL, BACK_WALL - 0.5, -0.45, 12.22)),
    );
    for (name, y) in [("skirting", GROUND.floor), ("upper skirting", UPPER.floor)] {
        let (foot, face) = (y - 0.02, BACK_WALL + 0.035);
        let profile = [
            [BACK_WALL - 0.02, foot],
            [face, foot],
            [face, y + 0.22],
            [face - 0.015, y + 0.25],
            [BACK_WALL - 0.02, y + 0.26],
        ];
        a.draw(name, palette.stone, &ring(HALF, &profile));
    }
    vaults(a, palette);
    beams(a, palette);
    doors(a, palette);
}

fn vaults(a: &mut Assembly, palette: &Palette) {
    let vault = a.mesh("vault", palette.whitewash, &vault());
    let rib = a.mesh("rib", palette.whitewash, &rib());
    let corbel = a.mesh("corbel", palette.stone, &corbel());
    for side in &SIDES {
        let corner = side.bays as f32 * BAY / 2.0 + BAY / 2.0;
        // Corner bays belong to the long sides.
        let corners = [-corner, corner].into_iter().filter(|_| side.is_long);
        for along in side.bays().chain(corners) {
            a.place(
                "vault",
                &[vault],
                side.at(along, -BAY / 2.0, 0.0),
                side.turn,
            );
        }
        let all = (0..=side.bays).map(|i| (i as f32 - side.bays as f32 / 2.0) * BAY);
        // Two meet in a corner; so that no two faces coincide, one is lower.
        let lower = if side.is_long { 0.0 } else { -0.003 };
        for along in all {
            a.place("rib", &[rib, corbel], side.at(along, 0.0, lower), side.turn);
        }
    }
}

/// A groin vault over a square bay, about the bay's middle: two half cylinders that cross, closed above.
fn vault() -> Shape {
    let node = |i: usize| {
        // Mirrored to the bit, so that the four webs meet.
        let angle = FRAC_PI_2 * i.min(PIECES - i) as f32 / (PIECES / 2) as f32;
        let (sin, cos) = if 2 * i == PIECES {
            (1.0, 0.0)
        } else {
            angle.sin_cos()
        };
        Vec2::new(if 2 * i < PIECES { -cos } else { cos }, sin) * VAULT
    };
    let (low, high) = (GROUND.spring, 5.31);
    let mut web = Shape::default();
    // One web: the part of the half cylinder along z (height depends on x) with z beyond |x|.
    for i in 0..PIECES {
        let [near, far] = [node(i), node(i + 1)];
        let side = |n: Vec2, z: f32| {
            (
                Vec3::new(n.x, low + n.y, z),
                Vec3::new(-n.x, -n.y, 0.0) / VAULT,
                flat_uv(Vec3::new(n.x, 0.0, z), Vec3::Y),
            )
        };
        // Rows between the groin, where z = |x|, and the wall, where z = VAULT, at the nodes of the grid.
        for k in 0..PIECES / 2 {
            let [z0, z1] = [PIECES / 2 + k, PIECES / 2 + k + 1].map(|k| node(k).x);
            let inside = |n: Vec2, z: f32| n.x.abs() <= z + 1e-6;
            let corners: Vec<_> = [(near, z0), (far, z0), (far, z1), (near, z1)]
                .into_iter()
                .filter(|&(n, z)| inside(n, z))
                .map(|(n, z)| side(n, z))
                .collect();
            if corners.len() >= 3 {
                let v: Vec<u32> = corners
                    .iter()
                    .map(|&(p, n, uv)| web.vertex(p, n, uv))
                    .collect();
                (2..v.len()).for_each(|c| web.triangle([v[0], v[c - 1], v[c]]));
            }
        }
        // The side above the wall's arch, and the top, which is a triangle of a fan.
        let wall = |n: Vec2, y: f32| Vec3::new(n.x, y, VAULT);
        web.polygon(&[
            wall(near, low + near.y),
            wall(far, low + far.y),
            wall(far, high),
            wall(near, high),
        ]);
        web.polygon(&[wall(near, high), wall(far, high), Vec3::Y * high]);
    }
    let mut shape = Shape::default();
    for turn in 0..4 {
        let mut quarter = web.clone();
        // Quarter turns in whole numbers keep the seams exact.
        let rotate = |v: &mut Vec3| {
            for _ in 0..turn {
                *v = Vec3::new(v.z, v.y, -v.x);
            }
        };
        quarter.positions.iter_mut().for_each(rotate);
        quarter.normals.iter_mut().for_each(rotate);
        shape.append(&quarter);
    }
    shape
}

/// The arch across the gallery from a column to the wall; in the space of a side, so the wall is towards +z.
fn rib() -> Shape {
    let (from, to) = (0.1, -BACK_WALL + 0.1);
    let (middle, radius) = (BAY / 2.0, 1.38);
    let foot = GROUND.spring - 0.002;
    let mut outline = vec![[from, foot]];
    outline.extend(arc([middle, foot], radius, 180.0, 0.0, 24));
    outline.extend([[to, foot], [to, 5.3], [from, 5.3]]);
    let turn = Affine3A::from_quat(Quat::from_rotation_y(-FRAC_PI_2));
    extrude(&outline, -0.2, 0.2).transformed(turn)
}

/// The bracket on the wall that carries a rib.
fn corbel() -> Shape {
    let (wall, top) = (-BACK_WALL + 0.05, GROUND.spring);
    let half = ABACUS * GROUND.column * 0.85;
    let mut shape = bevelled(
        Vec3::new(-half, top - 0.09, wall - 0.30),
        Vec3::new(half, top + 0.008, wall),
        0.012,
    );
    // (out of the wall, y): a quarter round under the slab that runs out in a point.
    let mut profile = vec![[-0.05, top - 0.62]];
    profile.extend([[0.03, top - 0.60], [0.05, top - 0.52]]);
    profile.extend(arc([0.05, top - 0.26], 0.16, -80.0, 90.0, 6));
    profile.extend([[0.21, top - 0.08], [-0.05, top - 0.08]]);
    let turn = Affine3A::from_rotation_translation(
        Quat::from_rotation_y(FRAC_PI_2),
        Vec3::Z * (wall - 0.05),
    );
    shape.append(&extrude(&profile, -half * 0.8, half * 0.8).transformed(turn));
    shape
}

/// Timbers under the upper ceiling, from the arcade to the wall.
fn beams(a: &mut Assembly, palette: &Palette) {
    let (near, far) = (UPPER.half_wall - 0.05, -BACK_WALL + 0.1);
    let mut timber = bevelled(
        Vec3::new(-0.09, 10.33, near),
        Vec3::new(0.09, 10.57, far),
        0.012,
    );
    timber.append(&bevelled(
        Vec3::new(-0.11, 10.2, far - 0.45),
        Vec3::new(0.11, 10.34, far),
        0.03,
    ));
    let timber = a.mesh("timber", palette.dark_wood, &timber);
    for side in &SIDES {
        // Long sides carry the corners too; there the beams lie closer than a bay to the short wall.
        let half =
            side.bays as f32 * BAY / 2.0 + if side.is_long { -BACK_WALL - 0.3 } else { -0.3 };
        let count = (2.0 * half / 0.7).floor() as i32;
        for i in 0..=count {
            let along = -half + 2.0 * half * i as f32 / count as f32;
            a.place("timber", &[timber], side.at(along, 0.0, 0.0), side.turn);
        }
    }
}

/// Framed doors in every second bay of the back walls.
fn doors(a: &mut Assembly, palette: &Palette) {
    let (width, height) = (0.62, 2.35);
    // What stands out more is sunk deeper, so that no two faces coincide.
    let block = |x: [f32; 2], y: [f32; 2], out: f32, bevel: f32| {
        bevelled(
            Vec3::new(x[0], y[0], -out),
            Vec3::new(x[1], y[1], 0.04 + 0.1 * out),
            bevel,
        )
    };
    let mut frame = block(
        [-width - 0.2, -width + 0.01],
        [-0.01, height + 0.01],
        0.10,
        0.015,
    );
    frame.append(&block(
        [width - 0.01, width + 0.2],
        [-0.01, height + 0.01],
        0.10,
        0.015,
    ));
    frame.append(&block(
        [-width - 0.21, width + 0.21],
        [height, height + 0.22],
        0.105,
        0.015,
    ));
    frame.append(&block(
        [-width - 0.19, width + 0.19],
        [height + 0.2, height + 0.36],
        0.085,
        0.01,
    ));
    frame.append(&block(
        [-width - 0.32, width + 0.32],
        [height + 0.35, height + 0.45],
        0.2,
        0.03,
    ));
    let mut leaf = block([-width, width], [0.0, height], 0.04, 0.005);
    for x in [-0.31, 0.31] {
        for (low, high) in [(0.15, 1.0), (1.15, 2.2)] {
            leaf.append(&block([x - 0.22, x + 0.22], [low, high], 0.065, 0.02));
        }
    }
    let frame = a.mesh("door frame", palette.stone, &frame);
    let leaf = a.mesh("door", palette.dark_wood, &leaf);
    for side in &SIDES {
        for (i, along) in side.bays().enumerate() {
            for (y, odd) in [(GROUND.floor, 0), (UPPER.floor, 1)] {
                if i % 2 == odd {
                    a.place(
                        "door",
                        &[frame, leaf],
                        side.at(along, BACK_WALL, y),
                        side.turn,
                    );
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin::shapes::tests::{assert_closed, assert_normals};

    #[test]
    fn vault_and_ribs_are_closed() {
        for (name, shape) in [("vault", vault()), ("rib", rib())] {
            assert_closed(name, &shape);
            assert_normals(name, &shape.positions, &shape.normals, &shape.triangles);
        }
    }
}
