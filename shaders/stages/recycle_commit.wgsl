// The free stack after this frame's deaths.
import package::types::SurfelCounters;

@group(0) @binding(0) var<storage, read> total: array<u32>;
@group(0) @binding(1) var<storage, read_write> counters: array<SurfelCounters>;

@compute @workgroup_size(1)
fn main() {
    counters[0].live -= total[0];
    counters[0].recycled += total[0];
}
