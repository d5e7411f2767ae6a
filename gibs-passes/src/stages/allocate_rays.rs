//! `persistent/allocate_rays`: each surfel's share of the global budget (I5).
use crate::data::{Frame, SurfelSettings};
use crate::shared::batch::args;
use crate::shared::hash;
use gibs_graph::{DispatchArgs, Workgroup, stage};

stage! {
    /// Gives each surfel `request * budget / sum` rays, up and down (GIBS, "Global Ray Budget"), as differences of
    /// floored cumulative shares: the sum is exactly the budget. Where the shares are floored moves along from frame to
    /// frame, so that a share below one gets its ray every few frames, wherever it lies. `offsets` has one element per
    /// surfel and one more.
    pub stage AllocateRays {
        wgsl: gibs_shaders::stages::ALLOCATE_RAYS,
        workgroup: [64, 1, 1],
        ports: {
            uniform frame: Frame,
            uniform settings: SurfelSettings,
            read scanned: u32,
            read total: u32,
            write offsets: u32,
            write batch: DispatchArgs,
        },
        cpu: kernel,
        wide: None,
    }
}

/// 2^32 over the golden ratio: its multiples spread over 32 bits as evenly as any sequence can that has no end.
const GOLDEN: u32 = 0x9e37_79b9;

/// Where in `[0, total)` a frame floors the shares from.
#[inline]
pub fn phase(frame: &Frame, total: u32) -> u32 {
    let turn = frame
        .number
        .wrapping_mul(GOLDEN)
        .wrapping_add(hash::pcg(frame.seed));
    ((u64::from(total) * u64::from(turn)) >> 32) as u32
}

/// `floor((a * b + phase) / c)` without overflow, for `a <= c` and `phase < c`; 0 for `c = 0`.
#[inline]
pub fn share(a: u32, b: u32, phase: u32, c: u32) -> u32 {
    if c == 0 {
        0
    } else {
        ((u64::from(a) * u64::from(b) + u64::from(phase)) / u64::from(c)) as u32
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    let surfels = p.scanned.len();
    let total = p.total[0];
    let phase = phase(p.frame, total);
    for i in group.range(p.offsets.len() as u32) {
        let before = if i == surfels { total } else { p.scanned[i] };
        let offset = share(before, p.settings.ray_budget, phase, total);
        p.offsets.set(i, offset);
        if i == surfels {
            p.batch.set(0, args(offset));
        }
    }
}
