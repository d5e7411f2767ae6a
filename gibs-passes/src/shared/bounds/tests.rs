//! Tests of `shared/bounds.rs`.
use super::*;
use crate::shared::grid::{self, GridLayout};
use crate::shared::hash;

fn random_unit(i: u32, k: u32) -> f32 {
    hash::unit(hash::hash2(i, k)) * 2.0 - 1.0
}

/// Grids from a cube of a millimetre to one of a kilometre.
fn grids() -> impl Iterator<Item = GridShape> {
    [1e-3, 0.5, 1e3].into_iter().flat_map(|half| {
        [4, 17, 40, 64]
            .map(|side| GridLayout::new(side, 400.0).at(Vec3::new(0.1, -0.2, 0.3) * half, half))
    })
}

/// A point in the grid's cells or beyond its last one, and a surfel near it of up to the largest radius there.
fn pair(i: u32, grid: &GridShape) -> (Vec3, Vec3, f32) {
    let far = grid.half * 2f32.powf(8.0 + 12.0 * random_unit(i, 0));
    let direction = Vec3::new(random_unit(i, 1), random_unit(i, 2), random_unit(i, 3));
    let point = grid.centre + direction * far;
    let radius = grid::cell_side(point, grid) * 0.5 * random_unit(i, 4).abs();
    let away = Vec3::new(random_unit(i, 5), random_unit(i, 6), random_unit(i, 7));
    (point, point + away * (2.5 * radius), radius)
}

/// No surfel that reaches a point of a cell is refused there, wherever its own centre lies.
#[test]
fn what_reaches_is_never_refused() {
    let (mut reached, mut refused) = (0, 0);
    for grid in grids() {
        for i in 0..20_000 {
            let (point, surfel, radius) = pair(i, &grid);
            let steps = steps_in(grid::cell(point, &grid), &grid);
            let bounds = pack(surfel - grid.centre, radius, steps);
            let place = place(point - grid.centre, steps);
            for reach in [1, 2] {
                let near = (point - surfel).length() < reach as f32 * radius;
                let may = may_reach(bounds, place, reach);
                assert!(may || !near, "{point} {surfel} {radius} {reach}");
                reached += u32::from(near);
                refused += u32::from(!may);
            }
        }
    }
    assert!(reached > 50_000 && refused > 50_000, "{reached}, {refused}");
}

/// Of surfels somewhere in the cell, most that do not reach the point are refused.
#[test]
fn most_others_are_refused() {
    for grid in grids() {
        let (mut others, mut passed) = (0, 0);
        for i in 0..20_000 {
            let random = |k| random_unit(i, k);
            let point = grid.centre + Vec3::new(random(0), random(1), random(2)) * grid.half;
            let side = grid::cell_side(point, &grid);
            let surfel = point + Vec3::new(random(3), random(4), random(5)) * side;
            let radius = 0.15 * side;
            let steps = steps_in(grid::cell(point, &grid), &grid);
            if (point - surfel).length() > 1.3 * radius {
                others += 1;
                let bounds = pack(surfel - grid.centre, radius, steps);
                let at = place(point - grid.centre, steps);
                passed += u32::from(may_reach(bounds, at, 1));
            }
        }
        assert!(passed * 200 < others, "{passed} of {others}");
    }
}

/// Surfels that are as large as their code cannot tell, or too far out for steps, pass everywhere.
#[test]
fn what_cannot_be_told_always_passes() {
    for (from_centre, radius) in [
        (Vec3::ZERO, 126.0),
        (Vec3::ZERO, f32::INFINITY),
        (Vec3::X * 300_000.0, 1.0),
    ] {
        let bounds = pack(from_centre, radius, 1.0);
        assert_eq!(bounds >> RADIUS_AT, FAR);
        assert!(may_reach(bounds, place(Vec3::splat(128.0), 1.0), 1));
    }
    let large = pack(Vec3::ZERO, 123.9, 1.0);
    assert!(large >> RADIUS_AT < FAR);
    assert!(!may_reach(large, place(Vec3::splat(128.0), 1.0), 1));
    // Twice its radius is more than can be told.
    assert!(may_reach(large, place(Vec3::splat(128.0), 1.0), 2));
}

/// Every pair of bytes along an axis: the true difference where it is short, at most as much where it is not.
#[test]
fn differences_of_bytes_are_never_too_long() {
    for surfel in 0..256 {
        for point in 0..256 {
            for radius in [1, 60, 124, FAR] {
                for axis in 0..3 {
                    let bounds = surfel << (axis * BITS) | radius << RADIUS_AT;
                    let apart = (surfel as i32 - point as i32).rem_euclid(256);
                    let shortest = apart.min(256 - apart) as u32;
                    let expected = radius + MARGIN >= FAR || shortest <= radius + MARGIN;
                    let may = may_reach(bounds, point << (axis * BITS), 1);
                    assert_eq!(may, expected, "{surfel} {point} {radius} {axis}");
                }
            }
        }
    }
}

/// Rounding down, negative numbers and large ones included.
#[test]
fn steps_are_floors_modulo_256() {
    for x in [
        -1e6f32, -257.0, -256.5, -0.5, -0.0, 0.0, 0.5, 255.9, 256.0, 1e6,
    ] {
        let floor = (f64::from(x).floor() as i64).rem_euclid(256) as u32;
        assert_eq!(place(Vec3::new(x, 0.0, 0.0), 1.0), floor, "{x}");
    }
}
