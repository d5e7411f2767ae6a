//! `persistent/ray_sorting_reorder`: rays in the order of their bins (I9).
use crate::data::{Path, Ray};
use gibs_graph::DispatchArgs;
use gibs_graph::{Workgroup, stage};

stage! {
    /// Copies the rays and paths of a batch into the order of their bins. `places` tells where each went.
    pub stage ReorderRays {
        wgsl: gibs_shaders::stages::REORDER_RAYS,
        workgroup: [64, 1, 1],
        ports: {
            uniform batch: DispatchArgs,
            read order: u32,
            read rays: Ray,
            read paths: Path,
            write sorted_rays: Ray,
            write sorted_paths: Path,
            write places: u32,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    for i in group.range(p.batch.count) {
        let ray = p.order[i] as usize;
        let place = p.batch.first as usize + i;
        p.sorted_rays.set(place, p.rays[ray]);
        p.sorted_paths.set(place, p.paths[ray]);
        p.places.set(ray, place as u32);
    }
}
