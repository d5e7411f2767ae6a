//! `filtering/drift`: where surfels hold light that is no longer there (I3).
use crate::data::{Drift, SurfelIrradiance};
use crate::shared::estimator::{self, DRIFT_OF, Drifting};
use gibs_graph::{Workgroup, stage};
use glam::{UVec2, Vec2};

stage! {
    /// Share of what they know that the surfels of each cell should forget, and by how much their light has changed: by how far
    /// their short means have left their long ones together, and how far those of all surfels have (GIBS, "Integrator").
    pub stage MeasureDrift {
        wgsl: gibs_shaders::stages::MEASURE_DRIFT,
        workgroup: [64, 1, 1],
        ports: {
            read cells: UVec2,
            read entries: u32,
            read irradiance: SurfelIrradiance,
            read total: Drift,
            write forget: Vec2,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    // Most cells list no surfel.
    let of_none = estimator::to_forget(&Drift::default(), &p.total[0]);
    for i in group.range(p.cells.len() as u32) {
        let cell = p.cells[i];
        if cell.y == 0 {
            p.forget.set(i, of_none);
            continue;
        }
        let mut drift = Drift::default();
        for entry in cell.x..cell.x + cell.y.min(DRIFT_OF) {
            drift = drift.with(&p.irradiance[p.entries[entry as usize] as usize]);
        }
        p.forget.set(i, estimator::to_forget(&drift, &p.total[0]));
    }
}
