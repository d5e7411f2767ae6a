//! `persistent/gather_surfels`: irradiance at the hits of rays from the surfels around them (I2).
use crate::data::{
    Gathered, GridShape, SurfacePoint, SurfelDepth, SurfelLight, SurfelPose, SurfelSettings,
};
use crate::shared::lookup::{self, Place, Surfels};
use crate::simd;
use gibs_graph::{DispatchArgs, Workgroup, stage};
use glam::UVec2;

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
    gather(p, group, |place, surfels, light| {
        lookup::gather(place, lookup::ENOUGH_AT_HITS, surfels, light)
    });
}

fn wide_kernel(p: &Views<'_>, group: Workgroup) {
    let wide = simd::Lookup::new();
    gather(p, group, |place, surfels, light| {
        wide.gather(place, lookup::ENOUGH_AT_HITS, surfels, light)
    });
}

#[inline(always)]
fn gather(
    p: &Views<'_>,
    group: Workgroup,
    gather: impl Fn(&Place<'_>, &Surfels<'_>, &[SurfelLight]) -> Gathered,
) {
    let surfels = Surfels {
        cells: p.cells.slice(),
        entries: p.entries.slice(),
        poses: p.poses.slice(),
        depths: p.depths.slice(),
        grid: p.grid,
        settings: p.settings,
    };
    let (points, light) = (p.points.slice(), p.light.slice());
    let range = group.range(p.batch.count);
    lookup::at_points(points, range, &surfels, |i, place| {
        let gathered = place.map(|place| gather(place, &surfels, light));
        p.gathered.set(i, gathered.unwrap_or_default());
    });
}
