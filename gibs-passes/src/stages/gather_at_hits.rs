//! `persistent/gather_surfels`: irradiance at the hits of rays from the surfels around them (I2).
use crate::data::{
    Gathered, GridShape, Path, SurfacePoint, SurfelLight, SurfelPose, SurfelSettings,
};
use crate::shared::depth::Depths;
use crate::shared::lists::Surfels;
use crate::shared::lookup::{self, AT_A_TIME, Points};
use crate::simd;
use gibs_graph::{DispatchArgs, Workgroup, stage};
use glam::{UVec2, Vec3};

stage! {
    /// As [`GatherSurfels`](super::gather_surfels::GatherSurfels), with as many surfels as are enough for the light of a ray
    /// ("we evaluate the existing surfel lighting at those locations"). Where `paths` is bound, they end here: the cell's average is
    /// found, and what that lacks is filled up with the irradiance of the surfel that the path began at, as if light were
    /// the same here and there. In a closed room of one colour that is so.
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
            optional_read depths: u32,
            optional_read paths: Path,
            write gathered: Gathered,
        },
        cpu: kernel,
        wide: Some(wide_kernel),
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    gather(p, group, |points, beyond, surfels, light| {
        lookup::gathers(points, lookup::ENOUGH_AT_HITS, beyond, surfels, light)
    });
}

fn wide_kernel(p: &Views<'_>, group: Workgroup) {
    let wide = simd::Lookup::new();
    gather(p, group, |points, beyond, surfels, light| {
        wide.gathers(points, lookup::ENOUGH_AT_HITS, beyond, surfels, light)
    });
}

#[inline(always)]
fn gather(
    p: &Views<'_>,
    group: Workgroup,
    gathers: impl Fn(
        &Points<'_>,
        &dyn Fn(usize) -> Option<Vec3>,
        &Surfels<'_>,
        &[SurfelLight],
    ) -> [Gathered; AT_A_TIME],
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
    let fallback = p.settings.fallback != 0;
    let beyond = |i: usize| {
        let of = p.paths.get(i).filter(|_| fallback)?;
        let light = light[of.surfel as usize];
        Some(match light.trust > 0.0 {
            true => light.irradiance,
            false => Vec3::ZERO,
        })
    };
    lookup::at_points(
        points,
        range,
        |i| i,
        |places, points| {
            let gathered = gathers(points, &|i| beyond(places[i]), &surfels, light);
            for (&i, gathered) in places.iter().zip(&gathered) {
                p.gathered.set(i, *gathered);
            }
        },
    );
}
