//! First of three stages of an exclusive prefix sum: the sum of each block.
use crate::shared::scan::BLOCK;
use gibs_graph::{Workgroup, stage};

stage! {
    /// Sums each block of numbers, wrapping.
    pub stage ScanBlocks {
        wgsl: gibs_shaders::stages::SCAN_BLOCKS,
        workgroup: [256, 1, 1],
        ports: {
            read values: u32,
            write sums: u32,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    let block = group.linear() as usize;
    if block >= p.sums.len() {
        return;
    }
    let first = block * BLOCK;
    let last = (first + BLOCK).min(p.values.len());
    p.sums.set(
        block,
        p.values[first..last]
            .iter()
            .fold(0, |sum, &x| sum.wrapping_add(x)),
    );
}
