//! `filtering/spatial`: irradiance of neighbouring surfels (I8).
use crate::data::{
    Frame, GridShape, Neighbours, SurfelIrradiance, SurfelLight, SurfelPose, SurfelSettings,
};
use crate::shared::depth::Depths;
use crate::shared::lists::Surfels;
use crate::shared::lookup::{self, Owns};
use crate::shared::sharing;
use crate::simd;
use gibs_graph::{Workgroup, stage};
use glam::UVec2;

stage! {
    /// Asks the neighbours of each uncertain surfel that is to do so, see [`Integrate`](super::integrate::Integrate), for their
    /// irradiance, by how near they are, with the normal and depth factors of the lookup, of both (GIBS, "Irradiance Sharing"),
    /// and finds what it says then: its own mean, and what they know better.
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
            read_write neighbours: Neighbours,
            write light: SurfelLight,
        },
        cpu: kernel,
        wide: Some(wide_kernel),
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    share(p, group, |owns, surfels, states, each| {
        let wanted = |id: usize| states[id].samples != 0;
        lookup::neighbours::<{ sharing::REACH }>(owns, surfels, wanted, each);
    });
}

fn wide_kernel(p: &Views<'_>, group: Workgroup) {
    let wide = simd::Lookup::new();
    share(p, group, |owns, surfels, states, each| {
        let wanted = |id: usize| states[id].samples != 0;
        let soon = |id| simd::prefetch(states, id);
        wide.neighbours::<{ sharing::REACH }>(owns, surfels, soon, wanted, each);
    });
}

/// Surfels of a workgroup.
const LANES: usize = 64;

#[inline(always)]
fn share(
    p: &Views<'_>,
    group: Workgroup,
    neighbours: impl Fn(&Owns<'_>, &Surfels<'_>, &[SurfelIrradiance], &mut dyn FnMut(usize, usize, f32)),
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
    let is_due = |i: usize| p.neighbours.get(i).packed == sharing::ASKS.packed;
    let asks = |i: usize| is_due(i) && sharing::asks(&states[i]);
    let mut asked = [sharing::Asked::default(); LANES];
    lookup::at_surfels(&surfels, range.clone(), asks, |owns| {
        neighbours(owns, &surfels, states, &mut |at, id, weight| {
            let Some(own) = owns.ids[at] else { return };
            asked[own - range.start].add(&states[id], weight, age(id), id == own);
        });
    });
    for (own, asked) in range.zip(&asked) {
        if !is_due(own) {
            continue;
        }
        let told = asked.said().pack();
        p.neighbours.set(own, told);
        let said = sharing::Said::unpack(&told);
        let light = sharing::light(&states[own], age(own), &said);
        p.light.set(own, light);
    }
}
