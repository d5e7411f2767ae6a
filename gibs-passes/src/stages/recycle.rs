//! `persistent/recycle`: which surfels give up their slots (S9).
use crate::data::{Camera, Frame, GridShape, SurfelCounters, SurfelPose, SurfelSettings};
use crate::shared::depth::Depths;
use crate::shared::lists::Surfels;
use crate::shared::lookup::{self, AT_A_TIME, Owns};
use crate::shared::{hash, mark, recycling};
use crate::simd;
use gibs_graph::{Workgroup, stage};
use glam::UVec2;

stage! {
    /// Draws, for each live surfel, whether it goes before the next frame (GIBS, "Recycling"): with a probability from how many
    /// slots are in use, how long no pixel has seen it, how far away it is, and how crowded its place is. For those, `unseen`
    /// is [`CHOSEN`](recycling::CHOSEN).
    pub stage Recycle {
        wgsl: gibs_shaders::stages::RECYCLE,
        workgroup: [64, 1, 1],
        ports: {
            uniform camera: Camera,
            uniform frame: Frame,
            uniform grid: GridShape,
            uniform settings: SurfelSettings,
            read cells: UVec2,
            read entries: u32,
            read poses: SurfelPose,
            optional_read depths: u32,
            read counters: SurfelCounters,
            read_write unseen: u32,
        },
        cpu: kernel,
        wide: Some(wide_kernel),
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    choose(p, group, lookup::crowds);
}

fn wide_kernel(p: &Views<'_>, group: Workgroup) {
    let wide = simd::Lookup::new();
    choose(p, group, |owns, surfels| wide.crowds(owns, surfels));
}

/// Surfels of a workgroup.
const LANES: usize = 64;

#[inline(always)]
fn choose(
    p: &Views<'_>,
    group: Workgroup,
    crowds: impl Fn(&Owns<'_>, &Surfels<'_>) -> [f32; AT_A_TIME],
) {
    let surfels = Surfels {
        cells: p.cells.slice(),
        entries: p.entries.slice(),
        poses: p.poses.slice(),
        depths: Depths::new(p.depths.slice(), p.settings.depth_side),
        grid: p.grid,
        settings: p.settings,
    };
    let range = group.range(p.poses.len() as u32);
    // Most have just been seen, and look around another time: nothing takes those.
    let looks = |i: usize| {
        let pose = &p.poses[i];
        pose.radius > 0.0 && recycling::looks(mark::identity(pose.mark), p.frame.number)
    };
    let mut others = [0.0; LANES];
    lookup::at_surfels(&surfels, range.clone(), looks, |owns| {
        let crowds = crowds(owns, &surfels);
        for (own, crowd) in owns.ids.iter().flatten().zip(crowds) {
            others[own - range.start] = crowd;
        }
    });
    let used = p.counters[0].live as f32 / p.settings.capacity.max(1) as f32;
    for (i, others) in range.zip(others) {
        let pose = &p.poses[i];
        let unseen = p.unseen.get(i);
        if pose.radius > 0.0 && (looks(i) || unseen >= recycling::LEAST_PATIENCE) {
            let chance = recycling::chance(
                used,
                unseen,
                (pose.position - p.camera.eye).length() / p.grid.half,
                others / p.settings.coverage,
            );
            let random = hash::unit(hash::hash3(
                mark::identity(pose.mark),
                p.frame.number,
                p.frame.seed,
            ));
            if random < chance {
                p.unseen.set(i, recycling::CHOSEN);
            }
        }
    }
}
