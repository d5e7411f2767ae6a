//! Filtering of the surfels: over time (I3) and over their neighbours (I8).
use super::{Grid, Surfels};
use crate::data::*;
use crate::frame::{SceneInputs, Settings};
use crate::stages::*;
use gibs_graph::{Buffer, Dispatch, DispatchArgs, Graph, Initial};
use glam::{UVec2, Vec2, Vec4};

/// What the rays brought into the surfels' irradiance. `spans` and `radiance` are of the rays.
#[allow(clippy::too_many_arguments, reason = "the ports of the stages")]
pub(super) fn filter(
    g: &mut Graph,
    scene: &SceneInputs,
    grid: &Grid,
    device_settings: &Buffer<SurfelSettings>,
    surfels: Surfels,
    in_use: &Buffer<DispatchArgs>,
    settings: &Settings,
    spans: &Buffer<UVec2>,
    radiance: &Buffer<Vec4>,
) -> Surfels {
    let capacity = surfels.poses.len();
    let forget = forget(g, grid, &surfels.poses, &surfels.irradiance);
    let clamped = settings.clamp.then(|| g.zeroed("clamped_light", capacity));
    let integrated = g.add::<integrate::Integrate>(
        "filtering/temporal",
        integrate::Inputs {
            frame: &scene.frame,
            grid: &grid.shape,
            settings: device_settings,
            poses: &surfels.poses,
            spans,
            radiance,
            forget: &forget,
            irradiance: surfels.irradiance,
            light: surfels.light,
            neighbours: surfels.neighbours,
            clamped,
        },
        Dispatch::Indirect(in_use),
    );
    if let Some(clamped) = &integrated.clamped {
        let (state, total) = g.state("surfel_clamped", 1, Initial::Zero);
        let inputs = sum_clamped::Inputs { clamped, total };
        let one = Dispatch::Groups([1, 1, 1]);
        let summed = g.add::<sum_clamped::SumClamped>("filtering/clamped", inputs, one);
        g.output("clamped", &summed.total);
        g.keep(state, summed.total);
    }
    let (mut light, mut neighbours) = (integrated.light, None);
    if let Some(said) = integrated.neighbours {
        let inputs = share_irradiance::Inputs {
            frame: &scene.frame,
            grid: &grid.shape,
            settings: device_settings,
            cells: &grid.cells,
            entries: &grid.entries,
            poses: &surfels.poses,
            irradiance: &integrated.irradiance,
            depths: surfels.depths.as_ref(),
            neighbours: said,
            light,
        };
        let all = Dispatch::Indirect(in_use);
        let shared = g.add::<share_irradiance::ShareIrradiance>("filtering/spatial", inputs, all);
        (light, neighbours) = (shared.light, Some(shared.neighbours));
    }
    Surfels {
        irradiance: integrated.irradiance,
        light,
        neighbours,
        ..surfels
    }
}

/// Share of what they know that the surfels of each cell should forget, and by how much their light has changed.
fn forget(
    g: &mut Graph,
    grid: &Grid,
    poses: &Buffer<SurfelPose>,
    irradiance: &Buffer<SurfelIrradiance>,
) -> Buffer<Vec2> {
    let capacity = poses.len();
    let blocks = g.transient(
        "drift_blocks",
        capacity.div_ceil(drift_blocks::BLOCK as u64),
    );
    let inputs = drift_blocks::Inputs {
        poses,
        irradiance,
        blocks,
    };
    let all = Dispatch::Elements(capacity);
    let blocks = g
        .add::<drift_blocks::DriftBlocks>("filtering/drift_blocks", inputs, all)
        .blocks;
    let total = g.transient("drift_total", 1);
    let inputs = drift_total::Inputs {
        blocks: &blocks,
        total,
    };
    let one = Dispatch::Groups([1, 1, 1]);
    let total = g
        .add::<drift_total::DriftTotal>("filtering/drift_total", inputs, one)
        .total;
    let forget = g.transient("forget", grid.cells.len());
    let inputs = measure_drift::Inputs {
        cells: &grid.cells,
        entries: &grid.entries,
        irradiance,
        total: &total,
        forget,
    };
    let cells = Dispatch::Elements(grid.cells.len());
    g.add::<measure_drift::MeasureDrift>("filtering/drift", inputs, cells)
        .forget
}
