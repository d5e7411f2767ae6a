//! The non-linear grid (GIBS, "Acceleration Structure"): uniform cells in a cube around the eye, and one trapezoidal
//! grid along each of the six half-axes. Lookup is closed form; every point lies in exactly one cell.
use super::lookup;
use super::portable::log2;
use crate::data::{GridShape, SurfelPose};
use glam::Vec3;

/// A surfel's radius is at most this share of its cell's side, which bounds the cells that list it.
pub const RADIUS_SHARE: f32 = 0.5;

/// Thickness of a slice over the width of its cells: surfels lie on surfaces, most of which are seen at an angle, so
/// that thicker cells list hardly more of them, and fewer slices reach as far.
pub const THICKNESS: f32 = 1.5;

/// Cells of a grid, which decide the length of its buffers: fixed when a frame is made, wherever the grid then lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GridLayout {
    /// Cells along each side of the cube, and across each slice.
    pub side: u32,
    /// Slices per half-axis.
    pub slices: u32,
}

impl GridLayout {
    /// `side` cells along each axis of the cube, and slices up to `reach` times the cube's half size, where the last
    /// one begins, which has no end.
    pub fn new(side: u32, reach: f32) -> Self {
        let slices = (reach.log2() / Self::growth(side).log2()).ceil().max(1.0) as u32;
        Self { side, slices }
    }

    fn growth(side: u32) -> f32 {
        1.0 + THICKNESS * 2.0 / side as f32
    }

    /// Number of cells.
    pub fn cells(&self) -> u32 {
        self.side * self.side * (self.side + 6 * self.slices)
    }

    /// The grid around `centre`, whose cube reaches `half` metres.
    pub fn at(&self, centre: Vec3, half: f32) -> GridShape {
        let growth = Self::growth(self.side);
        GridShape {
            centre,
            half,
            side: self.side,
            slices: self.slices,
            growth,
            per_octave: 1.0 / growth.log2(),
        }
    }
}

#[inline]
fn index(x: f32, side: u32) -> u32 {
    // Not `clamp`, which panics for a grid that nobody has written yet.
    ((x * 0.5 + 0.5) * side as f32)
        .max(0.0)
        .min(side as f32 - 1.0) as u32
}

/// The slice at a distance along a half-axis.
#[inline]
fn slice(m: f32, grid: &GridShape) -> u32 {
    (log2(m / grid.half) * grid.per_octave)
        .max(0.0)
        .min(grid.slices as f32 - 1.0) as u32
}

/// The cell of a position.
#[inline]
pub fn cell(position: Vec3, grid: &GridShape) -> u32 {
    let d = position - grid.centre;
    let a = d.abs();
    let m = a.x.max(a.y).max(a.z);
    let side = grid.side;
    if m < grid.half {
        let x = index(d.x / grid.half, side);
        let y = index(d.y / grid.half, side);
        let z = index(d.z / grid.half, side);
        return (z * side + y) * side + x;
    }
    // Face 0..6 is the half-axis; u and v are the other two axes, in order.
    let (face, along, u, v) = if a.x >= a.y && a.x >= a.z {
        (0, d.x, d.y, d.z)
    } else if a.y >= a.z {
        (2, d.y, d.x, d.z)
    } else {
        (4, d.z, d.x, d.y)
    };
    let face = face + u32::from(along < 0.0);
    let (u, v) = (index(u / m, side), index(v / m, side));
    side * side * side + ((face * grid.slices + slice(m, grid)) * side + v) * side + u
}

/// Side of the cells around a position, metres.
#[inline]
pub fn cell_side(position: Vec3, grid: &GridShape) -> f32 {
    let a = (position - grid.centre).abs();
    2.0 * a.x.max(a.y).max(a.z).max(grid.half) / grid.side as f32
}

/// A box of cells in one of the seven grids: cell `(z * side + y) * side + x` above `base`, for each coordinate from
/// `low` to `high`, both included. For a half-axis, z counts slices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// First cell of the grid.
    pub base: u32,
    /// Lowest cell along x, y and z.
    pub low: [u32; 3],
    /// Highest cell along x, y and z.
    pub high: [u32; 3],
}

/// Number of grids: the cube and six half-axes.
pub const PARTS: u32 = 7;

/// What a surfel reaches is taken this much larger when its cells are found, so that rounding leaves none out.
const MARGIN: f32 = 1.001;

/// How far a surfel reaches along each axis, metres: the box around the flat ellipsoid outside which it has no weight.
#[inline]
pub fn extents(pose: &SurfelPose) -> Vec3 {
    const FLAT: f32 = 1.0 - 1.0 / (lookup::SQUASH * lookup::SQUASH);
    let across = (Vec3::ONE - pose.normal * pose.normal * FLAT).max(Vec3::ZERO);
    pose.radius * MARGIN * Vec3::new(across.x.sqrt(), across.y.sqrt(), across.z.sqrt())
}

/// The cells of one of the [`PARTS`] that a box around a position, which reaches so far along each axis, can overlap: all
/// that it does, and a few more. A cell is in at most one part's span.
#[inline]
pub fn span(position: Vec3, r: Vec3, grid: &GridShape, part: u32) -> Option<Span> {
    let (d, side) = (position - grid.centre, grid.side);
    if part == 0 {
        let (low, high) = ((d - r) / grid.half, (d + r) / grid.half);
        if low.max_element() > 1.0 || high.min_element() < -1.0 {
            return None;
        }
        let cells = |v: Vec3| [index(v.x, side), index(v.y, side), index(v.z, side)];
        return Some(Span {
            base: 0,
            low: cells(low),
            high: cells(high),
        });
    }
    let face = part - 1;
    let turned = |v: Vec3| match face / 2 {
        0 => v,
        1 => Vec3::new(v.y, v.x, v.z),
        _ => Vec3::new(v.z, v.x, v.y),
    };
    let (d, r) = (turned(d), turned(r));
    let along = if face % 2 == 1 { -d.x } else { d.x };
    let far = along + r.x;
    if far < grid.half || d.y.abs() - r.y > far || d.z.abs() - r.z > far {
        return None;
    }
    // Within the half-axis's pyramid the main coordinate lies between the two; a lateral one is divided by it.
    let near = (along - r.x).max(grid.half);
    let low = |x: f32| if x < 0.0 { x / near } else { x / far };
    let high = |x: f32| if x > 0.0 { x / near } else { x / far };
    let (u0, u1) = (low(d.y - r.y), high(d.y + r.y));
    let (v0, v1) = (low(d.z - r.z), high(d.z + r.z));
    Some(Span {
        base: side * side * side + face * grid.slices * side * side,
        low: [index(u0, side), index(v0, side), slice(near, grid)],
        high: [index(u1, side), index(v1, side), slice(far, grid)],
    })
}

/// Calls `each` with every cell that a surfel can overlap, once.
#[inline]
pub fn overlapped(pose: &SurfelPose, grid: &GridShape, mut each: impl FnMut(u32)) {
    let reach = extents(pose);
    for span in (0..PARTS).filter_map(|part| span(pose.position, reach, grid, part)) {
        for z in span.low[2]..=span.high[2] {
            for y in span.low[1]..=span.high[1] {
                for x in span.low[0]..=span.high[0] {
                    each(span.base + (z * grid.side + y) * grid.side + x);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
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
                let layout = GridLayout::new(side, 400.0);
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
                normal: match i % 4 {
                    0 => Vec3::NEG_Y,
                    _ => direction(i, 7),
                },
                identity: i,
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
            // On the ellipsoid's surface: of a sphere, squashed along the normal.
            let on_sphere = direction(i, 4);
            let along = on_sphere.dot(pose.normal) * (1.0 - 1.0 / lookup::SQUASH);
            let d = (on_sphere - pose.normal * along) * pose.radius;
            assert!(lookup::falloff(d * 0.999, &pose) > 0.0);
            assert!(lookup::falloff(d * 1.001, &pose) == 0.0);
            let q = p + d;
            assert!(cells.contains(&cell(q, &grid)), "{q} around {p}");
        }
    }
}
