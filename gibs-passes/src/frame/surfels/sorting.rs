//! Ray sorting (I9).
use super::Grid;
use crate::data::*;
use crate::frame::trace::Batch;
use crate::shared::scan::exclusive_scan;
use crate::shared::sorting::BINS;
use crate::stages::*;
use gibs_graph::{Buffer, Dispatch, DispatchArgs, Graph};
use glam::UVec2;

/// Rays and paths in the order of their bins.
pub(super) struct Sorted {
    pub rays: Buffer<Ray>,
    pub paths: Buffer<Path>,
    /// Where each ray went.
    pub places: Buffer<u32>,
}

/// Sorts the rays of each part among themselves: the stages of a part are named after its group. `spans` tells which rays are
/// whose.
#[allow(clippy::too_many_arguments, reason = "the ports of the stages")]
pub(super) fn sort_rays(
    g: &mut Graph,
    parts: &[(&str, Batch<'_>)],
    in_use: &Buffer<DispatchArgs>,
    grid: &Grid,
    poses: &Buffer<SurfelPose>,
    spans: &Buffer<UVec2>,
    rays: &Buffer<Ray>,
    paths: &Buffer<Path>,
) -> Sorted {
    let most = rays.len();
    let mut sorted = Sorted {
        rays: g.transient("sorted_rays", most),
        paths: g.transient("sorted_paths", most),
        places: g.transient("ray_places", most),
    };
    for (group, batch) in parts {
        let name = |of: &str| format!("{group}_ray_{of}");
        let label = |of: &str| format!("{group}/ray_sorting_{of}");
        let (bins, order) = (
            g.transient(&name("bins"), most),
            g.transient(&name("order"), most),
        );
        let (counts, cursors) = (
            g.zeroed(&name("bin_counts"), BINS.into()),
            g.zeroed(&name("bin_cursors"), BINS.into()),
        );
        let binned = g.add::<ray_bins::RayBins>(
            &label("bins"),
            ray_bins::Inputs {
                batch: batch.args,
                grid: &grid.shape,
                poses,
                spans,
                rays,
                bins,
                counts,
            },
            Dispatch::Indirect(in_use),
        );
        let (starts, _) = exclusive_scan(g, &label("scan"), &binned.counts);
        let inputs = ray_scatter::Inputs {
            batch: batch.args,
            bins: &binned.bins,
            starts: &starts,
            cursors,
            order,
        };
        let scattered =
            g.add::<ray_scatter::RayScatter>(&label("scatter"), inputs, batch.dispatch());
        let inputs = ray_order::Inputs {
            starts: &starts,
            counts: &binned.counts,
            order: scattered.order,
        };
        let bins = Dispatch::Elements(BINS.into());
        let ordered = g.add::<ray_order::RayOrder>(&label("order"), inputs, bins);
        let inputs = reorder_rays::Inputs {
            batch: batch.args,
            order: &ordered.order,
            rays,
            paths,
            sorted_rays: sorted.rays,
            sorted_paths: sorted.paths,
            places: sorted.places,
        };
        let reordered =
            g.add::<reorder_rays::ReorderRays>(&label("reorder"), inputs, batch.dispatch());
        sorted = Sorted {
            rays: reordered.sorted_rays,
            paths: reordered.sorted_paths,
            places: reordered.places,
        };
    }
    sorted
}
