//! `persistent/ray_sorting_scatter`: rays into their bins (I9).
use gibs_graph::DispatchArgs;
use gibs_graph::{Workgroup, stage};

stage! {
    /// Puts each ray's index into its bin, in the order in which threads come.
    pub stage RayScatter {
        wgsl: gibs_shaders::stages::RAY_SCATTER,
        workgroup: [64, 1, 1],
        ports: {
            uniform batch: DispatchArgs,
            read bins: u32,
            read starts: u32,
            atomic cursors: u32,
            write order: u32,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    for i in group.range(p.batch.count) {
        let bin = p.bins[i] as usize;
        let slot = p.starts[bin] + p.cursors.add(bin, 1);
        p.order.set(slot as usize, i as u32);
    }
}
