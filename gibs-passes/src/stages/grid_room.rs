//! `apply/inject_room`: how much room the lists need that new surfels join.
use gibs_graph::{Workgroup, stage};
use glam::UVec2;

stage! {
    /// Counts, of each cell with new surfels, those and the ones that its list has; of all others nothing, since their lists stay
    /// where they are.
    pub stage GridRoom {
        wgsl: gibs_shaders::stages::GRID_ROOM,
        workgroup: [64, 1, 1],
        ports: {
            read born: u32,
            read cells: UVec2,
            write counts: u32,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    let range = group.range(p.counts.len() as u32);
    if p.born[range.clone()].iter().all(|&born| born == 0) {
        range.for_each(|cell| p.counts.set(cell, 0));
        return;
    }
    for cell in range {
        let count = match p.born[cell] {
            0 => 0,
            born => born + p.cells[cell].y,
        };
        p.counts.set(cell, count);
    }
}
