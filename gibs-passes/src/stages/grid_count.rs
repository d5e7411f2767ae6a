//! `persistent/grid_count`: how many surfels each cell lists.
use crate::data::{GridShape, SurfelPose};
use crate::shared::grid;
use gibs_graph::{Workgroup, stage};

stage! {
    /// Counts every live surfel in each cell that the box around it overlaps (S11).
    pub stage GridCount {
        wgsl: gibs_shaders::stages::GRID_COUNT,
        workgroup: [64, 1, 1],
        ports: {
            uniform grid: GridShape,
            read poses: SurfelPose,
            atomic counts: u32,
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
                p.counts.add(cell as usize, 1);
            });
        }
    }
}
