//! Tests of `shared/grid.rs`.
use super::*;
use crate::shared::hash;

fn random_unit(i: u32, k: u32) -> f32 {
    hash::unit(hash::hash2(i, k)) * 2.0 - 1.0
}

/// What a cell spans, from its index alone: its grid's part, the interval of each coordinate over the cube's half
/// size, or over the main coordinate in a half-axis, whose own interval comes last and is in half sizes.
fn bounds(cell: u32, grid: &GridShape) -> (u32, [[f64; 2]; 3]) {
    let n = grid.side;
    let lateral = |i: u32| [i, i + 1].map(|i| 2.0 * f64::from(i) / f64::from(n) - 1.0);
    if cell < n * n * n {
        return (0, [cell % n, cell / n % n, cell / n / n].map(lateral));
    }
    let rest = cell - n * n * n;
    let slice = rest / n / n % grid.slices;
    let near = f64::from(grid.growth).powi(slice as i32);
    let far = match slice + 1 == grid.slices {
        true => f64::INFINITY,
        false => near * f64::from(grid.growth),
    };
    let part = 1 + rest / n / n / grid.slices;
    (
        part,
        [lateral(rest % n), lateral(rest / n % n), [near, far]],
    )
}

/// Whether a point lies in a cell that is wider by a share of its coordinates.
fn contains(cell: u32, p: Vec3, grid: &GridShape, wider: f64) -> bool {
    let d = (p - grid.centre).as_dvec3() / f64::from(grid.half);
    let (part, intervals) = bounds(cell, grid);
    let within = |x: f64, [low, high]: [f64; 2], scale: f64| {
        (low - wider * scale..=high + wider * scale).contains(&x)
    };
    if part == 0 {
        return (0..3).all(|i| within(d[i], intervals[i], 1.0));
    }
    let face = part - 1;
    let [along, u, v] = [[d.x, d.y, d.z], [d.y, d.x, d.z], [d.z, d.x, d.y]][face as usize / 2];
    let along = if face % 2 == 1 { -along } else { along };
    along > 0.0
        && within(u / along, intervals[0], 1.0)
        && within(v / along, intervals[1], 1.0)
        && within(along, intervals[2], along)
}

/// The grid of the default settings in scenes of a few centimetres to a hundred kilometres, whose cubes reach from 1 mm to 1 km.
fn grids() -> impl Iterator<Item = (GridLayout, GridShape)> {
    [1e-3, 0.5, 1e3].into_iter().flat_map(|half| {
        [4, 17, 40].map(|side| {
            let layout = GridLayout::new(side, 128.0);
            (layout, layout.at(Vec3::new(0.1, -0.2, 0.3) * half, half))
        })
    })
}

/// Every point from a millimetre to a million metres away maps to a cell that contains it.
#[test]
fn every_point_lies_in_the_cell_it_maps_to() {
    for (layout, grid) in grids() {
        for i in 0..50_000 {
            let distance = 10f32.powf(1.5 + 4.5 * random_unit(i, 3));
            let axis = |k| if i % 5 == k { 0.0 } else { random_unit(i, k) };
            let direction = Vec3::new(axis(0), axis(1), axis(2)).normalize_or(Vec3::X);
            let p = grid.centre + direction * distance;
            let c = cell(p, &grid);
            assert!(c < layout.cells());
            assert!(contains(c, p, &grid, 1e-5), "{p} is not in cell {c}");
        }
    }
}

/// And back: what a cell spans maps to it, so that no two cells share more than a face.
#[test]
fn what_a_cell_spans_maps_to_it() {
    for (layout, grid) in grids() {
        for c in 0..layout.cells() {
            let (part, intervals) = bounds(c, &grid);
            let at = |k: u32, [low, high]: [f64; 2]| {
                let share = 0.5 + 0.499 * f64::from(random_unit(c, k));
                // The last slice has no end: a million metres are far enough.
                let high = high.min(1e6 / f64::from(grid.half));
                low + (high - low) * share
            };
            let [u, v, w] = [0, 1, 2].map(|k| at(k, intervals[k as usize]));
            let d = if part == 0 {
                [u, v, w]
            } else {
                let face = part - 1;
                let along = if face % 2 == 1 { -w } else { w };
                let [u, v] = [u * w, v * w];
                [[along, u, v], [u, along, v], [u, v, along]][face as usize / 2]
            };
            let p = grid.centre + Vec3::from(d.map(|x| (x * f64::from(grid.half)) as f32));
            assert_eq!(cell(p, &grid), c, "{p}, {} slices", layout.slices);
        }
    }
}

/// A point to which a surfel gives light always finds the surfel in its own cell.
#[test]
fn a_point_in_a_surfel_lies_in_an_overlapped_cell() {
    let layout = GridLayout::new(32, 200.0);
    let grid = layout.at(Vec3::ZERO, 0.5);
    let direction = |i, k| {
        Vec3::new(
            random_unit(i, k),
            random_unit(i, k + 1),
            random_unit(i, k + 2),
        )
        .normalize()
    };
    for i in 0..100_000 {
        let scale = 0.5 * 10f32.powf(1.2 + 1.2 * random_unit(i, 3));
        let p = Vec3::new(random_unit(i, 0), random_unit(i, 1), random_unit(i, 2)) * scale;
        let pose = SurfelPose {
            position: p,
            radius: cell_side(p, &grid) * RADIUS_SHARE,
            normal: direction(i, 8),
            mark: plane::pack(match i % 4 {
                0 => Vec3::NEG_Y,
                _ => direction(i, 7),
            }),
        };
        let mut cells = Vec::new();
        overlapped(&pose, &grid, |cell| cells.push(cell));
        let distinct: std::collections::BTreeSet<u32> = cells.iter().copied().collect();
        assert_eq!(
            distinct.len(),
            cells.len(),
            "a cell is listed twice around {p}"
        );
        assert!(cells.iter().all(|&c| c < layout.cells()));
        // On the ellipsoid's surface: of a sphere, squashed across the plane.
        let (on_sphere, across) = (direction(i, 4), plane::unpack(pose.mark).normalize());
        let along = on_sphere.dot(across) * (1.0 - 1.0 / lookup::SQUASH);
        let d = (on_sphere - across * along) * pose.radius;
        assert!(lookup::falloff(d * 0.999, &pose) > 0.0);
        assert!(lookup::falloff(d * 1.001, &pose) == 0.0);
        let q = p + d;
        assert!(cells.contains(&cell(q, &grid)), "{q} around {p}");
    }
}

/// Where a box can have a span in one part only, it has none in any other.
#[test]
fn other_parts_are_left_out_where_they_have_no_span() {
    let mut alone = 0;
    for (_, grid) in grids() {
        for i in 0..4000 {
            let random = |k| random_unit(i, k);
            let far = grid.half * 2f32.powf(4.0 * random(3));
            let position = grid.centre + Vec3::new(random(0), random(1), random(2)) * far;
            let r =
                Vec3::new(random(4), random(5), random(6)).abs() * 0.3 * far * (1.0 + random(7));
            let parts = parts(position, r, &grid);
            alone += u32::from(parts.len() == 1);
            for part in (0..PARTS).filter(|part| !parts.contains(part)) {
                assert_eq!(
                    span(position, r, &grid, part),
                    None,
                    "{position} {r} {part}"
                );
            }
        }
    }
    assert!(alone > 5_000, "{alone}");
}
