//! `persistent/grid_scatter`: surfels into the lists of their cells.
use crate::data::{GridShape, SurfelPose};
use crate::shared::grid::{self, Pairs};
use crate::simd;
use gibs_graph::{Comparator, Lists, Ports, Workgroup, stage};

/// Threads write into a list in the order in which they come.
const IN_ORDER_OF_ARRIVAL: Comparator =
    Comparator::exact("indices of surfels").in_any_order_within(LISTS);

const LISTS: Lists = Lists {
    name: "lists of the cells",
    of: |ports: &Ports<'_>| {
        let lists = ports
            .get::<u32>("starts")
            .into_iter()
            .zip(ports.get::<u32>("cursors"));
        let list = |(start, count): (u32, u32)| {
            let first = 2 * start as usize;
            first..first + count as usize
        };
        lists.map(list).collect()
    },
    // The other half is for the lists with the new surfels.
    room: |entries| entries / 2,
};

stage! {
    /// Writes every live surfel into the list of each cell that it overlaps, which has as much room again behind its surfels
    /// for their bounds, in the first half of `entries`. The order within a list is that of arrival; `grid_order` makes it one
    /// that does not depend on it.
    pub stage GridScatter {
        wgsl: gibs_shaders::stages::GRID_SCATTER,
        workgroup: [64, 1, 1],
        ports: {
            uniform grid: GridShape,
            read poses: SurfelPose,
            read starts: u32,
            atomic cursors: u32,
            write entries: u32 => IN_ORDER_OF_ARRIVAL,
        },
        cpu: kernel,
        wide: Some(wide_kernel),
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    scatter::<false>(p, group);
}

fn wide_kernel(p: &Views<'_>, group: Workgroup) {
    scatter::<true>(p, group);
}

#[inline(always)]
fn scatter<const WIDE: bool>(p: &Views<'_>, group: Workgroup) {
    let surfels = group.range(p.poses.len() as u32);
    let mut pairs = Pairs::new(
        |cell| {
            p.cursors.prefetch(cell);
            simd::prefetch(p.starts.slice(), cell);
        },
        |id, cell| {
            let slot = (2 * p.starts[cell] + p.cursors.add(cell, 1)) as usize;
            if slot < p.entries.len() / 2 {
                p.entries.set(slot, id);
            }
        },
    );
    let each = |id, cell| pairs.push(id, cell);
    match WIDE {
        true => simd::overlapped_by(surfels, p.poses.slice(), p.grid, each),
        false => grid::overlapped_by(surfels, p.poses.slice(), p.grid, each),
    }
    pairs.finish();
}
