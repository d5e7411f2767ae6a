//! `persistent/ray_sorting_bins`: a bin for each ray (I9).
use crate::data::{Frame, GridShape, Ray, SurfelBirth, SurfelPose};
use crate::shared::sorting;
use gibs_graph::{Workgroup, stage};

stage! {
    /// Finds each ray's bin, from the cell of its surfel and from its direction, and counts the rays of each bin (GIBS,
    /// "Ray Sorting").
    pub stage RayBins {
        wgsl: gibs_shaders::stages::RAY_BINS,
        workgroup: [64, 1, 1],
        ports: {
            uniform frame: Frame,
            uniform grid: GridShape,
            read poses: SurfelPose,
            read births: SurfelBirth,
            read offsets: u32,
            read rays: Ray,
            write bins: u32,
            atomic counts: u32,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    for i in group.range(p.poses.len() as u32) {
        let is_new = p.births[i].frame == p.frame.number;
        let place = sorting::place(p.poses[i].position, p.grid, is_new);
        for ray in p.offsets[i] as usize..p.offsets[i + 1] as usize {
            let bin = sorting::bin(place, p.rays[ray].direction);
            p.bins.set(ray, bin);
            p.counts.add(bin as usize, 1);
        }
    }
}
