//! What lookups at several points visit.
use std::arch::x86_64::*;

use super::super::directions::unpack;
use super::super::lanes::{columns, store_rows};
use super::super::prefetch;
use super::cells::Cells;
use crate::data::{SurfacePoint, SurfelPose};
use crate::shared::lists::{List, Surfels};
use crate::shared::lookup::{AT_A_TIME, Owns, Points};
use crate::shared::surface;

/// Entries of a list in a line of the cache.
const PER_LINE: usize = 16;

/// Lines of a list that are asked for beforehand.
const LINES: usize = 4;

/// Points, and the surfels that lookups there visit.
pub struct Batch<'a> {
    /// The points, as surfels that lie there, to be loaded in the same way.
    pub points: [SurfelPose; AT_A_TIME],
    /// Of each the list; empty where there is no point.
    pub lists: [List<'a>; AT_A_TIME],
}

impl<'a> Batch<'a> {
    /// No points.
    #[inline(always)]
    pub fn new() -> Self {
        Batch {
            points: [SurfelPose::default(); AT_A_TIME],
            lists: [List::default(); AT_A_TIME],
        }
    }

    /// Takes surfels as points, with their lists.
    #[inline]
    pub fn around(&mut self, owns: &Owns<'a>, s: &Surfels<'a>) {
        for (pose, own) in self.points.iter_mut().zip(&owns.ids) {
            if let Some(own) = own {
                *pose = s.poses[*own];
            }
        }
        self.lists = owns.lists;
    }

    /// Finds the lists of points, in place: a batch is large to move. What one step needs of memory is
    /// asked for at all points before the next step.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn find(&mut self, points: &Points<'_>, s: &Surfels<'a>) {
        let zero = _mm256_setzero_ps();
        let mut cells = [0; AT_A_TIME];
        let (eights, _) = self.points.as_chunks_mut::<8>();
        for (poses, start) in eights.iter_mut().zip((0..AT_A_TIME).step_by(8)) {
            // Where there is no point, any will do: its list stays empty.
            let eight: [&SurfacePoint; 8] =
                std::array::from_fn(|i| points[start + i].unwrap_or(&surface::MISS));
            let [x, y, z, _] = columns::<0, _>(&eight);
            let [_, shading, _, _] = columns::<4, _>(&eight);
            let [nx, ny, nz] = unpack(shading);
            store_rows(poses, &[x, y, z, zero], &[nx, ny, nz, zero]);
            let found = Cells::of(&[x, y, z], s.grid);
            for lane in 0..8 {
                cells[start + lane] = found.cell[lane];
                self.lists[start + lane].place = found.place[lane];
                prefetch(s.cells, found.cell[lane] as usize);
            }
        }
        for ((list, &cell), point) in self.lists.iter_mut().zip(&cells).zip(points) {
            if point.is_some() {
                *list = s.list(cell, list.place);
                for line in (0..list.ids.len().min(LINES * PER_LINE)).step_by(PER_LINE) {
                    prefetch(list.bounds, line);
                    prefetch(list.ids, line);
                }
            }
        }
    }
}
