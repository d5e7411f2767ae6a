//! Recording an exclusive prefix sum of `u32`: sums of blocks, their prefix sum, and the prefix sum within each.
use crate::stages::{scan_apply, scan_blocks, scan_sums};
use gibs_graph::{Buffer, Dispatch, Graph, groups_for};

/// Numbers per block.
pub const BLOCK: usize = 1024;

/// The sum of all numbers before each, and the total. `label` is the prefix of the three stages' names.
pub fn exclusive_scan(
    g: &mut Graph,
    label: &str,
    values: &Buffer<u32>,
) -> (Buffer<u32>, Buffer<u32>) {
    let len = values.len();
    let blocks = len.div_ceil(BLOCK as u64);
    let sums = g.transient(&format!("{label}_sums"), blocks);
    let groups = groups_for(blocks, 1);
    let inputs = scan_blocks::Inputs { values, sums };
    let sums = g
        .add::<scan_blocks::ScanBlocks>(
            &format!("{label}_blocks"),
            inputs,
            Dispatch::Groups(groups),
        )
        .sums;
    let total = g.transient(&format!("{label}_total"), 1);
    let before = g.transient(&format!("{label}_before"), blocks);
    let inputs = scan_sums::Inputs {
        sums: &sums,
        before,
        total,
    };
    let summed = g.add::<scan_sums::ScanSums>(
        &format!("{label}_sums"),
        inputs,
        Dispatch::Groups([1, 1, 1]),
    );
    let scanned = g.transient(&format!("{label}_scanned"), len);
    let inputs = scan_apply::Inputs {
        values,
        before: &summed.before,
        scanned,
    };
    let scanned = g
        .add::<scan_apply::ScanApply>(&format!("{label}_apply"), inputs, Dispatch::Groups(groups))
        .scanned;
    (scanned, summed.total)
}
