//! Light at a quarter of the pixels and at edges, and the rest from there (S13).
use crate::data::*;
use crate::frame::SceneInputs;
use crate::frame::trace::Batch;
use crate::shared::scan::exclusive_scan;
use crate::shared::upsample::blocks;
use crate::stages::*;
use gibs_graph::{Buffer, Dispatch, DispatchArgs, Graph};

/// Selects pixels, has `light` gather surfels at those, then between those that differ much, and interpolates between the others.
/// `light` takes what the name of its stage ends with and the indices of the pixels.
///
/// The indices of selected pixels stand one after the other, so that one stage gathers at all of them without idle
/// invocations. Room is for every pixel, since edges may be anywhere.
pub(super) fn at_half_resolution(
    g: &mut Graph,
    scene: &SceneInputs,
    points: &Buffer<SurfacePoint>,
    size: [u32; 2],
    gathered: Buffer<Gathered>,
    light: impl Fn(
        &mut Graph,
        &str,
        &Batch<'_>,
        Option<&Buffer<u32>>,
        Buffer<Gathered>,
    ) -> Buffer<Gathered>,
) -> Buffer<Gathered> {
    let pixels = points.len();
    let selected = g.transient("apply_selected", pixels);
    let selected = g
        .add::<select_pixels::SelectPixels>(
            "apply/select_pixels",
            select_pixels::Inputs {
                camera: &scene.camera,
                points,
                selected,
            },
            Dispatch::Elements(pixels),
        )
        .selected;
    let (scanned, total) = exclusive_scan(g, "apply/select_scan", &selected);
    let args = batch(g, "apply/batch", "apply_batch", &total);
    let inputs = pack_pixels::Inputs {
        selected: &selected,
        scanned: &scanned,
        pixels: g.transient("apply_selected_pixels", pixels),
    };
    let chosen = g
        .add::<pack_pixels::PackPixels>("apply/pack_pixels", inputs, Dispatch::Elements(pixels))
        .pixels;
    let gathered = light(g, "", &most(&args, pixels), Some(&chosen), gathered);
    let contrasts = g.transient("apply_contrasts", blocks(size));
    let inputs = count_contrasts::Inputs {
        camera: &scene.camera,
        points,
        selected: &selected,
        gathered: &gathered,
        contrasts,
    };
    let every_block = || Dispatch::Elements(blocks(size));
    let contrasts = g
        .add::<count_contrasts::CountContrasts>("apply/count_contrasts", inputs, every_block())
        .contrasts;
    let (contrasts_scanned, total) = exclusive_scan(g, "apply/contrasts_scan", &contrasts);
    let args = batch(g, "apply/contrasts_batch", "apply_contrasts_batch", &total);
    // The first pixel of a block is one of those that were selected.
    let room = 3 * blocks(size);
    let inputs = pack_contrasts::Inputs {
        camera: &scene.camera,
        points,
        selected: &selected,
        contrasts: &contrasts,
        scanned: &contrasts_scanned,
        pixels: g.transient("apply_contrasts_pixels", room),
    };
    let chosen = g
        .add::<pack_contrasts::PackContrasts>("apply/pack_contrasts", inputs, every_block())
        .pixels;
    let inputs = upsample::Inputs {
        camera: &scene.camera,
        points,
        selected: &selected,
        contrasts: &contrasts,
        gathered: light(g, "_contrasts", &most(&args, room), Some(&chosen), gathered),
    };
    g.add::<upsample::Upsample>("apply/upsample", inputs, Dispatch::Elements(pixels))
        .gathered
}

/// The size of a dispatch over as many elements as were counted.
fn batch(g: &mut Graph, label: &str, name: &str, count: &Buffer<u32>) -> Buffer<DispatchArgs> {
    let batch = g.transient(name, 1);
    let inputs = batch_args::Inputs { count, batch };
    g.add::<batch_args::BatchArgs>(label, inputs, Dispatch::Groups([1, 1, 1]))
        .batch
}

fn most(args: &Buffer<DispatchArgs>, most: u64) -> Batch<'_> {
    Batch {
        args,
        most,
        fixed: false,
    }
}
