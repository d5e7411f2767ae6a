//! Second of three stages of an exclusive prefix sum: the sums of the blocks, by one workgroup.
use gibs_graph::{Workgroup, stage};

stage! {
    /// Writes for each block the sum of the blocks before it, and the total.
    pub stage ScanSums {
        wgsl: gibs_shaders::stages::SCAN_SUMS,
        workgroup: [256, 1, 1],
        ports: {
            read sums: u32,
            write before: u32,
            write total: u32,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, _: Workgroup) {
    let mut sum = 0u32;
    for (i, &value) in p.sums.iter().enumerate() {
        p.before.set(i, sum);
        sum = sum.wrapping_add(value);
    }
    p.total.set(0, sum);
}
