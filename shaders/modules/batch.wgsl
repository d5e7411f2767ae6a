// Sizes of indirect dispatches.
import package::types::DispatchArgs;

/// Invocations per workgroup of every stage that is dispatched indirectly.
const BATCH_LANES: u32 = 64u;
/// Most workgroups along an axis.
const BATCH_MAX_GROUPS: u32 = 65535u;

fn batch_div_ceil(a: u32, b: u32) -> u32 {
    return a / b + select(0u, 1u, a % b != 0u);
}

/// Workgroups for `count` invocations, folded into rows where one is too short.
fn batch_args(count: u32) -> DispatchArgs {
    let groups = batch_div_ceil(count, BATCH_LANES);
    let rows = batch_div_ceil(groups, BATCH_MAX_GROUPS);
    if rows <= 1u {
        return DispatchArgs(groups, 1u, 1u, count, 0u, 0u, 0u, 0u);
    }
    return DispatchArgs(BATCH_MAX_GROUPS, rows, 1u, count, 0u, 0u, 0u, 0u);
}
