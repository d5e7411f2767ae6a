//! The reference: a path tracer, one segment per pixel and frame, so that paths have no length limit.
//!
//! A first frame finds the primary surfaces; the second runs until every pixel has its samples. A fixed number of
//! samples for every pixel keeps the estimate unbiased: a limit on time would prefer short paths.
use super::inputs::upload;
use super::trace::{Batch, direct_light, gbuffer, surfaces, visibility};
use super::{SceneInputs, SceneSizes};
use crate::data::{Frame, ReferencePath, SurfacePoint};
use crate::device::DeviceScene;
use crate::shared::batch;
use crate::stages::{
    reference_accumulate, reference_emitters, reference_remaining, reference_scatter,
};
use bytemuck::Zeroable;
use gibs_graph::{BackendError, Buffer, Dispatch, Executable, Graph, Initial};

/// Lights sampled per vertex of a path.
const LIGHTS_PER_VERTEX: u32 = 1;

/// What the host says before the reference runs, and again with another frame number before each frame.
#[derive(Clone, Copy, Debug)]
pub struct ReferenceUpdate {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Samples per pixel.
    pub samples: u32,
    /// Frame number.
    pub number: u32,
    /// Seed.
    pub seed: u32,
    /// Draw points of emitters and of the sky.
    pub emitters: bool,
}

/// Records the frame that finds the primary surface of every pixel and its direct light from `per_point` lights. Its
/// outputs are `rays`, `points` and, with lights, `direct`.
pub fn gbuffer_frame(g: &mut Graph, size: [u32; 2], sizes: &SceneSizes, per_point: u32) {
    let scene = SceneInputs::declare(g, sizes);
    let most = u64::from(size[0]) * u64::from(size[1]);
    let batch = Batch {
        args: &scene.pixels,
        most,
        fixed: true,
    };
    let (rays, points) = gbuffer(g, &scene, &batch);
    let direct = direct_light(g, "gbuffer", "_direct", &scene, per_point, &batch, &points);
    g.output("rays", &rays);
    g.output("points", &points);
    if let Some(direct) = &direct {
        g.output("direct", direct);
    }
}

/// Records one segment of every pixel's path. The input `primary` takes the points of [`gbuffer_frame`]; outputs are
/// `paths` and `remaining`, the number of pixels that are not done.
pub fn reference_frame(
    g: &mut Graph,
    size: [u32; 2],
    sizes: &SceneSizes,
    scene_tables: &DeviceScene,
) {
    let scene = SceneInputs::declare(g, sizes);
    let most = u64::from(size[0]) * u64::from(size[1]);
    let batch = Batch {
        args: &scene.pixels,
        most,
        fixed: true,
    };
    let primary: Buffer<SurfacePoint> = g.input("primary", most);
    let sky: Buffer<f32> = g.input(
        "scene_sky_cumulative",
        scene_tables.environment.cumulative.len() as u64,
    );
    let (vertices_state, vertices) = g.state(
        "reference_vertices",
        most,
        Initial::fill(SurfacePoint::zeroed()),
    );
    let (paths_state, paths) = g.state(
        "reference_paths",
        most,
        Initial::fill(ReferencePath::zeroed()),
    );

    let rays = g.transient("reference_rays", most);
    let scattered = g.add::<reference_scatter::ReferenceScatter>(
        "reference/scatter",
        reference_scatter::Inputs {
            frame: &scene.frame,
            primary: &primary,
            vertices,
            paths,
            rays,
        },
        Dispatch::Elements(most),
    );
    let (_, points) = surfaces(g, "reference", "", &scene, &batch, &scattered.rays);
    let per_vertex = LIGHTS_PER_VERTEX.min(sizes.lights() as u32);
    let direct = direct_light(
        g,
        "reference",
        "",
        &scene,
        per_vertex,
        &batch,
        &scattered.vertices,
    );
    let rays = g.transient("emitter_rays", most);
    let samples = g.transient("emitter_samples", most);
    let sampled = g.add::<reference_emitters::ReferenceEmitters>(
        "reference/sample_emitters",
        reference_emitters::Inputs {
            frame: &scene.frame,
            vertices: &scattered.vertices,
            paths: &scattered.paths,
            emitters: &scene.emitters,
            environment: &scene.environment,
            sky_cumulative: &sky,
            rays,
            samples,
        },
        Dispatch::Elements(most),
    );
    let visible = visibility(g, "reference", "_emitters", &scene, &batch, &sampled.rays);
    let accumulated = g.add::<reference_accumulate::ReferenceAccumulate>(
        "reference/accumulate",
        reference_accumulate::Inputs {
            frame: &scene.frame,
            rays: &scattered.rays,
            points: &points,
            direct: direct.as_ref(),
            emitter_samples: &sampled.samples,
            emitter_visible: &visible,
            environment: &scene.environment,
            vertices: scattered.vertices,
            paths: scattered.paths,
        },
        Dispatch::Elements(most),
    );
    let remaining = g.zeroed("reference_remaining", 1);
    let inputs = reference_remaining::Inputs {
        frame: &scene.frame,
        primary: &primary,
        paths: &accumulated.paths,
        remaining,
    };
    let label = "reference/remaining";
    let counted =
        g.add::<reference_remaining::ReferenceRemaining>(label, inputs, Dispatch::Elements(most));
    g.output("paths", &accumulated.paths);
    g.output("remaining", &counted.remaining);
    g.keep(vertices_state, accumulated.vertices);
    g.keep(paths_state, accumulated.paths);
}

/// Writes the inputs that only the reference has, and those that change every frame.
///
/// # Errors
/// As [`Executable::upload`].
pub fn upload_reference(
    exec: &mut dyn Executable,
    scene: &DeviceScene,
    update: &ReferenceUpdate,
) -> Result<(), BackendError> {
    let lights = scene.lights.len() as u32;
    let frame = Frame {
        number: update.number,
        seed: update.seed,
        lights,
        lights_per_point: LIGHTS_PER_VERTEX.min(lights),
        environment_side: scene.environment.side,
        // Without a density of their own, what rays meet by chance counts in full.
        sky_sampled: u32::from(update.emitters && scene.environment.sampled),
        emitter_power: if update.emitters {
            scene.emitters.power
        } else {
            0.0
        },
        samples: update.samples,
    };
    upload(exec, "frame", &[frame])?;
    if update.number == 0 {
        upload(exec, "scene_sky_cumulative", &scene.environment.cumulative)?;
        upload(
            exec,
            "pixels",
            &[batch::args(update.size[0] * update.size[1])],
        )?;
    }
    Ok(())
}
