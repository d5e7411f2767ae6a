//! `persistent/ray_sorting_order`: the rays of each bin, in an order that depends on nothing but the rays (I9, X9).
use crate::shared::sorting::BINS;
use gibs_graph::{Workgroup, stage};

stage! {
    /// Orders each bin by the rays' own order, so that threads do not decide.
    pub stage RayOrder {
        wgsl: gibs_shaders::stages::RAY_ORDER,
        workgroup: [64, 1, 1],
        ports: {
            read starts: u32,
            read counts: u32,
            read_write order: u32,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    for bin in group.range(BINS) {
        let (start, count) = (p.starts[bin] as usize, p.counts[bin] as usize);
        // Shell sort: in place, and fast enough for bins of tens to hundreds.
        let mut gap = count / 2;
        while gap > 0 {
            for i in gap..count {
                let moving = p.order.get(start + i);
                let mut j = i;
                while j >= gap && p.order.get(start + j - gap) > moving {
                    p.order.set(start + j, p.order.get(start + j - gap));
                    j -= gap;
                }
                p.order.set(start + j, moving);
            }
            gap /= 2;
        }
    }
}
