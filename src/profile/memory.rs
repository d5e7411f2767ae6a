//! Where memory goes.
use super::MemoryCost;
use gibs_graph::{Kind, Schedule};

/// The memory of a schedule; with what only wide CPU kernels see where `host` is set.
pub(super) fn memory(schedule: &Schedule, host: bool) -> MemoryCost {
    let mut cost = MemoryCost {
        total: schedule.bytes(host),
        ..MemoryCost::default()
    };
    let there = schedule.resources.iter();
    for resource in there.filter(|r| r.usage.on_device() || host) {
        let room = resource.room * resource.kind.allocations();
        match resource.kind {
            Kind::Input => cost.inputs += room,
            Kind::State(_) | Kind::History(_) => cost.kept += room,
            _ => {
                cost.transient += room;
                cost.saved_by_sharing += resource.bytes;
            }
        }
    }
    cost.saved_by_sharing = cost.saved_by_sharing.saturating_sub(cost.transient);
    cost
}
