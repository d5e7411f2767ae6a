//! `apply/inject_carry`: lists that new surfels join, to where there is room for those.
use crate::shared::lists;
use gibs_graph::{Workgroup, stage};
use glam::UVec2;

stage! {
    /// Copies each list that new surfels join to the second half of `entries`, where there is room behind it for those:
    /// `counts` is how many it has then, 0 of all others, which stay where they are. A list that does not fit is empty, and its
    /// entries are counted; so is one that did not fit before, until all lists are built again.
    pub stage GridCarry {
        wgsl: gibs_shaders::stages::GRID_CARRY,
        workgroup: [64, 1, 1],
        ports: {
            read starts: u32,
            read counts: u32,
            read_write entries: u32,
            read_write cells: UVec2,
            atomic overflow: u32,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    let range = group.range(p.counts.len() as u32);
    if p.counts[range.clone()].iter().all(|&count| count == 0) {
        return;
    }
    for cell in range {
        let count = p.counts[cell] as usize;
        if count == 0 {
            continue;
        }
        let old = p.cells.get(cell);
        let start = p.entries.len() / 2 + 2 * p.starts[cell] as usize;
        if old == lists::DROPPED || start + 2 * count > p.entries.len() {
            p.overflow.add(0, count as u32);
            p.cells.set(cell, lists::DROPPED);
            continue;
        }
        let (first, listed) = (old.x as usize, old.y as usize);
        for i in 0..listed {
            p.entries.set(start + i, p.entries.get(first + i));
            let bounds = p.entries.get(first + listed + i);
            p.entries.set(start + count + i, bounds);
        }
        p.cells.set(cell, UVec2::new(start as u32, count as u32));
    }
}
