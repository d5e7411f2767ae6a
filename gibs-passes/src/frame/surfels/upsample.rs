//! Light at a quarter of the pixels and at edges, and the rest from there (S13).
use crate::data::*;
use crate::frame::SceneInputs;
use crate::frame::trace::Batch;
use crate::shared::scan::exclusive_scan;
use crate::shared::upsample::blocks;
use crate::stages::*;
use gibs_graph::{Buffer, Dispatch, Graph, Initial};

/// Selects pixels, has `light` gather surfels at those, and interpolates between them.
///
/// Selected pixels are packed, so that one stage gathers at all of them without idle invocations. Room is for every
/// pixel, since edges may be anywhere. Where light differs much between pixels is known once it is gathered, and so in the
/// next frame.
pub(super) fn at_half_resolution(
    g: &mut Graph,
    scene: &SceneInputs,
    points: &Buffer<SurfacePoint>,
    size: [u32; 2],
    light: impl FnOnce(&mut Graph, &Batch<'_>, &Buffer<SurfacePoint>) -> Buffer<Gathered>,
) -> Buffer<Gathered> {
    let pixels = points.len();
    let (state, contrasts) = g.state("apply_contrasts", blocks(size), Initial::Zero);
    let selected = g.transient("apply_selected", pixels);
    let selected = g
        .add::<select_pixels::SelectPixels>(
            "apply/select_pixels",
            select_pixels::Inputs {
                camera: &scene.camera,
                points,
                contrasts: &contrasts,
                selected,
            },
            Dispatch::Elements(pixels),
        )
        .selected;
    let (scanned, total) = exclusive_scan(g, "apply/select_scan", &selected);
    let args = g.transient("apply_batch", 1);
    let inputs = batch_args::Inputs {
        count: &total,
        batch: args,
    };
    let args = g
        .add::<batch_args::BatchArgs>("apply/batch", inputs, Dispatch::Groups([1, 1, 1]))
        .batch;
    let packed = g.transient("apply_packed_points", pixels);
    let inputs = pack_points::Inputs {
        points,
        selected: &selected,
        scanned: &scanned,
        packed,
    };
    let packed = g
        .add::<pack_points::PackPoints>("apply/pack_points", inputs, Dispatch::Elements(pixels))
        .packed;
    let batch = Batch {
        args: &args,
        most: pixels,
        fixed: false,
    };
    let packed_gathered = light(g, &batch, &packed);
    let gathered = g.transient("apply_gathered", pixels);
    let inputs = upsample::Inputs {
        camera: &scene.camera,
        points,
        selected: &selected,
        scanned: &scanned,
        packed: &packed_gathered,
        gathered,
        contrasts,
    };
    let upsampled =
        g.add::<upsample::Upsample>("apply/upsample", inputs, Dispatch::Elements(pixels));
    g.keep(state, upsampled.contrasts);
    upsampled.gathered
}
