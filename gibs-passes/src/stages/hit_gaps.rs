//! `spawn/hit_gaps`: where rays hit what no surfel covers.
use super::gap_fill::CROWDED;
use crate::data::{Frame, Gathered, GridShape, NONE, SurfacePoint, SurfelSettings};
use crate::shared::{grid, hash, lists, surface};
use gibs_graph::{DispatchArgs, Workgroup, stage};
use glam::UVec2;

stage! {
    /// Proposes a surfel at hits that surfels do not cover, with the probability of what is missing, so that no more than the
    /// setting are proposed in a frame on average. `candidates` is the hit with [`super::spawn::AT_HIT`], `NONE`, or where a crowded
    /// cell refuses it [`CROWDED`]; `flags` is 1 for surfels to be born.
    pub stage HitGaps {
        wgsl: gibs_shaders::stages::HIT_GAPS,
        workgroup: [64, 1, 1],
        ports: {
            uniform batch: DispatchArgs,
            uniform frame: Frame,
            uniform grid: GridShape,
            uniform settings: SurfelSettings,
            read points: SurfacePoint,
            read gathered: Gathered,
            read cells: UVec2,
            write candidates: u32,
            write flags: u32,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    let count = p.batch.count;
    let rate = p.settings.hit_births as f32 / count.max(1) as f32;
    for i in group.range(p.candidates.len() as u32) {
        let mut candidate = NONE;
        if i < count as usize && surface::is_surface(&p.points[i]) {
            let seed = hash::hash3(i as u32, p.frame.number, p.frame.seed);
            if hash::unit(hash::pcg(seed)) < (1.0 - p.gathered[i].weight) * rate {
                let cell = p.cells[grid::cell(p.points[i].position, p.grid) as usize];
                candidate = if lists::is_crowded(cell, p.settings) {
                    CROWDED
                } else if lists::is_full(cell, p.settings) {
                    NONE
                } else {
                    super::spawn::AT_HIT | i as u32
                };
            }
        }
        p.candidates.set(i, candidate);
        let is_wanted = candidate != NONE && candidate != CROWDED;
        p.flags.set(i, u32::from(is_wanted));
    }
}
