//! Debug views (F3): stages of the group `debug`, which are there where a view is asked for.
use super::{Grid, SurfelFrame, Surfels};
use crate::data::*;
use crate::frame::{DebugView, SceneInputs};
use crate::stages::*;
use gibs_graph::{Buffer, Dispatch, Graph};
use glam::UVec2;

/// What the view shows of each surfel; `None` for views that show none.
///
/// Views that [`DebugView::is_of_the_past`] are recorded before pixels reset what they see, without `ray_spans`; the
/// others once the rays of the frame are in.
pub(super) fn surfel_values(
    g: &mut Graph,
    view: DebugView,
    scene: &SceneInputs,
    settings: &Buffer<SurfelSettings>,
    surfels: &Surfels,
    ray_spans: Option<&Buffer<UVec2>>,
) -> Option<Buffer<f32>> {
    use DebugView::*;
    // What rays have brought is there once they have.
    let is_learned = match view {
        TransformId | Grid | CellHeat => return None,
        Surfels | Radius | Life | Unseen => false,
        Coverage | Variance | RayCount | DepthFunction | Guide => true,
    };
    let capacity = surfels.poses.len();
    let values = g.transient("debug_surfels", capacity);
    let found = g.add::<debug_surfels::DebugSurfels>(
        "debug/surfels",
        debug_surfels::Inputs {
            camera: &scene.camera,
            frame: &scene.frame,
            settings,
            poses: &surfels.poses,
            births: (view == Life).then_some(&surfels.births),
            irradiance: is_learned.then_some(&surfels.irradiance),
            spans: ray_spans.filter(|_| view == RayCount),
            unseen: (view == Unseen).then_some(&surfels.unseen),
            values,
        },
        Dispatch::Elements(capacity),
    );
    g.output("debug_surfels", &found.values);
    Some(found.values)
}

/// Draws the view.
#[allow(clippy::too_many_arguments, reason = "the ports of the stages")]
pub(super) fn draw(
    g: &mut Graph,
    view: DebugView,
    scene: &SceneInputs,
    frame: &SurfelFrame,
    grid: &Grid,
    settings: &Buffer<SurfelSettings>,
    surfels: &Surfels,
    values: Option<&Buffer<f32>>,
    points: &Buffer<SurfacePoint>,
) {
    use DebugView::*;
    let pixels = u64::from(frame.size[0]) * u64::from(frame.size[1]);
    let debug = g.transient("debug", pixels);
    let dispatch = Dispatch::Elements(pixels);
    let drawn = match values {
        None => {
            let inputs = debug_surface::Inputs {
                batch: &scene.pixels,
                camera: &scene.camera,
                grid: &grid.shape,
                settings,
                points,
                cells: (view == CellHeat).then_some(&grid.cells),
                debug,
            };
            g.add::<debug_surface::DebugSurface>("debug/surface", inputs, dispatch)
                .debug
        }
        Some(values) => {
            let has_depths = matches!(view, Coverage | RayCount | DepthFunction);
            let inputs = debug_discs::Inputs {
                batch: &scene.pixels,
                camera: &scene.camera,
                grid: &grid.shape,
                settings,
                points,
                cells: &grid.cells,
                entries: &grid.entries,
                poses: &surfels.poses,
                values,
                depths: surfels.depths.as_ref().filter(|_| has_depths),
                guides: surfels.guides.as_ref().filter(|_| view == Guide),
                debug,
            };
            g.add::<debug_discs::DebugDiscs>("debug/discs", inputs, dispatch)
                .debug
        }
    };
    g.output("debug", &drawn);
}
