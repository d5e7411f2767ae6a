//! Birth of surfels where there are too few (S2, S4).
use super::{Grid, SurfelFrame, Surfels};
use crate::data::*;
use crate::frame::SceneInputs;
use crate::shared::scan::exclusive_scan;
use crate::stages::*;
use gibs_graph::{Buffer, Dispatch, Graph};

#[allow(clippy::too_many_arguments, reason = "the ports of the stages")]
pub(super) fn spawn_surfels(
    g: &mut Graph,
    scene: &SceneInputs,
    grid: &Grid,
    settings: &Buffer<SurfelSettings>,
    surfels: Surfels,
    frame: &SurfelFrame,
    points: &Buffer<SurfacePoint>,
    counters: Buffer<SurfelCounters>,
    free_slots: &Buffer<u32>,
) -> (Surfels, Buffer<SurfelCounters>) {
    let groups = frame
        .size
        .map(|side| side.div_ceil(gap_fill::GROUP * frame.settings.stride()));
    let per_group = (gap_fill::GROUP / frame.settings.tile_in(frame.size)).pow(2);
    let tiles = u64::from(groups[0]) * u64::from(groups[1]) * u64::from(per_group);
    let candidates = g.transient("spawn_candidates", tiles);
    let flags = g.transient("spawn_flags", tiles);
    let found = g.add::<gap_fill::GapFill>(
        "spawn/gap_fill",
        gap_fill::Inputs {
            camera: &scene.camera,
            frame: &scene.frame,
            grid: &grid.shape,
            settings,
            points,
            cells: &grid.cells,
            entries: &grid.entries,
            poses: &surfels.poses,
            depths: surfels.depths.as_ref(),
            unseen: surfels.unseen,
            candidates,
            flags,
        },
        Dispatch::Groups([groups[0], groups[1], 1]),
    );
    let (ranks, total) = exclusive_scan(g, "spawn/rank", &found.flags);
    let claims = g.transient("spawn_claims", tiles);
    let claims = g
        .add::<spawn_claim::SpawnClaim>(
            "spawn/claim",
            spawn_claim::Inputs {
                frame: &scene.frame,
                candidates: &found.candidates,
                ranks: &ranks,
                total: &total,
                counters: &counters,
                free_slots,
                claims,
            },
            Dispatch::Elements(tiles),
        )
        .claims;
    let inputs = spawn_commit::Inputs {
        settings,
        total: &total,
        counters,
    };
    let counters = g
        .add::<spawn_commit::SpawnCommit>("spawn/commit", inputs, Dispatch::Groups([1, 1, 1]))
        .counters;
    let written = g.add::<spawn::Spawn>(
        "spawn/write_to_persistent_storage",
        spawn::Inputs {
            camera: &scene.camera,
            frame: &scene.frame,
            grid: &grid.shape,
            settings,
            claims: &claims,
            points,
            transforms: &scene.transforms,
            births: surfels.births,
            poses: surfels.poses,
            irradiance: surfels.irradiance,
            depths: surfels.depths,
        },
        Dispatch::Elements(tiles),
    );
    let surfels = Surfels {
        births: written.births,
        poses: written.poses,
        irradiance: written.irradiance,
        light: surfels.light,
        depths: written.depths,
        guides: surfels.guides,
        unseen: found.unseen,
    };
    (surfels, counters)
}
