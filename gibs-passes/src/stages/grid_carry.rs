//! `apply/inject_carry`: the lists of the cells, with room for new surfels.
use crate::shared::lists;
use gibs_graph::{Workgroup, stage};
use glam::UVec2;

stage! {
    /// Copies each cell's list, but for the surfels that are `gone` since, to where there is room behind for those that were
    /// born: `counts` is how many stay, and those. A list that does not fit is empty, and its entries are counted; so is one
    /// that did not fit before, until all lists are built again.
    pub stage GridCarry {
        wgsl: gibs_shaders::stages::GRID_CARRY,
        workgroup: [64, 1, 1],
        ports: {
            read gone: u32,
            read old_cells: UVec2,
            read old_entries: u32,
            read starts: u32,
            read counts: u32,
            write entries: u32,
            write cells: UVec2,
            atomic overflow: u32,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    for cell in group.range(p.cells.len() as u32) {
        let (start, count) = (2 * p.starts[cell] as usize, p.counts[cell] as usize);
        let old = p.old_cells[cell];
        if old == lists::DROPPED || start + 2 * count > p.entries.len() {
            p.overflow.add(0, count as u32);
            p.cells.set(cell, lists::DROPPED);
            continue;
        }
        let (first, listed) = (old.x as usize, old.y as usize);
        let stays = |i: &usize| p.gone[p.old_entries[first + i] as usize] == 0;
        for (i, old) in (0..listed).filter(stays).enumerate() {
            p.entries.set(start + i, p.old_entries[first + old]);
            let bounds = p.old_entries[first + listed + old];
            p.entries.set(start + count + i, bounds);
        }
        p.cells.set(cell, UVec2::new(start as u32, count as u32));
    }
}
