//! `persistent/ray_sorting_scatter`: rays into their bins (I9).
use gibs_graph::DispatchArgs;
use gibs_graph::{Comparator, Lists, Ports, Workgroup, stage};

/// Threads write into a list in the order in which they come.
const IN_ORDER_OF_ARRIVAL: Comparator =
    Comparator::exact("indices of rays").in_any_order_within(BINS);

const BINS: Lists = Lists {
    name: "bins",
    of: |ports: &Ports<'_>| {
        let bins = ports
            .get::<u32>("starts")
            .into_iter()
            .zip(ports.get::<u32>("cursors"));
        let bin = |(start, count): (u32, u32)| start as usize..start as usize + count as usize;
        bins.map(bin).collect()
    },
    room: |rays| rays,
};

stage! {
    /// Puts the index of each ray of a batch into its bin, in the order in which threads come.
    pub stage RayScatter {
        wgsl: gibs_shaders::stages::RAY_SCATTER,
        workgroup: [64, 1, 1],
        ports: {
            uniform batch: DispatchArgs,
            read bins: u32,
            read starts: u32,
            atomic cursors: u32,
            write order: u32 => IN_ORDER_OF_ARRIVAL,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    for i in group.range(p.batch.count) {
        let ray = p.batch.first as usize + i;
        let bin = p.bins[ray] as usize;
        let slot = p.starts[bin] + p.cursors.add(bin, 1);
        p.order.set(slot as usize, ray as u32);
    }
}
