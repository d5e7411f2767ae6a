//! The surfel frame, in the order of the talk's frame overview.
mod check;
mod debug;
mod filtering;
mod grid;
mod rays;
mod recycle;
mod screen;
mod sorting;
mod spawn;
mod upsample;

use super::trace::{Batch, direct_light};
use super::{SceneInputs, SceneSizes, Settings};
use crate::data::*;
use crate::shared::grid::GridLayout;
use crate::shared::{depth, guide};
use crate::stages::*;
use gibs_graph::{Buffer, Graph, Image, Initial, Rgba16Float, State};
use glam::{UVec2, Vec4};

/// What a surfel frame is made for.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfelFrame {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Shape of the grid, see [`Settings::grid`].
    pub grid: GridLayout,
    /// Settings.
    pub settings: Settings,
    /// Where the visible surfaces come from, and where the light goes.
    pub screen: Screen,
}

/// Where the visible surfaces come from, and where the light goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Screen {
    /// Rays find the surfaces. Outputs: `points`, `irradiance`, `color` and, with lights, `direct`.
    Traced,
    /// The engine's G-buffer holds them, in the imported images `host_depth`, `host_normal`, `host_albedo` and
    /// `host_ids`; indirect light goes to the exported image `host_indirect`. The input `host` says how, see
    /// [`HostGbuffer`].
    Imported,
}

/// What stages that are recorded after the frame may go on with.
///
/// All but [`SurfelOutputs::gathered`] is read by the host or an input, so a stage may read it and not write it:
/// [`Graph::compile`] refuses an output that is not the last version.
#[derive(Debug)]
pub struct SurfelOutputs {
    /// What the host writes: camera, frame, geometry, and `pixels`, the size of a dispatch with an invocation per pixel.
    pub scene: SceneInputs,
    /// The surface that each pixel sees, row by row from the top left; `points` among the outputs of a frame with
    /// [`Screen::Traced`].
    pub points: Buffer<SurfacePoint>,
    /// What surfels say about each pixel's indirect irradiance, W/m^2; no output.
    pub gathered: Buffer<Gathered>,
    /// Where the light went.
    pub light: Light,
}

/// Where the light of a frame went; depends on its [`Screen`].
#[derive(Debug)]
pub enum Light {
    /// Of [`Screen::Traced`]: one element per pixel, outputs of the same names.
    Traced {
        /// Irradiance from the sun and the lights, W/m^2; `None` in a scene without.
        direct: Option<Buffer<Vec4>>,
        /// Indirect irradiance, W/m^2; in the last component, the summed weight of the surfels.
        irradiance: Buffer<Vec4>,
        /// The picture: radiance, W/(m^2 sr); in the last component, 1 on surfaces and 0 in the sky.
        color: Buffer<Vec4>,
    },
    /// Of [`Screen::Imported`]: the image `host_indirect`.
    Imported {
        /// Indirect light.
        indirect: Image<Rgba16Float>,
    },
}

/// The surfels: one handle per field, so that unrelated stages stay independent.
struct Surfels {
    births: Buffer<SurfelBirth>,
    poses: Buffer<SurfelPose>,
    irradiance: Buffer<SurfelIrradiance>,
    light: Buffer<SurfelLight>,
    /// Where irradiance is shared: what each was told last.
    neighbours: Option<Buffer<Neighbours>>,
    /// Where depth functions guard against leaks.
    depths: Option<Buffer<u32>>,
    /// Where rays are guided.
    guides: Option<Buffer<u32>>,
    unseen: Buffer<u32>,
}

/// Their states, which wait for the last versions.
struct SurfelStates {
    births: State<SurfelBirth>,
    poses: State<SurfelPose>,
    irradiance: State<SurfelIrradiance>,
    light: State<SurfelLight>,
    neighbours: Option<State<Neighbours>>,
    depths: Option<State<u32>>,
    guides: Option<State<u32>>,
    unseen: State<u32>,
}

impl Surfels {
    fn declare(g: &mut Graph, settings: &Settings) -> (SurfelStates, Self) {
        let capacity = settings.slots();
        let (births_state, births) = g.state("surfel_births", capacity, Initial::Zero);
        let (poses_state, poses) = g.state("surfel_poses", capacity, Initial::Zero);
        let (irradiance_state, irradiance) = g.state("surfel_irradiance", capacity, Initial::Zero);
        let (light_state, light) = g.state("surfel_light", capacity, Initial::Zero);
        let (neighbours_state, neighbours) = settings
            .sharing
            .then(|| g.state("surfel_neighbours", capacity, Initial::Zero))
            .unzip();
        let (guides_state, guides) = settings
            .guiding
            .then(|| {
                let words = capacity * guide::words(settings.guide_side) as u64;
                g.state("surfel_guides", words, Initial::Zero)
            })
            .unzip();
        let (depths_state, depths) = settings
            .depth
            .then(|| {
                // Where depth functions begin late, nothing is hidden at first.
                let texels = capacity * depth::count(settings.depth_side) as u64;
                g.state("surfel_depths", texels, Initial::fill(depth::UNKNOWN))
            })
            .unzip();
        let (unseen_state, unseen) = g.state("surfel_unseen", capacity, Initial::Zero);
        (
            SurfelStates {
                births: births_state,
                poses: poses_state,
                irradiance: irradiance_state,
                light: light_state,
                neighbours: neighbours_state,
                depths: depths_state,
                guides: guides_state,
                unseen: unseen_state,
            },
            Self {
                births,
                poses,
                irradiance,
                light,
                neighbours,
                depths,
                guides,
                unseen,
            },
        )
    }

    fn keep(self, g: &mut Graph, states: SurfelStates) {
        g.keep(states.births, self.births);
        g.keep(states.poses, self.poses);
        g.keep(states.irradiance, self.irradiance);
        g.keep(states.light, self.light);
        if let (Some(state), Some(neighbours)) = (states.neighbours, self.neighbours) {
            g.keep(state, neighbours);
        }
        if let (Some(state), Some(depths)) = (states.depths, self.depths) {
            g.keep(state, depths);
        }
        if let (Some(state), Some(guides)) = (states.guides, self.guides) {
            g.keep(state, guides);
        }
        g.keep(states.unseen, self.unseen);
    }
}

/// The free slots of the surfels.
struct Slots {
    counters: Buffer<SurfelCounters>,
    free: Buffer<u32>,
}

/// The lists of the grid's cells.
struct Grid {
    shape: Buffer<GridShape>,
    cells: Buffer<UVec2>,
    entries: Buffer<u32>,
    /// Entries that did not fit.
    overflow: Buffer<u32>,
}

/// Records the frame. Its outputs are those of the [`Screen`], `rays` (how many surfels send), `rays_1`, `rays_2` and so on
/// (how many paths go on beyond a hit for the first, the second time), `counters`, `crowded` (holes in crowded cells) and `overflow`; with `check_slots`,
/// `slot_errors`; with the firefly clamp, `clamped`; with queries also
/// `query_gathered` and, with lights, `query_direct`, of the input `query_points`; with a debug view `debug`, and
/// `debug_surfels` where it shows something of each surfel. Gives what further stages may go on
/// with.
pub fn surfel_frame(g: &mut Graph, frame: &SurfelFrame, sizes: &SceneSizes) -> SurfelOutputs {
    let settings = &frame.settings;
    let mut scene = SceneInputs::declare(g, sizes);
    if frame.settings.ray_queries {
        scene = scene.with_ray_queries(g);
    }
    let device_settings: Buffer<SurfelSettings> = g.input("settings", 1);
    let shape = g.input("grid", 1);
    let capacity = settings.slots();
    let per_point = settings.lights_per_point(sizes.lights());
    let (states, surfels) = Surfels::declare(g, settings);
    let counters = g.state("surfel_counters", 1, Initial::Zero);
    let free_slots = g.state("surfel_free_slots", capacity, Initial::Sequence);
    let seen = screen::see(g, &scene, frame);

    // Persistent
    let in_use = recycle::slots_in_use(g, "persistent", &counters.1);
    let (surfels, gone) =
        grid::update_positions(g, &scene, &shape, &device_settings, surfels, &in_use);
    let slots = Slots {
        counters: counters.1,
        free: free_slots.1,
    };
    let (surfels, slots) = recycle::free(g, surfels, slots, &gone, &in_use);
    let grid = grid::build_grid(g, shape, &surfels.poses, frame, &in_use);

    let past = settings.debug.filter(|view| view.is_of_the_past());
    let past_values = past
        .and_then(|view| debug::surfel_values(g, view, &scene, &device_settings, &surfels, None));

    // Spawn, before rays are traced, so that new surfels have theirs in the same frame
    let counts = spawn::Counts {
        counters: slots.counters,
        crowded: g.zeroed("crowded", 1),
    };
    let (surfels, counts, claims) = spawn::spawn_surfels(
        g,
        &scene,
        &grid,
        &device_settings,
        surfels,
        frame,
        &seen.points,
        counts,
        &slots.free,
    );
    let grid = grid::inject(g, grid, &surfels.poses, &claims);
    let in_use = recycle::slots_in_use(g, "spawn", &counts.counters);
    let (surfels, ray_spans, hit_gaps) = rays::integrate_rays(
        g,
        &scene,
        &grid,
        &device_settings,
        surfels,
        &in_use,
        settings,
        per_point,
    );
    let present = settings.debug.filter(|view| !view.is_of_the_past());
    let debug_values = past_values.or_else(|| {
        let spans = Some(&ray_spans);
        debug::surfel_values(g, present?, &scene, &device_settings, &surfels, spans)
    });

    // These have no rays yet, so that nobody asks for them before the lists are built again.
    let (surfels, counts) = match hit_gaps {
        Some(gaps) => {
            let (surfels, counts, _) = spawn::bear(
                g,
                &scene,
                &grid,
                &device_settings,
                surfels,
                "spawn/hit",
                &gaps.wanted,
                &gaps.points,
                counts,
                &slots.free,
            );
            (surfels, counts)
        }
        None => (surfels, counts),
    };

    // Apply
    let lit = screen::apply(
        g,
        &scene,
        frame,
        &grid,
        &device_settings,
        &surfels,
        seen,
        per_point,
    );
    if let Some(view) = settings.debug {
        debug::draw(
            g,
            view,
            &scene,
            frame,
            &grid,
            &device_settings,
            &surfels,
            debug_values.as_ref(),
            &lit.points,
        );
    }
    if settings.queries > 0 {
        answer(
            g,
            &scene,
            settings.queries,
            &grid,
            &device_settings,
            &surfels,
            per_point,
        );
    }
    let surfels = recycle::choose(
        g,
        &scene,
        &grid,
        &device_settings,
        surfels,
        &counts.counters,
        &in_use,
    );
    if settings.check_slots {
        let free = &slots.free;
        check::check_slots(g, &device_settings, &surfels, &counts.counters, free);
    }
    g.output("counters", &counts.counters);
    g.output("crowded", &counts.crowded);
    g.output("overflow", &grid.overflow);
    surfels.keep(g, states);
    g.keep(counters.0, counts.counters);
    g.keep(free_slots.0, slots.free);
    SurfelOutputs {
        scene,
        points: lit.points,
        gathered: lit.gathered,
        light: lit.light,
    }
}

/// Light at points that the host asks for: the stages of the group `query`, which can also run between frames, since
/// everything that they read outlives the frame.
fn answer(
    g: &mut Graph,
    scene: &SceneInputs,
    queries: u32,
    grid: &Grid,
    settings: &Buffer<SurfelSettings>,
    surfels: &Surfels,
    per_point: u32,
) {
    let points = g.input("query_points", queries.into());
    let args = g.input("query_batch", 1);
    let batch = Batch {
        args: &args,
        most: queries.into(),
        fixed: false,
    };
    let gathered = g.transient("query_gathered", batch.most);
    let gathered = gather(
        g,
        "query/gather_surfels",
        grid,
        settings,
        surfels,
        &batch,
        &points,
        None,
        gathered,
    );
    g.output("query_gathered", &gathered);
    if let Some(direct) = direct_light(g, "query", "", scene, per_point, &batch, &points) {
        g.output("query_direct", &direct);
    }
    g.output("grid_cells", &grid.cells);
    g.output("grid_entries", &grid.entries);
}

#[allow(clippy::too_many_arguments, reason = "the ports of the stage")]
fn gather(
    g: &mut Graph,
    label: &str,
    grid: &Grid,
    settings: &Buffer<SurfelSettings>,
    surfels: &Surfels,
    batch: &Batch<'_>,
    points: &Buffer<SurfacePoint>,
    pixels: Option<&Buffer<u32>>,
    gathered: Buffer<Gathered>,
) -> Buffer<Gathered> {
    g.add::<gather_surfels::GatherSurfels>(
        label,
        gather_surfels::Inputs {
            batch: batch.args,
            grid: &grid.shape,
            settings,
            points,
            cells: &grid.cells,
            entries: &grid.entries,
            poses: &surfels.poses,
            light: &surfels.light,
            depths: surfels.depths.as_ref(),
            pixels,
            gathered,
        },
        batch.dispatch(),
    )
    .gathered
}
