//! Birth of surfels where there are too few (S2, S4).
use super::{Grid, SurfelFrame, Surfels};
use crate::data::*;
use crate::frame::SceneInputs;
use crate::shared::scan::exclusive_scan;
use crate::stages::*;
use gibs_graph::{Buffer, Dispatch, Graph};
use glam::UVec2;

#[allow(clippy::too_many_arguments, reason = "the ports of the stages")]
pub(super) fn spawn_surfels(
    g: &mut Graph,
    scene: &SceneInputs,
    grid: &Grid,
    settings: &Buffer<SurfelSettings>,
    surfels: Surfels,
    frame: &SurfelFrame,
    points: &Buffer<SurfacePoint>,
    counts: Counts,
    free_slots: &Buffer<u32>,
) -> (Surfels, Counts, Buffer<UVec2>) {
    let groups = frame
        .size
        .map(|side| side.div_ceil(gap_fill::GROUP * frame.settings.stride()));
    let per_group = (2 * gap_fill::GROUP / frame.settings.tile_in(frame.size)).pow(2);
    let quarters = u64::from(groups[0]) * u64::from(groups[1]) * u64::from(per_group);
    let candidates = g.transient("spawn_candidates", quarters);
    let flags = g.transient("spawn_flags", quarters);
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
    let surfels = Surfels {
        unseen: found.unseen,
        ..surfels
    };
    let wanted = Wanted {
        candidates: found.candidates,
        flags: found.flags,
    };
    bear(
        g, scene, grid, settings, surfels, "spawn", &wanted, points, counts, free_slots,
    )
}

/// What is counted of the slots and of births.
pub(super) struct Counts {
    pub counters: Buffer<SurfelCounters>,
    /// Holes in crowded cells, in which no surfel was born.
    pub crowded: Buffer<u32>,
}

/// Where surfels are to be born.
pub(super) struct Wanted {
    pub candidates: Buffer<u32>,
    pub flags: Buffer<u32>,
}

/// Takes slots for the surfels that are wanted, as far as there are any, and writes them. Gives the claims as well.
#[allow(clippy::too_many_arguments, reason = "the ports of the stages")]
pub(super) fn bear(
    g: &mut Graph,
    scene: &SceneInputs,
    grid: &Grid,
    settings: &Buffer<SurfelSettings>,
    surfels: Surfels,
    label: &str,
    wanted: &Wanted,
    points: &Buffer<SurfacePoint>,
    counts: Counts,
    free_slots: &Buffer<u32>,
) -> (Surfels, Counts, Buffer<UVec2>) {
    let places = wanted.flags.len();
    let (ranks, total) = exclusive_scan(g, &format!("{label}/rank"), &wanted.flags);
    let claims = g.transient(&format!("{label}_claims"), places);
    let Counts { counters, crowded } = counts;
    let claimed = g.add::<spawn_claim::SpawnClaim>(
        &format!("{label}/claim"),
        spawn_claim::Inputs {
            frame: &scene.frame,
            settings,
            candidates: &wanted.candidates,
            ranks: &ranks,
            total: &total,
            counters: &counters,
            free_slots,
            claims,
            crowded,
        },
        Dispatch::Elements(places),
    );
    let (claims, crowded) = (claimed.claims, claimed.crowded);
    let inputs = spawn_commit::Inputs {
        settings,
        total: &total,
        counters,
    };
    let counters = g
        .add::<spawn_commit::SpawnCommit>(
            &format!("{label}/commit"),
            inputs,
            Dispatch::Groups([1, 1, 1]),
        )
        .counters;
    let written = g.add::<spawn::Spawn>(
        &format!("{label}/write_to_persistent_storage"),
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
        Dispatch::Elements(places),
    );
    let surfels = Surfels {
        births: written.births,
        poses: written.poses,
        irradiance: written.irradiance,
        depths: written.depths,
        ..surfels
    };
    (surfels, Counts { counters, crowded }, claims)
}
