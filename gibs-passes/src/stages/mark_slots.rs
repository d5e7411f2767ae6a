//! `check/mark_slots`: what claims each slot (S4).
use crate::data::{SurfelCounters, SurfelPose, SurfelSettings};
use gibs_graph::{Workgroup, stage};

stage! {
    /// Marks every slot once for a live surfel in it and once for each place on the free stack that names it. In a sound
    /// state every slot is marked exactly once. A place that names no slot marks none, which leaves one too few; a surfel in a
    /// slot that counts as never used, which no stage would look at, marks twice.
    pub stage MarkSlots {
        wgsl: gibs_shaders::stages::MARK_SLOTS,
        workgroup: [64, 1, 1],
        ports: {
            uniform settings: SurfelSettings,
            read poses: SurfelPose,
            read counters: SurfelCounters,
            read free_slots: u32,
            atomic marks: u32,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    let capacity = p.settings.capacity;
    for i in group.range(capacity) {
        if p.poses[i].radius > 0.0 {
            let is_known = i < p.counters[0].used as usize;
            p.marks.add(i, if is_known { 1 } else { 2 });
        }
        if i >= p.counters[0].live as usize && p.free_slots[i] < capacity {
            p.marks.add(p.free_slots[i] as usize, 1);
        }
    }
}
