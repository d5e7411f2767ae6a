//! `spawn/spawn_claim`: a free slot for each birth (S4).
use super::gap_fill::CROWDED;
use crate::data::{Frame, NONE, SurfelCounters, SurfelSettings};
use crate::shared::hash;
use gibs_graph::{Workgroup, stage};
use glam::UVec2;

stage! {
    /// Pops the free stack for each quarter of a tile with a candidate, by rank, so that no race decides; where there are too few
    /// slots, the rank that is served first is drawn anew each frame, so that no part of the picture starves. `claims`
    /// is (slot, texel); the slot is `NONE` where no surfel is born or none is free. Counts the holes in crowded cells,
    /// which get none.
    pub stage SpawnClaim {
        wgsl: gibs_shaders::stages::SPAWN_CLAIM,
        workgroup: [64, 1, 1],
        ports: {
            uniform frame: Frame,
            uniform settings: SurfelSettings,
            read candidates: u32,
            read ranks: u32,
            read total: u32,
            read counters: SurfelCounters,
            read free_slots: u32,
            write claims: UVec2,
            atomic crowded: u32,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    let total = p.total[0].max(1);
    let first = hash::hash2(p.frame.number, p.frame.seed) % total;
    for tile in group.range(p.candidates.len() as u32) {
        let candidate = p.candidates[tile];
        let slot = match candidate {
            NONE => None,
            CROWDED => {
                p.crowded.add(0, 1);
                None
            }
            _ => {
                let rank = (p.ranks[tile] + first) % total;
                let slot = p.counters[0].live + rank;
                (slot < p.settings.capacity).then_some(slot)
            }
        };
        let claim = slot.map_or(UVec2::new(NONE, NONE), |slot| {
            UVec2::new(p.free_slots[slot as usize], candidate)
        });
        p.claims.set(tile, claim);
    }
}
