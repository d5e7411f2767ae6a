//! `persistent/gather_surfels`: irradiance at the hits of rays from the surfels around them (I2).
use crate::data::{
    Gathered, GridShape, SurfacePoint, SurfelDepth, SurfelLight, SurfelPose, SurfelSettings,
};
use crate::shared::{lookup, octahedral, surface};
use crate::simd;
use gibs_graph::{DispatchArgs, Workgroup, stage};
use glam::{UVec2, Vec3};

stage! {
    /// As [`GatherSurfels`](super::gather_surfels::GatherSurfels), with as many surfels as are enough for the light of a ray
    /// ("we evaluate the existing surfel lighting at those locations").
    pub stage GatherAtHits {
        wgsl: gibs_shaders::stages::GATHER_AT_HITS,
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
            optional_read depths: SurfelDepth,
            write gathered: Gathered,
        },
        cpu: kernel,
        wide: Some(wide_kernel),
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    gather(p, group, |point, normal, surfels, light| {
        lookup::gather(point, normal, lookup::ENOUGH_AT_HITS, surfels, light)
    });
}

fn wide_kernel(p: &Views<'_>, group: Workgroup) {
    let wide = simd::Lookup::new();
    gather(p, group, |point, normal, surfels, light| {
        wide.gather(point, normal, lookup::ENOUGH_AT_HITS, surfels, light)
    });
}

#[inline(always)]
fn gather(
    p: &Views<'_>,
    group: Workgroup,
    gather: impl Fn(Vec3, Vec3, &lookup::Surfels<'_>, &[SurfelLight]) -> Gathered,
) {
    let surfels = lookup::Surfels {
        cells: p.cells.slice(),
        entries: p.entries.slice(),
        poses: p.poses.slice(),
        depths: p.depths.slice(),
        grid: p.grid,
        settings: p.settings,
    };
    let light = p.light.slice();
    for i in group.range(p.batch.count) {
        let point = &p.points[i];
        let gathered = if surface::is_surface(point) {
            let normal = octahedral::unpack(point.shading_normal);
            gather(point.position, normal, &surfels, light)
        } else {
            Gathered::default()
        };
        p.gathered.set(i, gathered);
    }
}
