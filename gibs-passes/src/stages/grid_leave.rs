//! `apply/inject_leave`: how many of each cell's list stay.
use crate::shared::lists;
use gibs_graph::{Workgroup, stage};
use glam::UVec2;

stage! {
    /// Counts the surfels of each cell's list that are not `gone` since. A list that was dropped has none.
    pub stage GridLeave {
        wgsl: gibs_shaders::stages::GRID_LEAVE,
        workgroup: [64, 1, 1],
        ports: {
            read gone: u32,
            read cells: UVec2,
            read entries: u32,
            write counts: u32,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    for cell in group.range(p.counts.len() as u32) {
        let list = p.cells[cell];
        let stays = match list {
            lists::DROPPED => 0,
            _ => (list.x..list.x + list.y)
                .filter(|&i| p.gone[p.entries[i as usize] as usize] == 0)
                .count() as u32,
        };
        p.counts.set(cell, stays);
    }
}
