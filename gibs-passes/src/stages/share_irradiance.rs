//! `filtering/spatial`: irradiance of neighbouring surfels (I8).
use crate::data::{
    Frame, GridShape, Neighbours, SurfelIrradiance, SurfelLight, SurfelPose, SurfelSettings,
};
use crate::shared::depth::Depths;
use crate::shared::lists::{List, Surfels};
use crate::shared::lookup;
use crate::shared::{grid, sharing};
use crate::simd;
use gibs_graph::{Workgroup, stage};
use glam::{UVec2, Vec2};

stage! {
    /// Asks the neighbours of each uncertain surfel whose turn it is for their irradiance, by how near they are, with the
    /// normal and depth factors of the lookup, of both (GIBS, "Irradiance Sharing"), and finds what it says then: its own
    /// mean, and what they know better.
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
            optional_read depths: u32,
            read forget: Vec2,
            read_write neighbours: Neighbours,
            write light: SurfelLight,
        },
        cpu: kernel,
        wide: Some(wide_kernel),
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    share(p, group, |own, list, surfels, states, each| {
        let wanted = |id: usize| states[id].samples != 0;
        lookup::neighbours(own, list, sharing::REACH, surfels, wanted, each);
    });
}

fn wide_kernel(p: &Views<'_>, group: Workgroup) {
    let wide = simd::Lookup::new();
    share(p, group, |own, list, surfels, states, each| {
        let wanted = |id: usize| states[id].samples != 0;
        wide.neighbours(own, list, sharing::REACH, surfels, wanted, each);
    });
}

/// Surfels of a workgroup.
const LANES: usize = 64;

#[inline(always)]
fn share(
    p: &Views<'_>,
    group: Workgroup,
    neighbours: impl Fn(usize, List<'_>, &Surfels<'_>, &[SurfelIrradiance], &mut dyn FnMut(usize, f32)),
) {
    let surfels = Surfels {
        cells: p.cells.slice(),
        entries: p.entries.slice(),
        poses: p.poses.slice(),
        depths: Depths::new(p.depths.slice(), p.settings.depth_side),
        grid: p.grid,
        settings: p.settings,
    };
    let states = p.irradiance.slice();
    let age = |id: usize| p.frame.number.wrapping_sub(states[id].since);
    let range = group.range(p.poses.len() as u32);
    let number = p.frame.number;
    let is_due = |i: usize| {
        let pose = &p.poses[i];
        let share = || p.forget[grid::cell(pose.position, p.grid) as usize].x;
        pose.radius > 0.0 && sharing::is_due(i as u32, &states[i], share, number)
    };
    let asks = |i: usize| sharing::asks(&states[i]);
    let due: [bool; LANES] = std::array::from_fn(|lane| {
        let i = range.start + lane;
        i < range.end && is_due(i)
    });
    let lists: [_; LANES] = surfels.lists(|lane| {
        let i = range.start + lane;
        (due[lane] && asks(i)).then(|| p.poses[i].position)
    });
    for ((own, list), due) in range.clone().zip(lists).zip(due) {
        if p.poses[own].radius <= 0.0 {
            continue;
        }
        let mut asked = sharing::Asked::default();
        if due && asks(own) {
            neighbours(own, list, &surfels, states, &mut |id, weight| {
                asked.add(&states[id], weight, age(id), id == own);
            });
        }
        if due {
            p.neighbours.set(own, asked.said().pack());
        }
        let said = sharing::Said::unpack(&p.neighbours.get(own));
        if said.trust > 0.0 {
            let light = sharing::light(&states[own], age(own), &said);
            p.light.set(own, light);
        }
    }
}
