//! The surfel frame, in the order of the talk's frame overview.
use super::trace::{Batch, direct_light, gbuffer, surfaces};
use super::{SceneInputs, SceneSizes, Settings};
use crate::data::*;
use crate::shared::grid::GridLayout;
use crate::shared::scan::exclusive_scan;
use crate::stages::*;
use gibs_graph::{Buffer, Dispatch, DispatchArgs, Graph, Initial, State};
use glam::UVec2;

/// What a surfel frame is made for.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfelFrame {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Shape of the grid, see [`Settings::grid`].
    pub grid: GridLayout,
    /// Settings.
    pub settings: Settings,
}

/// The surfels: one handle per field, so that unrelated stages stay independent.
struct Surfels {
    births: Buffer<SurfelBirth>,
    poses: Buffer<SurfelPose>,
    irradiance: Buffer<SurfelIrradiance>,
    depths: Buffer<SurfelDepth>,
}

/// Their states, which wait for the last versions.
struct SurfelStates {
    births: State<SurfelBirth>,
    poses: State<SurfelPose>,
    irradiance: State<SurfelIrradiance>,
    depths: State<SurfelDepth>,
}

impl Surfels {
    fn declare(g: &mut Graph, capacity: u64) -> (SurfelStates, Self) {
        let (births_state, births) = g.state("surfel_births", capacity, Initial::Zero);
        let (poses_state, poses) = g.state("surfel_poses", capacity, Initial::Zero);
        let (irradiance_state, irradiance) = g.state("surfel_irradiance", capacity, Initial::Zero);
        let (depths_state, depths) = g.state("surfel_depths", capacity, Initial::Zero);
        (
            SurfelStates {
                births: births_state,
                poses: poses_state,
                irradiance: irradiance_state,
                depths: depths_state,
            },
            Self {
                births,
                poses,
                irradiance,
                depths,
            },
        )
    }

    fn keep(self, g: &mut Graph, states: SurfelStates) {
        g.keep(states.births, self.births);
        g.keep(states.poses, self.poses);
        g.keep(states.irradiance, self.irradiance);
        g.keep(states.depths, self.depths);
    }
}

/// The lists of the grid's cells.
struct Grid {
    shape: Buffer<GridShape>,
    cells: Buffer<UVec2>,
    entries: Buffer<u32>,
}

/// Records the frame. Its outputs are `points`, `direct`, `irradiance`, `color`, `counters` and `overflow`.
pub fn surfel_frame(g: &mut Graph, frame: &SurfelFrame, sizes: &SceneSizes) {
    let settings = &frame.settings;
    let scene = SceneInputs::declare(g, sizes);
    let device_settings: Buffer<SurfelSettings> = g.input("settings", 1);
    let shape = g.input("grid", 1);
    let capacity = u64::from(settings.surfels);
    let per_point = settings.lights_per_point(sizes.lights());
    let (states, surfels) = Surfels::declare(g, capacity);
    let counters = g.state(
        "surfel_counters",
        1,
        Initial::fill(SurfelCounters {
            free: settings.surfels,
            ..Default::default()
        }),
    );
    let free_slots = g.state("surfel_free_slots", capacity, Initial::Sequence);

    let pixels = u64::from(frame.size[0]) * u64::from(frame.size[1]);
    let pixel_batch = Batch {
        args: &scene.pixels,
        most: pixels,
        fixed: true,
    };
    let (rays, points) = gbuffer(g, &scene, &pixel_batch);

    // Persistent
    let surfels = update_positions(g, &scene, &shape, &device_settings, surfels, capacity);
    let (grid, overflow) = build_grid(g, shape, &surfels, frame, capacity);
    let surfels = integrate_rays(
        g,
        &scene,
        &grid,
        &device_settings,
        surfels,
        settings,
        per_point,
    );

    // Spawn
    let (surfels, counters_last) = spawn_surfels(
        g,
        &scene,
        &grid,
        &device_settings,
        surfels,
        frame,
        &points,
        counters.1,
        &free_slots.1,
    );

    // Apply
    let direct = direct_light(g, "apply", "", &scene, per_point, &pixel_batch, &points);
    let gathered = gather(
        g,
        "apply/lighting_apply",
        &scene.frame,
        &grid,
        &device_settings,
        &surfels,
        &pixel_batch,
        &points,
        "apply_gathered",
    );
    let irradiance = g.transient("irradiance", pixels);
    let color = g.transient("color", pixels);
    let composed = g.add::<compose::Compose>(
        "apply/compose",
        compose::Inputs {
            batch: &scene.pixels,
            frame: &scene.frame,
            rays: &rays,
            points: &points,
            direct: &direct,
            gathered: &gathered,
            environment: &scene.environment,
            irradiance,
            color,
        },
        pixel_batch.dispatch(),
    );
    g.output("points", &points);
    g.output("direct", &direct);
    g.output("irradiance", &composed.irradiance);
    g.output("color", &composed.color);
    g.output("counters", &counters_last);
    g.output("overflow", &overflow);
    surfels.keep(g, states);
    g.keep(counters.0, counters_last);
    g.keep(free_slots.0, free_slots.1);
}

fn update_positions(
    g: &mut Graph,
    scene: &SceneInputs,
    shape: &Buffer<GridShape>,
    settings: &Buffer<SurfelSettings>,
    surfels: Surfels,
    capacity: u64,
) -> Surfels {
    let moved = g.add::<positional_update::PositionalUpdate>(
        "persistent/positional_update",
        positional_update::Inputs {
            camera: &scene.camera,
            grid: shape,
            settings,
            births: &surfels.births,
            transforms: &scene.transforms,
            poses: surfels.poses,
        },
        Dispatch::Elements(capacity),
    );
    Surfels {
        poses: moved.poses,
        ..surfels
    }
}

fn build_grid(
    g: &mut Graph,
    shape: Buffer<GridShape>,
    surfels: &Surfels,
    frame: &SurfelFrame,
    capacity: u64,
) -> (Grid, Buffer<u32>) {
    let cells = u64::from(frame.grid.cells());
    let counts = g.zeroed("grid_counts", cells);
    let inputs = grid_count::Inputs {
        grid: &shape,
        poses: &surfels.poses,
        counts,
    };
    let counts = g
        .add::<grid_count::GridCount>(
            "persistent/grid_count",
            inputs,
            Dispatch::Elements(capacity),
        )
        .counts;
    let (starts, _) = exclusive_scan(g, "persistent/grid_scan", &counts);
    let cursors = g.zeroed("grid_cursors", cells);
    let entries = g.transient(
        "grid_entries",
        capacity * u64::from(frame.settings.grid_lists),
    );
    let inputs = grid_scatter::Inputs {
        grid: &shape,
        poses: &surfels.poses,
        starts: &starts,
        cursors,
        entries,
    };
    let scattered = g.add::<grid_scatter::GridScatter>(
        "persistent/grid_scatter",
        inputs,
        Dispatch::Elements(capacity),
    );
    let listed = g.transient("grid_cells", cells);
    let overflow = g.zeroed("grid_overflow", 1);
    let ordered = g.add::<grid_order::GridOrder>(
        "persistent/grid_order",
        grid_order::Inputs {
            poses: &surfels.poses,
            starts: &starts,
            counts: &counts,
            entries: scattered.entries,
            cells: listed,
            overflow,
        },
        Dispatch::Elements(cells),
    );
    (
        Grid {
            shape,
            cells: ordered.cells,
            entries: ordered.entries,
        },
        ordered.overflow,
    )
}

#[allow(clippy::too_many_arguments, reason = "the ports of the stage")]
fn gather(
    g: &mut Graph,
    label: &str,
    frame: &Buffer<Frame>,
    grid: &Grid,
    settings: &Buffer<SurfelSettings>,
    surfels: &Surfels,
    batch: &Batch<'_>,
    points: &Buffer<SurfacePoint>,
    name: &str,
) -> Buffer<Gathered> {
    let gathered = g.transient(name, batch.most);
    g.add::<gather_surfels::GatherSurfels>(
        label,
        gather_surfels::Inputs {
            batch: batch.args,
            frame,
            grid: &grid.shape,
            settings,
            points,
            cells: &grid.cells,
            entries: &grid.entries,
            poses: &surfels.poses,
            births: &surfels.births,
            irradiance: &surfels.irradiance,
            depths: &surfels.depths,
            gathered,
        },
        batch.dispatch(),
    )
    .gathered
}

/// Rays from every surfel, light at their hits, and what comes back into irradiance and depth functions.
fn integrate_rays(
    g: &mut Graph,
    scene: &SceneInputs,
    grid: &Grid,
    device_settings: &Buffer<SurfelSettings>,
    surfels: Surfels,
    settings: &Settings,
    per_point: u32,
) -> Surfels {
    let capacity = u64::from(settings.surfels);
    let budget = u64::from(settings.rays).max(1);
    let requests = g.transient("ray_requests", capacity);
    let inputs = request_rays::Inputs {
        poses: &surfels.poses,
        irradiance: &surfels.irradiance,
        requests,
    };
    let requests = g
        .add::<request_rays::RequestRays>(
            "persistent/request_rays",
            inputs,
            Dispatch::Elements(capacity),
        )
        .requests;
    let (scanned, total) = exclusive_scan(g, "persistent/ray_scan", &requests);
    let offsets = g.transient("ray_offsets", capacity + 1);
    let batch = g.transient("ray_batch", 1);
    let allocated = g.add::<allocate_rays::AllocateRays>(
        "persistent/allocate_rays",
        allocate_rays::Inputs {
            settings: device_settings,
            scanned: &scanned,
            total: &total,
            offsets,
            batch,
        },
        Dispatch::Elements(capacity + 1),
    );
    let rays = g.transient("surfel_rays", budget);
    let paths = g.transient("surfel_paths", budget);
    let generated = g.add::<generate_rays::GenerateRays>(
        "persistent/generate_rays",
        generate_rays::Inputs {
            frame: &scene.frame,
            settings: device_settings,
            poses: &surfels.poses,
            births: &surfels.births,
            irradiance: &surfels.irradiance,
            offsets: &allocated.offsets,
            rays,
            paths,
        },
        Dispatch::Elements(capacity),
    );
    let first_rays = generated.rays;
    let mut radiance = g.zeroed("ray_radiance", budget);
    let mut segment = Segment {
        args: allocated.batch,
        rays: None,
        paths: generated.paths,
    };
    let mut first_hits = None;
    for depth in 0..=settings.continuations {
        let suffix = if depth == 0 {
            String::new()
        } else {
            format!("_{depth}")
        };
        let batch = Batch {
            args: &segment.args,
            most: budget,
            fixed: false,
        };
        let rays = segment.rays.as_ref().unwrap_or(&first_rays);
        let (hits, points) = surfaces(g, "persistent", &suffix, scene, &batch, rays);
        let direct = direct_light(g, "persistent", &suffix, scene, per_point, &batch, &points);
        let label = format!("persistent/gather_surfels{suffix}");
        let name = format!("persistent_gathered{suffix}");
        let gathered = gather(
            g,
            &label,
            &scene.frame,
            grid,
            device_settings,
            &surfels,
            &batch,
            &points,
            &name,
        );
        let goes_on = g.zeroed(&format!("goes_on{suffix}"), budget);
        let shaded = g.add::<shade_hits::ShadeHits>(
            &format!("persistent/shade_hits{suffix}"),
            shade_hits::Inputs {
                batch: &segment.args,
                frame: &scene.frame,
                rays,
                points: &points,
                direct: &direct,
                gathered: &gathered,
                environment: &scene.environment,
                paths: segment.paths,
                radiance,
                goes_on,
            },
            batch.dispatch(),
        );
        radiance = shaded.radiance;
        first_hits.get_or_insert(hits);
        if depth == settings.continuations {
            break;
        }
        segment = continue_segment(
            g,
            depth,
            &segment.args,
            &batch,
            &points,
            &shaded.paths,
            &shaded.goes_on,
        );
    }
    let hits = first_hits.unwrap_or_else(|| g.transient("no_hits", budget));
    let integrated = g.add::<integrate::Integrate>(
        "persistent/integrate",
        integrate::Inputs {
            settings: device_settings,
            poses: &surfels.poses,
            offsets: &allocated.offsets,
            rays: &first_rays,
            hits: &hits,
            radiance: &radiance,
            irradiance: surfels.irradiance,
            depths: surfels.depths,
        },
        Dispatch::Elements(capacity),
    );
    Surfels {
        irradiance: integrated.irradiance,
        depths: integrated.depths,
        ..surfels
    }
}

/// The rays of one path depth.
struct Segment {
    args: Buffer<DispatchArgs>,
    /// `None` for the surfels' own rays.
    rays: Option<Buffer<Ray>>,
    paths: Buffer<Path>,
}

fn continue_segment(
    g: &mut Graph,
    depth: u32,
    args: &Buffer<DispatchArgs>,
    batch: &Batch<'_>,
    points: &Buffer<SurfacePoint>,
    paths: &Buffer<Path>,
    goes_on: &Buffer<u32>,
) -> Segment {
    let next = depth + 1;
    let (scanned, total) = exclusive_scan(g, &format!("persistent/path_scan_{next}"), goes_on);
    let next_args = g.transient(&format!("path_batch_{next}"), 1);
    let inputs = batch_args::Inputs {
        count: &total,
        batch: next_args,
    };
    let label = format!("persistent/path_batch_{next}");
    let next_args = g
        .add::<batch_args::BatchArgs>(&label, inputs, Dispatch::Groups([1, 1, 1]))
        .batch;
    let next_rays = g.transient(&format!("path_rays_{next}"), batch.most);
    let next_paths = g.transient(&format!("paths_{next}"), batch.most);
    let continued = g.add::<continue_paths::ContinuePaths>(
        &format!("persistent/continue_paths_{next}"),
        continue_paths::Inputs {
            batch: args,
            points,
            paths,
            goes_on,
            scanned: &scanned,
            next_rays,
            next_paths,
        },
        batch.dispatch(),
    );
    Segment {
        args: next_args,
        rays: Some(continued.next_rays),
        paths: continued.next_paths,
    }
}

#[allow(clippy::too_many_arguments, reason = "the ports of the stages")]
fn spawn_surfels(
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
    let across = [
        frame.size[0].div_ceil(gap_fill::TILE),
        frame.size[1].div_ceil(gap_fill::TILE),
    ];
    let tiles = u64::from(across[0]) * u64::from(across[1]);
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
            depths: &surfels.depths,
            candidates,
            flags,
        },
        Dispatch::Groups([across[0], across[1], 1]),
    );
    let (ranks, total) = exclusive_scan(g, "spawn/rank", &found.flags);
    let claims = g.transient("spawn_claims", tiles);
    let claims = g
        .add::<spawn_claim::SpawnClaim>(
            "spawn/claim",
            spawn_claim::Inputs {
                candidates: &found.candidates,
                ranks: &ranks,
                counters: &counters,
                free_slots,
                claims,
            },
            Dispatch::Elements(tiles),
        )
        .claims;
    let inputs = spawn_commit::Inputs {
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
        depths: written.depths,
    };
    (surfels, counters)
}
