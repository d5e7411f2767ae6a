//! The non-linear grid (GIBS, "Acceleration Structure"): uniform cells in a cube around the eye, and one trapezoidal
//! grid along each of the six half-axes. Lookup is closed form; every point lies in exactly one cell.
use super::portable::log2;
use super::{lookup, plane};
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
pub const MARGIN: f32 = 1.001;

/// How much less a surfel reaches along its normal than across, in squares.
pub const FLAT: f32 = 1.0 - 1.0 / (lookup::SQUASH * lookup::SQUASH);

/// How far a surfel reaches along each axis, metres: the box around the flat ellipsoid outside which it has no weight.
#[inline]
pub fn extents(pose: &SurfelPose) -> Vec3 {
    let normal = plane::unpack(pose.mark);
    let flat = normal * FLAT * normal / normal.dot(normal);
    let across = (Vec3::ONE - flat).max(Vec3::ZERO);
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

/// The parts in which a box can have a span: the only one if it lies well within a half-axis, as most do, else all.
#[inline]
fn parts(position: Vec3, r: Vec3, grid: &GridShape) -> std::ops::Range<u32> {
    let d = position - grid.centre;
    let (low, high) = (d.abs() - r, d.abs() + r);
    for axis in 0..3 {
        let others = high[(axis + 1) % 3].max(high[(axis + 2) % 3]);
        if low[axis] > others.max(grid.half * MARGIN) {
            let part = 1 + 2 * axis as u32 + u32::from(d[axis] < 0.0);
            return part..part + 1;
        }
    }
    0..PARTS
}

/// Calls `each` with every cell that a surfel can overlap, once.
#[inline]
pub fn overlapped(pose: &SurfelPose, grid: &GridShape, mut each: impl FnMut(u32)) {
    let reach = extents(pose);
    let parts = parts(pose.position, reach, grid);
    for span in parts.filter_map(|part| span(pose.position, reach, grid, part)) {
        for z in span.low[2]..=span.high[2] {
            for y in span.low[1]..=span.high[1] {
                for x in span.low[0]..=span.high[0] {
                    each(span.base + (z * grid.side + y) * grid.side + x);
                }
            }
        }
    }
}

/// Calls `each` with surfels and cells that they overlap, as [`overlapped`] does, for those of `surfels` that live.
#[inline(always)]
pub fn overlapped_by(
    surfels: impl Iterator<Item = usize>,
    poses: &[SurfelPose],
    grid: &GridShape,
    mut each: impl FnMut(u32, u32),
) {
    for i in surfels.filter(|&i| poses[i].radius > 0.0) {
        overlapped(&poses[i], grid, |cell| each(i as u32, cell));
    }
}

/// Pairs of surfel and cell on their way to `each`; `soon` hears of each cell well before.
pub struct Pairs<S, E> {
    soon: S,
    each: E,
    waiting: [(u32, u32); 256],
    count: usize,
}

impl<S: Fn(usize), E: FnMut(u32, usize)> Pairs<S, E> {
    /// None yet.
    #[inline(always)]
    pub fn new(soon: S, each: E) -> Self {
        Self {
            soon,
            each,
            waiting: [(0, 0); 256],
            count: 0,
        }
    }

    /// One more.
    #[inline(always)]
    pub fn push(&mut self, id: u32, cell: u32) {
        if self.count == self.waiting.len() {
            self.finish();
        }
        self.waiting[self.count] = (id, cell);
        self.count += 1;
        (self.soon)(cell as usize);
    }

    /// Those that wait.
    #[inline(always)]
    pub fn finish(&mut self) {
        for &(id, cell) in &self.waiting[..self.count] {
            (self.each)(id, cell as usize);
        }
        self.count = 0;
    }
}

#[cfg(test)]
mod tests;
