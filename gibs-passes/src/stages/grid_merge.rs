//! `apply/inject_merge`: the lists of cells with new surfels, in order.
use super::grid_order::{bounds_of, is_before, sort};
use crate::data::{GridShape, SurfelPose};
use crate::shared::bounds;
use gibs_graph::{Workgroup, stage};
use glam::UVec2;

stage! {
    /// Moves the new surfels at the end of each cell's list to where they belong, see
    /// [`GridOrder`](super::grid_order::GridOrder), and writes the bounds.
    pub stage GridMerge {
        wgsl: gibs_shaders::stages::GRID_MERGE,
        workgroup: [64, 1, 1],
        ports: {
            uniform grid: GridShape,
            read poses: SurfelPose,
            read cells: UVec2,
            read born: u32,
            read_write entries: u32,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    let range = group.range(p.cells.len() as u32);
    if p.born[range.clone()].iter().all(|&born| born == 0) {
        return;
    }
    for cell in range {
        let born = p.born[cell] as usize;
        if born == 0 {
            continue;
        }
        let (start, count) = (p.cells[cell].x as usize, p.cells[cell].y as usize);
        let born = born.min(count);
        let (first, aside) = (start + count - born, start + count);
        sort(&p.entries, p.poses.slice(), first, born);
        // Out of the way, to where their bounds will be; then the longer part moves up, and they come in from behind.
        for i in 0..born {
            p.entries.set(aside + i, p.entries.get(first + i));
        }
        let (mut old, mut new) = (count - born, born);
        while new > 0 {
            let moving = p.entries.get(aside + new - 1);
            let is_last =
                old == 0 || !is_before(p.poses.slice(), moving, p.entries.get(start + old - 1));
            let next = start + old + new - 1;
            if is_last {
                p.entries.set(next, moving);
                new -= 1;
            } else {
                p.entries.set(next, p.entries.get(start + old - 1));
                old -= 1;
            }
        }
        let steps = bounds::steps_in(cell as u32, p.grid);
        for i in 0..count {
            let pose = &p.poses[p.entries.get(start + i) as usize];
            p.entries
                .set(start + count + i, bounds_of(pose, p.grid, steps));
        }
    }
}
