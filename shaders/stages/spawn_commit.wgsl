// The free stack after this frame's births, and the counts of them and of those that found no slot.
import package::types::{SurfelCounters, SurfelSettings};

@group(0) @binding(0) var<uniform> settings: SurfelSettings;
@group(0) @binding(1) var<storage, read> total: array<u32>;
@group(0) @binding(2) var<storage, read_write> counters: array<SurfelCounters>;

@compute @workgroup_size(1)
fn main() {
    let wanted = total[0];
    let born = min(wanted, settings.capacity - counters[0].live);
    counters[0].live += born;
    counters[0].used = max(counters[0].used, counters[0].live);
    counters[0].born += born;
    counters[0].starved += wanted - born;
}
