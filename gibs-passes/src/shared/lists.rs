//! The grid's lists as lookups see them: which surfels a lookup at a point visits.
use super::depth::Depths;
use super::{bounds, grid};
use crate::data::{GridShape, SurfelPose, SurfelSettings};
use crate::simd;
use glam::{UVec2, Vec3};

/// Beginning and length of a list that did not fit.
pub const DROPPED: UVec2 = UVec2::new(u32::MAX, 0);

/// Whether a cell takes no more surfels: it is [crowded](is_crowded), or its list did not fit.
#[inline]
pub fn is_full(cell: UVec2, settings: &SurfelSettings) -> bool {
    is_crowded(cell, settings) || cell == DROPPED
}

/// Whether a cell's list is as long as a lookup. Of more surfels, each would be visited less often, and their number would
/// never settle.
#[inline]
pub fn is_crowded(cell: UVec2, settings: &SurfelSettings) -> bool {
    cell.y >= settings.lookup
}

/// The buffers of a lookup.
#[derive(Clone, Copy)]
pub struct Surfels<'a> {
    /// First entry and number of entries of each cell.
    pub cells: &'a [UVec2],
    /// Surfels of all cells.
    pub entries: &'a [u32],
    /// Where surfels are.
    pub poses: &'a [SurfelPose],
    /// Their depth functions; empty in a frame without.
    pub depths: Depths<'a>,
    /// The grid of the cells.
    pub grid: &'a GridShape,
    /// Settings of the lookup.
    pub settings: &'a SurfelSettings,
}

/// What a lookup at a point visits.
#[derive(Clone, Copy, Default)]
pub struct List<'a> {
    /// Surfels.
    pub ids: &'a [u32],
    /// Their [`bounds`], as many.
    pub bounds: &'a [u32],
    /// Where the point is, to compare with those.
    pub place: u32,
}

impl<'a> Surfels<'a> {
    /// The surfels that a lookup at a point visits.
    #[inline]
    pub fn around(&self, point: Vec3) -> List<'a> {
        let cell = grid::cell(point, self.grid);
        let steps = bounds::steps_in(cell, self.grid);
        self.list(cell, bounds::place(point - self.grid.centre, steps))
    }

    /// The list of a cell, for a point that has a [`place`](bounds::place) there.
    #[inline]
    pub fn list(&self, cell: u32, place: u32) -> List<'a> {
        let (start, count) = (
            self.cells[cell as usize].x as usize,
            self.cells[cell as usize].y,
        );
        let visited = count.min(self.settings.lookup) as usize;
        // Of a dropped list there is nothing.
        let words = self
            .entries
            .get(start..start + 2 * count as usize)
            .unwrap_or(&[]);
        let (ids, bounds) = words.split_at(words.len() / 2);
        let visited = visited.min(ids.len());
        List {
            ids: &ids[..visited],
            bounds: &bounds[..visited],
            place,
        }
    }

    /// First entry and number of entries of the cell of a point.
    #[inline]
    pub fn cell(&self, point: Vec3) -> UVec2 {
        self.cells[grid::cell(point, self.grid) as usize]
    }

    /// [`Surfels::around`] for several points at a time, of which `position` tells where they are, and nothing where
    /// there is none: what one step needs of memory is asked for at all points before the next step.
    #[inline(always)]
    pub fn lists<const N: usize>(
        &self,
        mut position: impl FnMut(usize) -> Option<Vec3>,
    ) -> [List<'a>; N] {
        const PER_LINE: usize = 16;
        const LINES: usize = 4;
        let cells: [Option<(u32, Vec3)>; N] = std::array::from_fn(|i| {
            let point = position(i)?;
            let cell = grid::cell(point, self.grid);
            simd::prefetch(self.cells, cell as usize);
            Some((cell, point))
        });
        cells.map(|cell| {
            let Some((cell, point)) = cell else {
                return List::default();
            };
            let steps = bounds::steps_in(cell, self.grid);
            let list = self.list(cell, bounds::place(point - self.grid.centre, steps));
            for line in (0..list.ids.len().min(LINES * PER_LINE)).step_by(PER_LINE) {
                simd::prefetch(list.bounds, line);
                simd::prefetch(list.ids, line);
            }
            list
        })
    }
}
