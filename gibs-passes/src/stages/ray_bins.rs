//! `*/ray_sorting_bins`: a bin for each ray (I9).
use crate::data::{GridShape, Ray, SurfelPose};
use crate::shared::{requests, sorting};
use gibs_graph::{DispatchArgs, Workgroup, stage};
use glam::UVec2;

stage! {
    /// Finds the bin of each ray of a batch, from the cell of its surfel and from its direction, and counts the rays of each
    /// bin (GIBS, "Ray Sorting").
    pub stage RayBins {
        wgsl: gibs_shaders::stages::RAY_BINS,
        workgroup: [64, 1, 1],
        ports: {
            uniform batch: DispatchArgs,
            uniform grid: GridShape,
            read poses: SurfelPose,
            read spans: UVec2,
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
        let (first, last) = requests::range(p.spans[i]);
        if first.wrapping_sub(p.batch.first) >= p.batch.count {
            continue;
        }
        let place = sorting::place(p.poses[i].position, p.grid);
        for ray in first as usize..last as usize {
            let bin = sorting::bin(place, p.rays[ray].direction);
            p.bins.set(ray, bin);
            p.counts.add(bin as usize, 1);
        }
    }
}
