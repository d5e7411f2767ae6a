//! `apply/inject_merge`: the lists of cells with new surfels, in order.
use super::grid_order::{bounds_of, is_before};
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
    for cell in group.range(p.cells.len() as u32) {
        let born = p.born[cell] as usize;
        if born == 0 {
            continue;
        }
        let (start, count) = (p.cells[cell].x as usize, p.cells[cell].y as usize);
        for i in count.saturating_sub(born)..count {
            let moving = p.entries.get(start + i);
            let mut j = i;
            while j > 0 {
                let other = p.entries.get(start + j - 1);
                if !is_before(p.poses.slice(), moving, other) {
                    break;
                }
                p.entries.set(start + j, other);
                j -= 1;
            }
            p.entries.set(start + j, moving);
        }
        let steps = bounds::steps_in(cell as u32, p.grid);
        for i in 0..count {
            let pose = &p.poses[p.entries.get(start + i) as usize];
            p.entries
                .set(start + count + i, bounds_of(pose, p.grid, steps));
        }
    }
}
