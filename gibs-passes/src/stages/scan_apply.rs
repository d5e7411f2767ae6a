//! Last of three stages of an exclusive prefix sum: the sum before each number.
use crate::shared::scan::BLOCK;
use gibs_graph::{Workgroup, stage};

stage! {
    /// Writes for each number the sum of all before it.
    pub stage ScanApply {
        wgsl: gibs_shaders::stages::SCAN_APPLY,
        workgroup: [256, 1, 1],
        ports: {
            read values: u32,
            read before: u32,
            write scanned: u32,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    let block = group.linear() as usize;
    if block >= p.before.len() {
        return;
    }
    let first = block * BLOCK;
    let values = &p.values[first..(first + BLOCK).min(p.values.len())];
    let mut sum = p.before[block];
    for (i, &value) in (first..).zip(values) {
        p.scanned.set(i, sum);
        sum = sum.wrapping_add(value);
    }
}
