//! `filtering/spatial`: irradiance of neighbouring surfels (I8).
use crate::data::{
    Frame, GridShape, Neighbours, SurfelDepth, SurfelIrradiance, SurfelPose, SurfelSettings,
};
use crate::shared::{lookup, sharing};
use crate::simd;
use gibs_graph::{Workgroup, stage};
use glam::{UVec2, Vec3};

stage! {
    /// Asks the neighbours of each uncertain surfel for their irradiance, with the weights of the lookup: distance,
    /// normal and depth functions, of both (GIBS, "Irradiance Sharing").
    pub stage ShareIrradiance {
        wgsl: gibs_shaders::stages::SHARE_IRRADIANCE,
        workgroup: [64, 1, 1],
        ports: {
            uniform frame: Frame,
            uniform grid: GridShape,
            uniform settings: SurfelSettings,
            read cells: UVec2,
            read entries: u32,
            read poses: SurfelPose,
            read irradiance: SurfelIrradiance,
            optional_read depths: SurfelDepth,
            write neighbours: Neighbours,
        },
        cpu: kernel,
        wide: Some(wide_kernel),
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    share(p, group, |point, normal, surfels, states, each| {
        let wanted = |id: usize| states[id].samples != 0;
        lookup::neighbours(point, normal, sharing::REACH, surfels, wanted, each);
    });
}

fn wide_kernel(p: &Views<'_>, group: Workgroup) {
    let wide = simd::Lookup::new();
    share(p, group, |point, normal, surfels, states, each| {
        let wanted = |id: usize| states[id].samples != 0;
        wide.neighbours(point, normal, sharing::REACH, surfels, wanted, each);
    });
}

#[inline(always)]
fn share(
    p: &Views<'_>,
    group: Workgroup,
    neighbours: impl Fn(
        Vec3,
        Vec3,
        &lookup::Surfels<'_>,
        &[SurfelIrradiance],
        &mut dyn FnMut(usize, f32),
    ),
) {
    let surfels = lookup::Surfels {
        cells: p.cells.slice(),
        entries: p.entries.slice(),
        poses: p.poses.slice(),
        depths: p.depths.slice(),
        grid: p.grid,
        settings: p.settings,
    };
    let states = p.irradiance.slice();
    let age = |id: usize| p.frame.number.wrapping_sub(states[id].since);
    for i in group.range(p.poses.len() as u32) {
        let pose = &p.poses[i];
        let mut asked = sharing::Asked::default();
        if pose.radius > 0.0 && sharing::asks(&states[i]) {
            neighbours(
                pose.position,
                pose.normal,
                &surfels,
                states,
                &mut |id, mut weight| {
                    // A wall between the two may be known to only one of them.
                    if let Some(depth) = surfels.depths.get(i) {
                        let d = p.poses[id].position - pose.position;
                        weight *= lookup::visibility(depth, pose, d);
                    }
                    asked.add(&states[id], weight, age(id), id == i);
                },
            );
        }
        p.neighbours.set(i, asked.said());
    }
}
