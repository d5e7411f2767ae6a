//! What lookups at several points visit.
#![allow(unsafe_code)]
use super::super::prefetch;
use super::cells::Cells;
use super::poses::Poses;
use crate::data::SurfelPose;
use crate::shared::lookup::{AT_A_TIME, List, Points, Surfels};
use crate::shared::octahedral;

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
    /// Finds the lists. What one step needs of memory is asked for at all points before the next step.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
    pub fn new(points: &Points<'_>, s: &Surfels<'a>) -> Self {
        let mut batch = Batch {
            points: [SurfelPose::default(); AT_A_TIME],
            lists: [List::default(); AT_A_TIME],
        };
        for (pose, point) in batch.points.iter_mut().zip(points) {
            if let Some(point) = point {
                pose.position = point.position;
                pose.normal = octahedral::unpack(point.shading_normal);
            }
        }
        let mut cells = [0; AT_A_TIME];
        for start in (0..AT_A_TIME).step_by(8) {
            let ids = std::array::from_fn(|i| (start + i) as u32);
            // SAFETY: this function is compiled for AVX2.
            let at = unsafe { Poses::load(&batch.points, &ids) };
            let found = Cells::of(&at.position, s.grid);
            for lane in 0..8 {
                cells[start + lane] = found.cell[lane];
                batch.lists[start + lane].place = found.place[lane];
                prefetch(s.cells, found.cell[lane] as usize);
            }
        }
        for ((list, &cell), point) in batch.lists.iter_mut().zip(&cells).zip(points) {
            if point.is_some() {
                *list = s.list(cell, list.place);
                for line in (0..list.ids.len().min(LINES * PER_LINE)).step_by(PER_LINE) {
                    prefetch(list.bounds, line);
                    prefetch(list.ids, line);
                }
            }
        }
        batch
    }
}
