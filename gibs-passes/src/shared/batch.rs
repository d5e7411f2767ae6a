//! Sizes of indirect dispatches.
use gibs_graph::{DispatchArgs, MAX_GROUPS};

/// Invocations per workgroup of every stage that is dispatched indirectly.
pub const LANES: u32 = 64;

/// Workgroups for `count` invocations, folded into rows where one is too short.
#[inline]
pub fn args(count: u32) -> DispatchArgs {
    let groups = count.div_ceil(LANES);
    let rows = groups.div_ceil(MAX_GROUPS);
    if rows <= 1 {
        DispatchArgs {
            x: groups,
            y: 1,
            z: 1,
            count,
            ..DispatchArgs::default()
        }
    } else {
        DispatchArgs {
            x: MAX_GROUPS,
            y: rows,
            z: 1,
            count,
            ..DispatchArgs::default()
        }
    }
}
