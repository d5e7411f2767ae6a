//! `persistent/grid_order`: the lists of the cells, in an order that depends on nothing but the surfels.
use crate::data::{GridShape, SurfelPose};
use crate::shared::{bounds, hash, lists, mark};
use gibs_graph::{Workgroup, WriteView, stage};
use glam::UVec2;

stage! {
    /// Orders each cell's list by a hash of surfel identity, so that the first N are an unbiased subset and the same
    /// on every run (X9), and writes their bounds behind them. A list that does not fit into the first half of `entries` is
    /// emptied, whatever arrived first, and its entries are counted.
    pub stage GridOrder {
        wgsl: gibs_shaders::stages::GRID_ORDER,
        workgroup: [64, 1, 1],
        ports: {
            uniform grid: GridShape,
            read poses: SurfelPose,
            read starts: u32,
            read counts: u32,
            read_write entries: u32,
            write cells: UVec2,
            atomic overflow: u32,
        },
        cpu: kernel,
        wide: Some(wide_kernel),
    }
}

/// Sort key of a surfel: equal hashes fall back to the slot.
#[inline]
fn key(poses: &[SurfelPose], id: u32) -> (u32, u32) {
    (hash::pcg(mark::identity(poses[id as usize].mark)), id)
}

/// Whether a surfel stands before another one in a list.
#[inline]
pub fn is_before(poses: &[SurfelPose], id: u32, other: u32) -> bool {
    key(poses, id) < key(poses, other)
}

/// Puts `count` entries from `start` on in order. Shell sort: in place, and fast enough for lists of tens to hundreds.
pub fn sort(entries: &WriteView<'_, u32>, poses: &[SurfelPose], start: usize, count: usize) {
    let mut gap = count / 2;
    while gap > 0 {
        for i in gap..count {
            let moving = entries.get(start + i);
            let mut j = i;
            while j >= gap {
                let other = entries.get(start + j - gap);
                if !is_before(poses, moving, other) {
                    break;
                }
                entries.set(start + j, other);
                j -= gap;
            }
            entries.set(start + j, moving);
        }
        gap /= 2;
    }
}

/// The bounds of a surfel in a list where a metre has so many steps.
#[inline]
pub fn bounds_of(pose: &SurfelPose, grid: &GridShape, steps: f32) -> u32 {
    bounds::pack(pose.position - grid.centre, pose.radius, steps)
}

/// Longest list that the wide kernel sorts in a buffer of its own. A longer buffer takes more time to clear than most lists do
/// to be sorted.
const MOST_SORTED: usize = 256;

/// Looks each surfel up once, and sorts numbers.
fn wide_kernel(p: &Views<'_>, group: Workgroup) {
    let range = group.range(p.cells.len() as u32);
    let fits = |cell: usize| 2 * p.starts[cell] as usize <= p.entries.len() / 2;
    let is_empty = p.counts[range.clone()].iter().all(|&count| count == 0);
    if is_empty && range.clone().last().is_none_or(fits) {
        for cell in range {
            let start = 2 * p.starts[cell];
            p.cells.set(cell, UVec2::new(start, 0));
        }
        return;
    }
    let mut keys = [0u64; MOST_SORTED];
    for cell in range {
        let (start, count) = (2 * p.starts[cell] as usize, p.counts[cell] as usize);
        if count > MOST_SORTED || start + 2 * count > p.entries.len() / 2 {
            order(p, cell);
            continue;
        }
        p.cells.set(cell, UVec2::new(start as u32, count as u32));
        if count == 0 {
            continue;
        }
        let keys = &mut keys[..count];
        for (i, key) in keys.iter_mut().enumerate() {
            let id = p.entries.get(start + i);
            let (hash, id) = self::key(p.poses.slice(), id);
            *key = u64::from(hash) << 32 | u64::from(id);
        }
        keys.sort_unstable();
        let steps = bounds::steps_in(cell as u32, p.grid);
        for (i, key) in keys.iter().enumerate() {
            let id = *key as u32;
            p.entries.set(start + i, id);
            let bounds = bounds_of(&p.poses[id as usize], p.grid, steps);
            p.entries.set(start + count + i, bounds);
        }
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    for cell in group.range(p.cells.len() as u32) {
        order(p, cell);
    }
}

fn order(p: &Views<'_>, cell: usize) {
    let (start, count) = (2 * p.starts[cell] as usize, p.counts[cell] as usize);
    if start + 2 * count > p.entries.len() / 2 {
        p.overflow.add(0, count as u32);
        p.cells.set(cell, lists::DROPPED);
        return;
    }
    p.cells.set(cell, UVec2::new(start as u32, count as u32));
    sort(&p.entries, p.poses.slice(), start, count);
    let steps = bounds::steps_in(cell as u32, p.grid);
    for i in 0..count {
        let pose = &p.poses[p.entries.get(start + i) as usize];
        p.entries
            .set(start + count + i, bounds_of(pose, p.grid, steps));
    }
}
