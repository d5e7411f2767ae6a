//! `persistent/grid_count`: how many surfels each cell lists.
use crate::data::{GridShape, NONE, SurfelPose};
use crate::shared::grid::{self, Pairs};
use crate::simd;
use gibs_graph::{Workgroup, stage};
use glam::UVec2;

stage! {
    /// Counts every live surfel in each cell that the box around it overlaps (S11). Where `claims` is bound, those that were
    /// claimed, on top of what the cell has.
    pub stage GridCount {
        wgsl: gibs_shaders::stages::GRID_COUNT,
        workgroup: [64, 1, 1],
        ports: {
            uniform grid: GridShape,
            read poses: SurfelPose,
            optional_read claims: UVec2,
            atomic counts: u32,
        },
        cpu: kernel,
        wide: Some(wide_kernel),
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    count::<false>(p, group);
}

fn wide_kernel(p: &Views<'_>, group: Workgroup) {
    count::<true>(p, group);
}

#[inline(always)]
fn count<const WIDE: bool>(p: &Views<'_>, group: Workgroup) {
    let claims = p.claims.slice();
    let surfels = match claims {
        [] => p.poses.len(),
        _ => claims.len(),
    };
    let counted = group.range(surfels as u32).filter_map(|i| {
        let id = claims.get(i).map_or(i, |claim| claim.x as usize);
        (id != NONE as usize).then_some(id)
    });
    let mut pairs = Pairs::new(
        |cell| p.counts.prefetch(cell),
        |_, cell| {
            p.counts.add(cell, 1);
        },
    );
    let each = |id, cell| pairs.push(id, cell);
    match WIDE {
        true => simd::overlapped_by(counted, p.poses.slice(), p.grid, each),
        false => grid::overlapped_by(counted, p.poses.slice(), p.grid, each),
    }
    pairs.finish();
}
