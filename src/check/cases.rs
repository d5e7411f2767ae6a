//! Frames to check backends on.
use crate::renderer::{RenderError, Shaders, device_scene};
use crate::view::View;
use crate::{Gi, HostImage, Renderer, guiding};
use gibs_graph::check::{Case, Upload, UploadLog};
use gibs_graph::{Backend, BackendError, Executable, Graph, Schedule};
use gibs_passes::data::{HostGbuffer, SurfacePoint};
use gibs_passes::device::{DeviceScene, EnvironmentTable};
use gibs_passes::frame::{
    DebugView, ProbeFrame, ReferenceUpdate, SceneSizes, Screen, Settings, probe_frame,
    reference_frame, upload_probe_frame, upload_probes, upload_reference, upload_scene,
};
use gibs_passes::scene::{Camera, Environment, LightKind, Scene};
use gibs_passes::shared::{batch, octahedral, surface};
use glam::{UVec4, Vec3, Vec4};
use std::sync::Arc;

/// How much of each scene is run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Frames that are compared, from 0; those between run on the first participant alone. The camera moves sideways all
    /// the time, backs away to twice the distance in frames 12 to 15, and comes back in frames 20 to 23; in frame 9, all
    /// lights go down to a quarter.
    pub frames: Vec<u32>,
    /// Surfels.
    pub surfels: u32,
    /// Rays of a frame.
    pub rays: u32,
    /// Also the frames that only some programs run: everything that is off by default, an engine's G-buffer, the
    /// reference. Otherwise those of the first scene alone.
    pub all: bool,
}

impl Default for Plan {
    fn default() -> Self {
        Self {
            size: [48, 27],
            frames: vec![0, 1, 2, 10, 14, 22, 30],
            surfels: 1024,
            rays: 1000,
            all: false,
        }
    }
}

/// Cases of scenes: the frame of each, and of the first one also the frames of [`Plan::all`]; and once, probes under a sky.
/// `oracle` draws what an engine would draw.
///
/// # Errors
/// As [`Renderer::new`].
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
        let spotted = &with_spots(scene);
        let everything = Settings {
            clamp: true,
            guiding: true,
            sorting: true,
            hit_births: 64,
            half_resolution: !usual.half_resolution,
            check_slots: true,
            queries: 64,
            debug: Some(DebugView::ALL[(2 * i) % DebugView::ALL.len()]),
            // More lists than there is room for, and fewer surfels than are wanted.
            grid_lists: 2,
            surfels: plan.surfels / 2,
            ..usual.clone()
        };
        cases.push(surfels(
            &format!("{name}, everything"),
            spotted,
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
        let unsteered = Settings {
            steering: false,
            ..usual.clone()
        };
        cases.push(imported(
            &format!("{name}, imported"),
            scene,
            plan,
            &unsteered,
            oracle,
        )?);
        cases.push(reference(&format!("{name}, reference"), scene, plan)?);
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

/// The same with every other light a spot, which no built-in scene has.
fn with_spots((scene, view): &(Scene, View)) -> (Scene, View) {
    let mut scene = scene.clone();
    for light in scene.lights.iter_mut().step_by(2) {
        light.kind = LightKind::Spot {
            inner: 0.3,
            outer: 1.2,
        };
    }
    (scene, view.clone())
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
/// As [`Renderer::new`].
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
    let dimmed = dimmed(scene, view);
    let ours = schedule.clone();
    Ok(Case::new(name, schedule, frames, move |frame| {
        if frame == 0 {
            gi.upload_scene(&mut log).map_err(refused)?;
        }
        if frame == DIMMED_IN {
            let (scene, view) = &dimmed;
            gi.set_scene(&mut log, scene, view).map_err(refused)?;
            if !Arc::ptr_eq(gi.schedule(), &ours) {
                return Err(BackendError::Refused {
                    what: "dimming the lights".into(),
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

/// The surfel frame over an engine's images, as the oracle's traced surfaces would be drawn.
fn imported(
    name: &str,
    (scene, view): &(Scene, View),
    plan: &Plan,
    settings: &Settings,
    oracle: &dyn Backend,
) -> Result<Case<'static>, RenderError> {
    let mut traced = Renderer::new(oracle, scene, view, plan.size, settings, 0)?;
    traced.frame()?;
    let points: Vec<SurfacePoint> = traced.output("points")?;
    let mut gi = Gi::extended(
        scene,
        view,
        plan.size,
        settings,
        Screen::Imported,
        |g, _| {
            g.keep_transients();
        },
    )?;
    let schedule = gi.schedule().clone();
    let host = HostGbuffer::perspective(0.1, None, true)?;
    let eye = (view.camera.position - gi.scene().origin).as_vec3();
    let images = draw(&gi, &points, eye, view.camera.axes()[2].as_vec3(), &host);
    let mut log = UploadLog::new(schedule.clone());
    let camera = view.camera;
    Ok(Case::new(
        name,
        schedule,
        plan.frames.clone(),
        move |frame| {
            if frame == 0 {
                gi.upload_scene(&mut log).map_err(refused)?;
                for (resource, bytes) in &images {
                    log.upload(*resource, 0, bytes)?;
                }
            }
            gi.begin_frame(&mut log, &camera, Some(&host))
                .map_err(refused)?;
            Ok(log.take())
        },
    ))
}

/// What an engine would have drawn of these points.
fn draw(
    gi: &Gi,
    points: &[SurfacePoint],
    eye: Vec3,
    forward: Vec3,
    host: &HostGbuffer,
) -> Vec<(u32, Vec<u8>)> {
    let depth = |point: &SurfacePoint| {
        let distance = (point.position - eye).dot(forward);
        match surface::is_surface(point) {
            true => host.depth_offset + host.depth_scale / distance,
            false => host.depth_clear,
        }
    };
    let normal = |point: &SurfacePoint| octahedral::unpack(point.shading_normal);
    let depths: Vec<Vec4> = points
        .iter()
        .map(|p| Vec4::new(depth(p), 0.0, 0.0, 1.0))
        .collect();
    let normals: Vec<Vec4> = points.iter().map(|p| normal(p).extend(0.0)).collect();
    let albedos: Vec<Vec4> = points
        .iter()
        .map(|p| surface::albedo(p).extend(1.0))
        .collect();
    let ids: Vec<UVec4> = points
        .iter()
        .map(|p| UVec4::new(p.transform_id, 0, 0, 0))
        .collect();
    let images: [(HostImage, &[u8]); 4] = [
        (HostImage::Depth, bytemuck::cast_slice(&depths)),
        (HostImage::Normal, bytemuck::cast_slice(&normals)),
        (HostImage::Albedo, bytemuck::cast_slice(&albedos)),
        (HostImage::Ids, bytemuck::cast_slice(&ids)),
    ];
    images
        .into_iter()
        .filter_map(|(image, bytes)| Some((gi.image(image)?, bytes.to_vec())))
        .collect()
}

fn kept(mut g: Graph) -> Result<Arc<Schedule>, RenderError> {
    g.keep_transients();
    Ok(Arc::new(Shaders::default().compile(g)?))
}

/// The path tracer, from points on a plane through what the camera looks at: it needs some, and does not ask which.
fn reference(
    name: &str,
    (scene, view): &(Scene, View),
    plan: &Plan,
) -> Result<Case<'static>, RenderError> {
    let device: DeviceScene = device_scene(scene, view, view.camera.position)?;
    let sizes = SceneSizes::of(&device);
    let mut g = Graph::new("reference");
    reference_frame(&mut g, plan.size, &sizes, &device);
    let schedule = kept(g)?;
    let mut log = UploadLog::new(schedule.clone());
    let size = plan.size;
    let camera = view.camera;
    Ok(Case::new(
        name,
        schedule,
        plan.frames.clone(),
        move |frame| {
            if frame == 0 {
                upload_scene(&mut log, &device)?;
                if let Some(primary) = log.schedule().resource("primary") {
                    let points = plane(&device, &camera, size);
                    log.upload(primary, 0, bytemuck::cast_slice(&points))?;
                }
            }
            let update = ReferenceUpdate {
                size,
                samples: 64,
                number: frame,
                seed: 0,
                emitters: true,
            };
            upload_reference(&mut log, &device, &update)?;
            Ok(log.take())
        },
    ))
}

/// White points on a plane that faces the camera, halfway to what it looks at; every seventh pixel sees nothing.
fn plane(device: &DeviceScene, camera: &Camera, [width, height]: [u32; 2]) -> Vec<SurfacePoint> {
    let [right, up, forward] = camera.axes();
    let reach = (camera.target - camera.position).length() * 0.5;
    let normal = octahedral::pack(-forward.as_vec3());
    let point = |i: u32| {
        let across = |n: u32, of: u32| (f64::from(n) + 0.5) / f64::from(of) - 0.5;
        let offset = right * across(i % width, width) - up * across(i / width, height);
        let position = camera.position + (forward + offset) * reach - device.origin;
        let position = position.as_vec3();
        SurfacePoint {
            position,
            offset: position.abs().max_element() * surface::OFFSET,
            geometric_normal: normal,
            shading_normal: normal,
            transform_id: 0,
            ..surface::MISS
        }
    };
    let pixels = 0..width * height;
    pixels
        .map(|i| match i % 7 {
            3 => surface::MISS,
            _ => point(i),
        })
        .collect()
}

/// Guided probes under a sky with a small sun.
fn probes(plan: &Plan) -> Result<Case<'static>, RenderError> {
    let frame = ProbeFrame {
        normals: vec![Vec3::Z, Vec3::X, Vec3::new(-0.6, 0.0, 0.8)],
        per_place: 8,
        rays: 16,
        guided: true,
    };
    let environment = guiding::built_in("sun").map_or_else(Environment::default, Environment::Map);
    let table = EnvironmentTable::build(&environment);
    let mut g = Graph::new("probes");
    probe_frame(&mut g, &frame, &table);
    let schedule = kept(g)?;
    let mut log = UploadLog::new(schedule.clone());
    Ok(Case::new(
        "probes",
        schedule,
        plan.frames.clone(),
        move |number| {
            if number == 0 {
                upload_probes(&mut log, &frame, &table)?;
            }
            upload_probe_frame(&mut log, &table, number, 0)?;
            Ok(log.take())
        },
    ))
}
