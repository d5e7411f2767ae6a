//! `spawn/hit_gaps`: where rays hit what no surfel covers.
use crate::data::{Frame, Gathered, NONE, SurfacePoint, SurfelSettings};
use crate::shared::{hash, surface};
use gibs_graph::{DispatchArgs, Workgroup, stage};

stage! {
    /// Proposes a surfel at hits that surfels do not cover, with the probability of what is missing, so that no more than the
    /// setting are proposed in a frame on average. `candidates` is the hit with [`super::spawn::AT_HIT`], or `NONE`; `flags` is
    /// 1 for those.
    pub stage HitGaps {
        wgsl: gibs_shaders::stages::HIT_GAPS,
        workgroup: [64, 1, 1],
        ports: {
            uniform batch: DispatchArgs,
            uniform frame: Frame,
            uniform settings: SurfelSettings,
            read points: SurfacePoint,
            read gathered: Gathered,
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
                candidate = super::spawn::AT_HIT | i as u32;
            }
        }
        p.candidates.set(i, candidate);
        p.flags.set(i, u32::from(candidate != NONE));
    }
}
