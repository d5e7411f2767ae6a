//! Filtering of the surfels: over their neighbours (I8) and over time (I3).
use super::{Grid, Surfels};
use crate::data::*;
use crate::frame::{SceneInputs, Settings};
use crate::stages::*;
use gibs_graph::{Buffer, Dispatch, Graph};
use glam::Vec4;

/// What the rays brought into the surfels' irradiance. `offsets` and `radiance` are of the rays.
#[allow(clippy::too_many_arguments, reason = "the ports of the stages")]
pub(super) fn filter(
    g: &mut Graph,
    scene: &SceneInputs,
    grid: &Grid,
    device_settings: &Buffer<SurfelSettings>,
    surfels: Surfels,
    settings: &Settings,
    offsets: &Buffer<u32>,
    radiance: &Buffer<Vec4>,
) -> Surfels {
    let capacity = surfels.poses.len();
    let neighbours = settings.sharing.then(|| {
        let neighbours = g.transient("neighbours", capacity);
        let inputs = share_irradiance::Inputs {
            frame: &scene.frame,
            grid: &grid.shape,
            settings: device_settings,
            cells: &grid.cells,
            entries: &grid.entries,
            poses: &surfels.poses,
            births: &surfels.births,
            irradiance: &surfels.irradiance,
            depths: surfels.depths.as_ref(),
            neighbours,
        };
        g.add::<share_irradiance::ShareIrradiance>(
            "filtering/spatial",
            inputs,
            Dispatch::Elements(capacity),
        )
        .neighbours
    });
    let integrated = g.add::<integrate::Integrate>(
        "filtering/temporal",
        integrate::Inputs {
            frame: &scene.frame,
            settings: device_settings,
            poses: &surfels.poses,
            births: &surfels.births,
            offsets,
            radiance,
            neighbours: neighbours.as_ref(),
            irradiance: surfels.irradiance,
            light: surfels.light,
        },
        Dispatch::Elements(capacity),
    );
    Surfels {
        irradiance: integrated.irradiance,
        light: integrated.light,
        ..surfels
    }
}
