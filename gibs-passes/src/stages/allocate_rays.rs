//! `persistent/allocate_rays`: each surfel's share of the global budget (I5).
use crate::data::{Frame, SurfelSettings};
use crate::shared::batch::args;
use crate::shared::hash;
use gibs_graph::{DispatchArgs, Workgroup, stage};
use glam::UVec2;

stage! {
    /// Gives each surfel `request * budget / sum` rays, up and down (GIBS, "Global Ray Budget"), as differences of
    /// floored cumulative shares: the sum is exactly the budget. Where the shares are floored moves along from frame to
    /// frame, so that a share below one gets its ray every few frames, wherever it lies.
    ///
    /// `requests` and `scanned` have two elements per surfel, see [`super::request_rays::RequestRays`], so that the rays of
    /// new surfels come after all others. `spans` tells each surfel's first ray and how many it has; `batch` all rays,
    /// `persistent` those of surfels that were there before, `spawned` those of new ones.
    pub stage AllocateRays {
        wgsl: gibs_shaders::stages::ALLOCATE_RAYS,
        workgroup: [64, 1, 1],
        ports: {
            uniform frame: Frame,
            uniform settings: SurfelSettings,
            read requests: u32,
            read scanned: u32,
            read total: u32,
            write spans: UVec2,
            write batch: DispatchArgs,
            write persistent: DispatchArgs,
            write spawned: DispatchArgs,
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
    let surfels = p.spans.len();
    let total = p.total[0];
    let phase = phase(p.frame, total);
    let rays_before = |requested| share(requested, p.settings.ray_budget, phase, total);
    for i in group.range(surfels as u32) {
        let is_new = p.requests[surfels + i] > 0;
        let at = if is_new { surfels + i } else { i };
        let first = rays_before(p.scanned[at]);
        let last = rays_before(p.scanned[at] + p.requests[at]);
        p.spans.set(i, UVec2::new(first, last - first));
        if i == 0 {
            let (all, new) = (rays_before(total), rays_before(p.scanned[surfels]));
            p.batch.set(0, args(all));
            p.persistent.set(0, args(new));
            let spawned = DispatchArgs {
                first: new,
                ..args(all - new)
            };
            p.spawned.set(0, spawned);
        }
    }
}
