//! `persistent/grid_scatter`: surfels into the lists of their cells.
use crate::data::{GridShape, SurfelPose};
use crate::shared::grid;
use crate::simd;
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
        wide: Some(wide_kernel),
    }
}

fn wide_kernel(p: &Views<'_>, group: Workgroup) {
    simd::run(
        #[inline(always)]
        || kernel(p, group),
    );
}

#[inline(always)]
fn kernel(p: &Views<'_>, group: Workgroup) {
    grid::overlapped_by(
        group.range(p.poses.len() as u32),
        p.poses.slice(),
        p.grid,
        |cell| {
            p.cursors.prefetch(cell);
            simd::prefetch(p.starts.slice(), cell);
        },
        |id, cell| {
            let slot = (2 * p.starts[cell] + p.cursors.add(cell, 1)) as usize;
            if slot < p.entries.len() {
                p.entries.set(slot, id);
            }
        },
    );
}
