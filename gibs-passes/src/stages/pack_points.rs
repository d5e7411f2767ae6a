//! `apply/pack_points`: the selected pixels, without gaps (S13).
use crate::data::SurfacePoint;
use gibs_graph::{Workgroup, stage};

stage! {
    /// Writes the points of the selected pixels one after the other, in the order of the picture.
    pub stage PackPoints {
        wgsl: gibs_shaders::stages::PACK_POINTS,
        workgroup: [64, 1, 1],
        ports: {
            read points: SurfacePoint,
            read selected: u32,
            read scanned: u32,
            write packed: SurfacePoint,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    for i in group.range(p.points.len() as u32) {
        if p.selected[i] != 0 {
            p.packed.set(p.scanned[i] as usize, p.points[i]);
        }
    }
}
