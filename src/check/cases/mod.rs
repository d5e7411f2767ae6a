//! Frames to check backends on.
mod enriched;
mod imported;
mod programs;

use crate::Gi;
use crate::renderer::RenderError;
use crate::view::View;
use enriched::{enriched, under_sky, without_sky};
use gibs_graph::check::{Case, Upload, UploadLog};
use gibs_graph::{Backend, BackendError, Schedule};
use gibs_passes::data::SurfacePoint;
use gibs_passes::frame::{DebugView, Screen, Settings};
use gibs_passes::scene::{Camera, Environment, Scene};
use gibs_passes::shared::{batch, octahedral, surface};
use glam::Vec3;
use imported::imported;
use programs::{probes, reference};
use std::sync::Arc;

/// How much of each scene is run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Frames that are compared, from 0; those between run on the first participant alone. The camera moves sideways all
    /// the time, backs away to twice the distance in frames 12 to 15, and comes back in frames 20 to 23; in frame 9, all
    /// lights go down to a quarter, and in frame 60 they are as before.
    pub frames: Vec<u32>,
    /// Surfels.
    pub surfels: u32,
    /// Rays of a frame.
    pub rays: u32,
    /// Also the frames that only some programs run: everything that is off by default, an engine's G-buffer with everything
    /// off that is on by default, the reference. Otherwise those of the first scene alone.
    pub all: bool,
}

impl Default for Plan {
    fn default() -> Self {
        Self {
            size: [48, 27],
            frames: vec![0, 1, 2, 10, 14, 22, 30, 66, 76],
            surfels: 1024,
            rays: 4000,
            all: false,
        }
    }
}

/// Cases of scenes: the frame of each, and of the first one also the frames of [`Plan::all`]; and once, probes under a sky.
/// `oracle` draws what an engine would draw.
///
/// # Errors
/// As [`Renderer::new`](crate::Renderer::new).
pub fn cases(
    scenes: &[(&str, &(Scene, View))],
    plan: &Plan,
    oracle: &dyn Backend,
) -> Result<Vec<Case<'static>>, RenderError> {
    let mut cases = Vec::new();
    for (i, (name, scene)) in scenes.iter().enumerate() {
        let usual = settings(plan);
        cases.push(surfels(
            name,
            scene,
            plan.size,
            plan.frames.clone(),
            &usual,
        )?);
        if !plan.all && i > 0 {
            continue;
        }
        let enriched = &enriched(scene);
        let everything = Settings {
            clamp: true,
            guiding: true,
            sorting: true,
            hit_births: 64,
            half_resolution: !usual.half_resolution,
            check_slots: true,
            queries: 64,
            coverage: 1.5,
            depth_side: 7,
            guide_side: 4,
            debug: Some(DebugView::ALL[(2 * i) % DebugView::ALL.len()]),
            // More lists than there is room for, and fewer surfels than are wanted; with so many rays each that they
            // notice when lights change.
            grid_lists: 2,
            surfels: plan.surfels / 16,
            ..usual.clone()
        };
        cases.push(surfels(
            &format!("{name}, everything"),
            enriched,
            plan.size,
            plan.frames.clone(),
            &everything,
        )?);
        // Each view takes another way through the same stages; one scene is enough for that.
        let views = DebugView::ALL.iter().filter(|_| i == 0);
        for &view in views {
            let drawn = Settings {
                debug: Some(view),
                depth: true,
                guiding: view == DebugView::Guide,
                // Rays are shared out with and without the neighbours' word.
                sharing: view != DebugView::RayCount,
                // Points are gathered with and without the cell's average.
                fallback: view != DebugView::Coverage,
                ..usual.clone()
            };
            let name = format!("{name}, debug view {view}");
            // Some surfels are there by then, and the lights have changed.
            let few = if plan.frames.len() > 4 {
                2..4
            } else {
                0..plan.frames.len()
            };
            let frames = plan.frames[few].to_vec();
            cases.push(surfels(&name, scene, plan.size, frames, &drawn)?);
        }
        let plain = Settings {
            depth: false,
            steering: false,
            geometric_normals: true,
            continuations: 0,
            // Less than the lists of some cells hold.
            lookup: 8,
            surfels: plan.surfels / 4,
            debug: Some(DebugView::RayCount),
            ..usual.clone()
        };
        cases.push(imported(
            &format!("{name}, imported"),
            &under_sky(scene),
            plan,
            &plain,
            oracle,
        )?);
        cases.push(reference(&format!("{name}, reference"), enriched, plan)?);
        // A bright sky draws all samples.
        let named = format!("{name}, reference without a sky");
        cases.push(reference(&named, &without_sky(scene), plan)?);
    }
    cases.push(probes(plan)?);
    Ok(cases)
}

fn settings(plan: &Plan) -> Settings {
    Settings {
        surfels: plan.surfels,
        rays: plan.rays,
        ..Settings::default()
    }
}

/// What a feed reports of an error that is not the backend's.
fn refused(error: RenderError) -> BackendError {
    match error {
        RenderError::Backend(error) => error,
        error => BackendError::Refused {
            what: "the next frame".into(),
            reason: error.to_string(),
            remedy: "check another scene or view".into(),
        },
    }
}

/// The surfel frame of a scene as a case, with the camera and lights that change as [`Plan::frames`] says. Of a frame with
/// `queries`, points within a metre around the origin are asked for.
///
/// # Errors
/// As [`Renderer::new`](crate::Renderer::new).
pub fn surfels(
    name: &str,
    (scene, view): &(Scene, View),
    size: [u32; 2],
    frames: impl IntoIterator<Item = u32>,
    settings: &Settings,
) -> Result<Case<'static>, RenderError> {
    let mut gi = Gi::extended(scene, view, size, settings, Screen::Traced, |g, _| {
        g.keep_transients();
    })?;
    let schedule = gi.schedule().clone();
    let mut log = UploadLog::new(schedule.clone());
    let start = view.camera;
    let asked = asked(&schedule, settings.queries);
    let (lit, dimmed) = ((scene.clone(), view.clone()), dimmed(scene, view));
    let ours = schedule.clone();
    Ok(Case::new(name, schedule, frames, move |frame| {
        if frame == 0 {
            gi.upload_scene(&mut log).map_err(refused)?;
        }
        let other = match frame {
            DIMMED_IN => Some(&dimmed),
            LIT_AGAIN_IN => Some(&lit),
            _ => None,
        };
        if let Some((scene, view)) = other {
            gi.set_scene(&mut log, scene, view).map_err(refused)?;
            if !Arc::ptr_eq(gi.schedule(), &ours) {
                return Err(BackendError::Refused {
                    what: "changing the lights".into(),
                    reason: "it changes the schedule".into(),
                    remedy: "check frames before that with `Plan::frames`".into(),
                });
            }
        }
        let camera = moved(&start, frame);
        gi.begin_frame(&mut log, &camera, None).map_err(refused)?;
        let mut uploads = log.take();
        uploads.extend(asked.iter().cloned());
        Ok(uploads)
    }))
}

/// Frame in which the lights go down.
const DIMMED_IN: u32 = 9;

/// Frame in which they are as before: so late that surfels know their light well, and notice.
const LIT_AGAIN_IN: u32 = 60;

/// The same with a quarter of all light.
fn dimmed(scene: &Scene, view: &View) -> (Scene, View) {
    let (mut scene, mut view) = (scene.clone(), view.clone());
    for material in &mut scene.materials {
        material.emission *= 0.25;
    }
    for light in &mut scene.lights {
        light.intensity *= 0.25;
    }
    if let Some(sun) = &mut view.sun {
        sun.irradiance *= 0.25;
    }
    match &mut view.environment {
        Environment::Constant(radiance) => *radiance *= 0.25,
        Environment::Map(map) => map.texels.iter_mut().for_each(|texel| *texel *= 0.25),
        _ => {}
    }
    (scene, view)
}

/// Where the camera is in a frame.
fn moved(start: &Camera, frame: u32) -> Camera {
    let mut camera = *start;
    let away = camera.position - camera.target;
    let aside = camera.axes()[0] * away.length() * 0.01 * f64::from(frame);
    let back = match frame {
        0..12 => 0,
        12..16 => frame - 11,
        16..20 => 4,
        20..24 => 23 - frame,
        _ => 0,
    };
    camera.position += away * 0.25 * f64::from(back) + aside;
    camera
}

/// Points around the origin of the scene that a program asks for light at.
fn asked(schedule: &Schedule, queries: u32) -> Vec<Upload> {
    let ids = ["query_points", "query_batch"].map(|key| schedule.resource(key));
    let [Some(points), Some(args)] = ids else {
        return Vec::new();
    };
    let point = |i: u32| {
        let at = |axis: u32| ((i >> (2 * axis)) % 4) as f32 * 0.5 - 0.75;
        let normal = octahedral::pack(Vec3::new(at(0), at(1), at(2)).normalize());
        SurfacePoint {
            position: Vec3::new(at(0), at(1), at(2)),
            geometric_normal: normal,
            shading_normal: normal,
            transform_id: 0,
            ..surface::MISS
        }
    };
    let points_bytes: Vec<SurfacePoint> = (0..queries).map(point).collect();
    let upload = |resource, bytes: &[u8]| Upload {
        resource,
        offset: 0,
        bytes: bytes.to_vec(),
    };
    vec![
        upload(points, bytemuck::cast_slice(&points_bytes)),
        upload(args, bytemuck::bytes_of(&batch::args(queries))),
    ]
}
