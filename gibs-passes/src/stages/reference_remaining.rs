//! `reference/remaining`: how many pixels still have work.
use super::reference_accumulate::finished;
use crate::data::{Frame, ReferencePath, SurfacePoint};
use gibs_graph::{Workgroup, stage};

stage! {
    /// Counts the pixels that have not finished their samples.
    pub stage ReferenceRemaining {
        wgsl: gibs_shaders::stages::REFERENCE_REMAINING,
        workgroup: [64, 1, 1],
        ports: {
            uniform frame: Frame,
            read primary: SurfacePoint,
            read paths: ReferencePath,
            atomic remaining: u32,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    let range = group.range(p.paths.len() as u32);
    let count = range
        .filter(|&i| !finished(&p.paths[i], &p.primary[i], p.frame.samples))
        .count();
    p.remaining.add(0, count as u32);
}
