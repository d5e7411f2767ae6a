//! `apply/inject_insert`: new surfels into the lists of their cells.
use crate::data::{GridShape, NONE, SurfelPose};
use crate::shared::grid;
use gibs_graph::{Comparator, Lists, Ports, Workgroup, stage};
use glam::UVec2;

/// Threads write into a list in the order in which they come.
const IN_ORDER_OF_ARRIVAL: Comparator =
    Comparator::exact("indices of surfels").in_any_order_within(LISTS);

const LISTS: Lists = Lists {
    name: "new surfels of the cells",
    of: |ports: &Ports<'_>| {
        let cells = ports.get::<UVec2>("cells").into_iter();
        let new = |(list, born): (UVec2, u32)| {
            let end = list.x.wrapping_add(list.y) as usize;
            end.saturating_sub(born.min(list.y) as usize)..end
        };
        cells.zip(ports.get::<u32>("born")).map(new).collect()
    },
    room: |entries| entries,
};

stage! {
    /// Writes every claimed surfel into the list of each cell that it overlaps, from the end on, in the order of arrival;
    /// `grid_merge` makes it one that does not depend on it. `born` counts them in each cell.
    pub stage GridInsert {
        wgsl: gibs_shaders::stages::GRID_INSERT,
        workgroup: [64, 1, 1],
        ports: {
            uniform grid: GridShape,
            read poses: SurfelPose,
            read claims: UVec2,
            read cells: UVec2,
            atomic born: u32,
            write entries: u32 => IN_ORDER_OF_ARRIVAL,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    for i in group.range(p.claims.len() as u32) {
        let id = p.claims[i].x;
        if id == NONE {
            continue;
        }
        grid::overlapped(&p.poses[id as usize], p.grid, |cell| {
            let list = p.cells[cell as usize];
            // Of a dropped list there is nothing.
            if list.y > 0 {
                let before = p.born.add(cell as usize, 1);
                // There is room for those that were counted; a device may find another cell than it did then.
                if before < list.y {
                    p.entries.set((list.x + list.y - 1 - before) as usize, id);
                }
            }
        });
    }
}
