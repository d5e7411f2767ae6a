//! `filtering/spatial`: irradiance of neighbouring surfels (I8).
use crate::data::{
    Frame, GridShape, Neighbours, SurfelBirth, SurfelDepth, SurfelIrradiance, SurfelPose,
    SurfelSettings,
};
use crate::shared::{lookup, sharing};
use crate::simd;
use gibs_graph::{Workgroup, stage};
use glam::UVec2;

stage! {
    /// Asks the neighbours of each uncertain surfel for their irradiance, with the weights of the lookup: distance,
    /// normal and depth function (GIBS, "Irradiance Sharing").
    pub stage ShareIrradiance {
        wgsl: gibs_shaders::stages::SHARE_IRRADIANCE,
        workgroup: [64, 1, 1],
        ports: {
            uniform frame: Frame,
            uniform grid: GridShape,
            uniform settings: SurfelSettings,
            read cells: UVec2,
            read entries: u32,
            read poses: SurfelPose,
            read births: SurfelBirth,
            read irradiance: SurfelIrradiance,
            optional_read depths: SurfelDepth,
            write neighbours: Neighbours,
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
    let surfels = lookup::Surfels {
        cells: p.cells.slice(),
        entries: p.entries.slice(),
        poses: p.poses.slice(),
        depths: p.depths.slice(),
        grid: p.grid,
        settings: p.settings,
    };
    let (irradiance, births) = (p.irradiance.slice(), p.births.slice());
    for i in group.range(p.poses.len() as u32) {
        let age = p.frame.number.wrapping_sub(births[i].frame);
        let asks = p.poses[i].radius > 0.0 && sharing::asks(&irradiance[i], age);
        let neighbours = match asks {
            true => sharing::ask(i, &surfels, irradiance, births, p.frame.number),
            false => Neighbours::default(),
        };
        p.neighbours.set(i, neighbours);
    }
}
