//! Ray sorting (I9), and the trace of what it sorts.
use super::{Grid, Surfels};
use crate::data::*;
use crate::frame::SceneInputs;
use crate::frame::trace::{Batch, trace};
use crate::shared::scan::exclusive_scan;
use crate::shared::sorting::BINS;
use crate::stages::*;
use gibs_graph::{Buffer, Dispatch, DispatchArgs, Graph};

/// How rays were sorted: those of surfels that were there before lie in front of those of new ones.
pub(super) struct Sorted {
    /// Where each ray went.
    pub places: Buffer<u32>,
    persistent: Buffer<DispatchArgs>,
    spawned: Buffer<DispatchArgs>,
}

/// Rays and paths in the order of their bins. `offsets` tells which are whose.
#[allow(clippy::too_many_arguments, reason = "the ports of the stages")]
pub(super) fn sort_rays(
    g: &mut Graph,
    scene: &SceneInputs,
    grid: &Grid,
    surfels: &Surfels,
    offsets: &Buffer<u32>,
    batch: &Batch<'_>,
    rays: &Buffer<Ray>,
    paths: &Buffer<Path>,
) -> (Buffer<Ray>, Buffer<Path>, Sorted) {
    let capacity = surfels.poses.len();
    let two_halves = u64::from(2 * BINS);
    let bins = g.transient("ray_bins", batch.most);
    let counts = g.zeroed("ray_bin_counts", two_halves);
    let binned = g.add::<ray_bins::RayBins>(
        "persistent/ray_sorting_bins",
        ray_bins::Inputs {
            frame: &scene.frame,
            grid: &grid.shape,
            poses: &surfels.poses,
            births: &surfels.births,
            offsets,
            rays,
            bins,
            counts,
        },
        Dispatch::Elements(capacity),
    );
    let (starts, _) = exclusive_scan(g, "persistent/ray_sorting_scan", &binned.counts);
    let cursors = g.zeroed("ray_bin_cursors", two_halves);
    let order = g.transient("ray_order", batch.most);
    let inputs = ray_scatter::Inputs {
        batch: batch.args,
        bins: &binned.bins,
        starts: &starts,
        cursors,
        order,
    };
    let label = "persistent/ray_sorting_scatter";
    let scattered = g.add::<ray_scatter::RayScatter>(label, inputs, batch.dispatch());
    let (persistent, spawned) = (
        g.transient("persistent_batch", 1),
        g.transient("spawned_batch", 1),
    );
    let ordered = g.add::<ray_order::RayOrder>(
        "persistent/ray_sorting_order",
        ray_order::Inputs {
            batch: batch.args,
            starts: &starts,
            counts: &binned.counts,
            order: scattered.order,
            persistent,
            spawned,
        },
        Dispatch::Elements(two_halves),
    );
    let (sorted_rays, sorted_paths, places) = (
        g.transient("sorted_rays", batch.most),
        g.transient("sorted_paths", batch.most),
        g.transient("ray_places", batch.most),
    );
    let sorted = g.add::<reorder_rays::ReorderRays>(
        "persistent/ray_sorting_reorder",
        reorder_rays::Inputs {
            batch: batch.args,
            order: &ordered.order,
            rays,
            paths,
            sorted_rays,
            sorted_paths,
            places,
        },
        batch.dispatch(),
    );
    let how = Sorted {
        places: sorted.places,
        persistent: ordered.persistent,
        spawned: ordered.spawned,
    };
    (sorted.sorted_rays, sorted.sorted_paths, how)
}

impl Sorted {
    /// The closest hit of each ray: `persistent/ray_trace`, and `spawn/ray_trace` for those of new surfels.
    pub fn trace(&self, g: &mut Graph, scene: &SceneInputs, rays: &Buffer<Ray>) -> Buffer<Hit> {
        let most = rays.len();
        let mut hits = g.transient("persistent_hits", most);
        let parts = [
            ("persistent/ray_trace", &self.persistent),
            ("spawn/ray_trace", &self.spawned),
        ];
        for (label, args) in parts {
            let batch = Batch::on_device(args, most);
            hits = trace(g, label, scene, &batch, rays, hits);
        }
        hits
    }
}
