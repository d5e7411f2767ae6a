//! `persistent/grid_scatter`: surfels into the lists of their cells.
use crate::data::{GridShape, SurfelPose};
use crate::shared::grid;
use gibs_graph::{Workgroup, stage};

stage! {
    /// Writes every live surfel into the list of each cell that it overlaps, which has as much room again behind its surfels
    /// for their bounds. The order within a list is that of
    /// arrival; `grid_order` makes it one that does not depend on it.
    pub stage GridScatter {
        wgsl: gibs_shaders::stages::GRID_SCATTER,
        workgroup: [64, 1, 1],
        ports: {
            uniform grid: GridShape,
            read poses: SurfelPose,
            read starts: u32,
            atomic cursors: u32,
            write entries: u32,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    for i in group.range(p.poses.len() as u32) {
        let pose = &p.poses[i];
        if pose.radius > 0.0 {
            grid::overlapped(pose, p.grid, |cell| {
                let slot = (2 * p.starts[cell as usize] + p.cursors.add(cell as usize, 1)) as usize;
                if slot < p.entries.len() {
                    p.entries.set(slot, i as u32);
                }
            });
        }
    }
}
