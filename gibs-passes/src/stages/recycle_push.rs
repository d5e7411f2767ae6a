//! `persistent/recycle_push`: slots of surfels that go, back onto the free stack (S4).
use crate::data::{SurfelCounters, SurfelLight, SurfelPose};
use gibs_graph::{Workgroup, stage};

stage! {
    /// Pushes the slot of each surfel that goes, by rank, so that no race decides, and ends the surfel. A free slot
    /// says nothing and counts as seen, as the next surfel in it will need.
    pub stage RecyclePush {
        wgsl: gibs_shaders::stages::RECYCLE_PUSH,
        workgroup: [64, 1, 1],
        ports: {
            read gone: u32,
            read ranks: u32,
            read counters: SurfelCounters,
            write free_slots: u32,
            write poses: SurfelPose,
            write light: SurfelLight,
            write unseen: u32,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    for i in group.range(p.gone.len() as u32) {
        if p.gone[i] != 0 {
            let top = (p.counters[0].live - 1 - p.ranks[i]) as usize;
            p.free_slots.set(top, i as u32);
            p.poses.set(i, SurfelPose::default());
            p.light.set(i, SurfelLight::default());
            p.unseen.set(i, 0);
        }
    }
}
