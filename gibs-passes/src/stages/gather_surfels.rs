//! `*/gather_surfels`, `apply/lighting_apply`: irradiance at points from the surfels around them (S12).
use crate::data::{Gathered, GridShape, SurfacePoint, SurfelLight, SurfelPose, SurfelSettings};
use crate::shared::depth::Depths;
use crate::shared::lists::Surfels;
use crate::shared::lookup::{self, AT_A_TIME, Points};
use crate::simd;
use gibs_graph::{DispatchArgs, Workgroup, stage};
use glam::{UVec2, Vec3};

stage! {
    /// Finds each point's cell, takes its first N surfels and weights their irradiance by distance, normal and depth
    /// function (GIBS, "Light Apply", "Radial Gaussian Depth"). Where `pixels` is bound, they are the points to look at, and
    /// others keep what was gathered there.
    pub stage GatherSurfels {
        wgsl: gibs_shaders::stages::GATHER_SURFELS,
        workgroup: [64, 1, 1],
        ports: {
            uniform batch: DispatchArgs,
            uniform grid: GridShape,
            uniform settings: SurfelSettings,
            read points: SurfacePoint,
            read cells: UVec2,
            read entries: u32,
            read poses: SurfelPose,
            read light: SurfelLight,
            optional_read depths: u32,
            optional_read pixels: u32,
            write gathered: Gathered,
        },
        cpu: kernel,
        wide: Some(wide_kernel),
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    gather(p, group, |points, surfels, light| {
        let beyond = (surfels.settings.fallback != 0).then_some(Vec3::ZERO);
        lookup::gathers(points, f32::MAX, |_| beyond, surfels, light)
    });
}

fn wide_kernel(p: &Views<'_>, group: Workgroup) {
    let wide = simd::Lookup::new();
    gather(p, group, |points, surfels, light| {
        let beyond = (surfels.settings.fallback != 0).then_some(Vec3::ZERO);
        wide.gathers(points, f32::MAX, |_| beyond, surfels, light)
    });
}

#[inline(always)]
fn gather(
    p: &Views<'_>,
    group: Workgroup,
    gathers: impl Fn(&Points<'_>, &Surfels<'_>, &[SurfelLight]) -> [Gathered; AT_A_TIME],
) {
    let surfels = Surfels {
        cells: p.cells.slice(),
        entries: p.entries.slice(),
        poses: p.poses.slice(),
        depths: Depths::new(p.depths.slice(), p.settings.depth_side),
        grid: p.grid,
        settings: p.settings,
    };
    let (points, light) = (p.points.slice(), p.light.slice());
    let range = group.range(p.batch.count);
    let place = |i| match p.pixels.is_empty() {
        true => i,
        false => p.pixels[i] as usize,
    };
    lookup::at_points(points, range, place, |places, points| {
        let gathered = gathers(points, &surfels, light);
        for (&i, gathered) in places.iter().zip(&gathered) {
            p.gathered.set(i, *gathered);
        }
    });
}
