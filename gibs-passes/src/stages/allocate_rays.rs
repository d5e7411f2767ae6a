//! `persistent/allocate_rays`: each surfel's share of the global budget (I5).
use crate::data::SurfelSettings;
use crate::shared::batch::args;
use gibs_graph::{DispatchArgs, Workgroup, stage};

stage! {
    /// Gives each surfel `request * budget / sum` rays, up and down (GIBS, "Global Ray Budget"), as differences of
    /// floored cumulative shares: the sum is exactly the budget, and a small share still gets a ray now and then.
    /// `offsets` has one element per surfel and one more.
    pub stage AllocateRays {
        wgsl: gibs_shaders::stages::ALLOCATE_RAYS,
        workgroup: [64, 1, 1],
        ports: {
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

/// `floor(a * b / c)` without overflow, for `a <= c`; 0 for `c = 0`.
#[inline]
pub fn share(a: u32, b: u32, c: u32) -> u32 {
    if c == 0 {
        0
    } else {
        (u64::from(a) * u64::from(b) / u64::from(c)) as u32
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    let capacity = p.settings.capacity;
    for i in group.range(capacity + 1) {
        let total = p.total[0];
        let before = if i == capacity as usize {
            total
        } else {
            p.scanned[i]
        };
        let offset = share(before, p.settings.ray_budget, total);
        p.offsets.set(i, offset);
        if i == capacity as usize {
            p.batch.set(0, args(offset));
        }
    }
}
