//! The non-linear grid (GIBS, "Acceleration Structure"): uniform cells in a cube around the eye, and one trapezoidal
//! grid along each of the six half-axes. Lookup is closed form; every point lies in exactly one cell.
use super::portable::log2;
use crate::data::GridShape;
use glam::Vec3;

/// Most cells that one surfel can overlap.
pub const MAX_OVERLAP: usize = 27;

/// A surfel's radius is at most this share of its cell's side, so that its bounding box spans at most three cells
/// along each axis, also where cells of different grids meet.
pub const RADIUS_SHARE: f32 = 0.75;

/// Thickness of a slice over the width of its cells: surfels lie on surfaces, most of which are seen at an angle, so
/// that thicker cells list hardly more of them, and fewer slices reach as far.
pub const THICKNESS: f32 = 1.5;

impl GridShape {
    /// A grid around `centre`: the cube reaches `half` metres, with `side` cells along each axis; slices follow along
    /// each half-axis up to `reach` times that, where the last one begins, which has no end.
    pub fn new(centre: Vec3, half: f32, side: u32, reach: f32) -> Self {
        let growth = 1.0 + THICKNESS * 2.0 / side as f32;
        let slices = (reach.log2() / growth.log2()).ceil().max(1.0) as u32;
        Self { centre, half, side, slices, growth, per_octave: 1.0 / growth.log2() }
    }

    /// Number of cells.
    pub fn cells(&self) -> u32 {
        self.side * self.side * (self.side + 6 * self.slices)
    }
}

/// The cell of a position.
#[inline]
pub fn cell(position: Vec3, grid: &GridShape) -> u32 {
    let d = position - grid.centre;
    let a = d.abs();
    let m = a.x.max(a.y).max(a.z);
    let side = grid.side;
    let index = |x: f32| ((x * 0.5 + 0.5) * side as f32).clamp(0.0, side as f32 - 1.0) as u32;
    if m < grid.half {
        let x = index(d.x / grid.half);
        let y = index(d.y / grid.half);
        let z = index(d.z / grid.half);
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
    let slice = (log2(m / grid.half) * grid.per_octave).clamp(0.0, grid.slices as f32 - 1.0) as u32;
    let (u, v) = (index(u / m), index(v / m));
    side * side * side + ((face * grid.slices + slice) * side + v) * side + u
}

/// Side of the cells around a position, metres.
#[inline]
pub fn cell_side(position: Vec3, grid: &GridShape) -> f32 {
    let a = (position - grid.centre).abs();
    2.0 * a.x.max(a.y).max(a.z).max(grid.half) / grid.side as f32
}

/// The distinct cells that the bounding box of a sphere overlaps, in the order of a fixed 3x3x3 pattern of points;
/// the radius is at most [`RADIUS_SHARE`] of the cell side.
#[inline]
pub fn overlapped(position: Vec3, radius: f32, grid: &GridShape) -> ([u32; MAX_OVERLAP], usize) {
    let mut cells = [0; MAX_OVERLAP];
    let mut count = 0;
    for i in 0..27 {
        let step = Vec3::new((i % 3) as f32 - 1.0, (i / 3 % 3) as f32 - 1.0, (i / 9) as f32 - 1.0);
        let found = cell(position + step * radius, grid);
        if !cells[..count].contains(&found) {
            cells[count] = found;
            count += 1;
        }
    }
    (cells, count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shared::hash;

    fn random_unit(i: u32, k: u32) -> f32 {
        hash::unit(hash::hash2(i, k)) * 2.0 - 1.0
    }

    /// Lower and upper bound along the main axis, or the centre cube, that a cell index stands for.
    fn contains(cell: u32, p: Vec3, grid: &GridShape) -> bool {
        let (d, n) = ((p - grid.centre).as_dvec3(), grid.side);
        let m = d.abs().max_element();
        let half = f64::from(grid.half);
        let within = |i: u32, x: f64| {
            let (low, high) = (f64::from(i) / f64::from(n), f64::from(i + 1) / f64::from(n));
            (low - 1e-5..=high + 1e-5).contains(&(x * 0.5 + 0.5))
        };
        if cell < n * n * n {
            let q = d / half;
            return m <= half * 1.00001
                && within(cell % n, q.x)
                && within(cell / n % n, q.y)
                && within(cell / n / n, q.z);
        }
        let rest = cell - n * n * n;
        let (u, v, slice, face) = (rest % n, rest / n % n, rest / n / n % grid.slices, rest / n / n / grid.slices);
        let axes = [(d.x, d.y, d.z), (d.y, d.x, d.z), (d.z, d.x, d.y)][face as usize / 2];
        let along = if face % 2 == 1 { -axes.0 } else { axes.0 };
        let growth = f64::from(grid.growth);
        let near = half * growth.powi(slice as i32);
        let far = if slice + 1 == grid.slices { f64::INFINITY } else { near * growth };
        along >= m * 0.99999
            && (near * 0.9999..=far * 1.0001).contains(&m)
            && within(u, axes.1 / m)
            && within(v, axes.2 / m)
    }

    #[test]
    fn every_point_lies_in_the_cell_it_maps_to() {
        for (half, side) in [(1e-3, 16), (0.5, 32), (100.0, 24)] {
            let grid = GridShape::new(Vec3::new(0.1, -0.2, 0.3) * half, half, side, 200.0);
            for i in 0..50_000 {
                // From a thousandth of the cube to far beyond the last slice.
                let scale = half * 10f32.powf(4.5 + 7.5 * random_unit(i, 3)).max(1e-3);
                let p = grid.centre + Vec3::new(random_unit(i, 0), random_unit(i, 1), random_unit(i, 2)) * scale;
                let c = cell(p, &grid);
                assert!(c < grid.cells());
                assert!(contains(c, p, &grid), "{p} is not in cell {c}");
            }
        }
    }

    /// A point inside a surfel's sphere always finds the surfel in its own cell.
    #[test]
    fn a_point_in_a_sphere_lies_in_an_overlapped_cell() {
        let grid = GridShape::new(Vec3::ZERO, 0.5, 32, 200.0);
        for i in 0..100_000 {
            let scale = 0.5 * 10f32.powf(1.2 + 1.2 * random_unit(i, 3));
            let p = Vec3::new(random_unit(i, 0), random_unit(i, 1), random_unit(i, 2)) * scale;
            let radius = cell_side(p, &grid) * RADIUS_SHARE;
            let (cells, count) = overlapped(p, radius, &grid);
            let q = p + Vec3::new(random_unit(i, 4), random_unit(i, 5), random_unit(i, 6)).normalize() * radius;
            assert!(cells[..count].contains(&cell(q, &grid)), "{q} around {p}");
        }
    }
}
