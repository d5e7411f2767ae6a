//! `persistent/recycle`: which surfels give up their slots (S9).
use crate::data::{Camera, Frame, GridShape, SurfelCounters, SurfelPose, SurfelSettings};
use crate::shared::depth::Depths;
use crate::shared::lists::Surfels;
use crate::shared::lookup::{self, Place};
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
    choose(p, group, |place, surfels, seen| {
        lookup::coverage(place, surfels, seen)
    });
}

fn wide_kernel(p: &Views<'_>, group: Workgroup) {
    let wide = simd::Lookup::new();
    choose(p, group, |place, surfels, seen| {
        wide.coverage(place, surfels, seen)
    });
}

#[inline(always)]
fn choose(
    p: &Views<'_>,
    group: Workgroup,
    coverage: impl Fn(&Place<'_>, &Surfels<'_>, &mut dyn FnMut(usize)) -> f32,
) {
    let surfels = Surfels {
        cells: p.cells.slice(),
        entries: p.entries.slice(),
        poses: p.poses.slice(),
        depths: Depths::new(p.depths.slice(), p.settings.depth_side),
        grid: p.grid,
        settings: p.settings,
    };
    let used = p.counters[0].live as f32 / p.settings.capacity.max(1) as f32;
    for i in group.range(p.poses.len() as u32) {
        let pose = &p.poses[i];
        // Most have just been seen, and look around another time: nothing takes those.
        let looks = recycling::looks(mark::identity(pose.mark), p.frame.number);
        let unseen = p.unseen.get(i);
        if pose.radius > 0.0 && (looks || unseen >= recycling::LEAST_PATIENCE) {
            let others = match looks {
                true => {
                    let place = Place {
                        position: pose.position,
                        normal: pose.normal,
                        list: surfels.around(pose.position),
                    };
                    // In a long list a lookup may not visit the surfel itself.
                    let mut own = 0.0;
                    let all = coverage(&place, &surfels, &mut |id| {
                        if id == i {
                            own = lookup::PEAK;
                        }
                    });
                    all - own
                }
                false => 0.0,
            };
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
