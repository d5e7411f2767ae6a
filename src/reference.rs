//! Path-traced ground truth.
use crate::channels::{read_output, set, surface_channels};
use crate::picture::Picture;
use crate::renderer::{RenderError, check_size, compile, device_scene};
use crate::view::View;
use gibs_graph::{Backend, Graph, Schedule};
use gibs_passes::data::{Ray, ReferencePath, SurfacePoint};
use gibs_passes::device::DeviceScene;
use gibs_passes::frame::{
    FrameUpdate, ReferenceUpdate, SceneSizes, Settings, gbuffer_frame, pixel_angle,
    reference_frame, upload_frame, upload_reference, upload_scene,
};
use gibs_passes::scene::Scene;
use gibs_passes::shared::estimator::luminance;
use gibs_passes::shared::{environment, surface};
use glam::{Vec3, Vec4};
use serde::Serialize;
use std::sync::Arc;

/// What to render.
#[derive(Clone, Copy, Debug)]
pub struct ReferenceOptions {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Samples per pixel.
    pub samples: u32,
    /// Seed.
    pub seed: u32,
    /// Whether each vertex of a path also sends a ray to a point of an emitter or of the sky, drawn by power. Without, only rays
    /// that meet them by chance find their light: brute force, with the same mean and far more noise.
    pub emitters: bool,
}

/// How certain a reference is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Certainty {
    /// Samples per pixel.
    pub samples: u32,
    /// Root mean square over pixels of the standard error of luminance, over the mean luminance.
    pub standard_error: f64,
    /// Pixels of whose sum one sample makes up more than half.
    pub fireflies: usize,
    /// Frames that ran: segments of the longest sequence of paths.
    pub frames: u32,
    /// Segments of all paths: the rays whose closest hit was sought, but for one to the primary surface of each pixel.
    pub segments: u64,
    /// What the scene lost on the way to the device, as [`crate::Renderer::warnings`]; the picture is of the rest.
    pub warnings: Vec<String>,
}

/// Lights whose direct light at the primary surfaces is exact; where there are more, as many are drawn.
const MOST_LIGHTS: u32 = 64;

/// Frames between looks at how many pixels are left.
const LOOK_EVERY: u32 = 16;

/// Renders ground truth: the final image in `R G B`, `E`, `direct` and everything else that a truth has, the standard error of E's luminance as
/// `standard_error.Y`, and `firefly.A`. `progress` hears of finished frames and of the pixels that are left, for the first
/// time before the first frame.
///
/// # Errors
/// As [`crate::Renderer`].
pub fn reference(
    backend: &dyn Backend,
    scene: &Scene,
    view: &View,
    options: &ReferenceOptions,
    mut progress: impl FnMut(u32, u32),
) -> Result<(Picture, Certainty), RenderError> {
    check_size(options.size)?;
    let device = device_scene(scene, view, view.camera.position)?;
    let [primary, paths] = schedules(&device, options.size)?;
    let settings = settings();
    let mut exec = backend.prepare(Arc::new(primary))?;
    upload_scene(exec.as_mut(), &device)?;
    let grid = settings.grid(pixel_angle(&view.camera, options.size), options.size);
    let update = FrameUpdate {
        camera: &view.camera,
        size: options.size,
        number: 0,
        seed: options.seed,
        grid,
    };
    upload_frame(exec.as_mut(), &device, &settings, &update)?;
    exec.run()?;
    let points: Vec<SurfacePoint> = read_output(exec.as_mut(), "points")?;
    let rays: Vec<Ray> = read_output(exec.as_mut(), "rays")?;
    let direct = match exec.schedule().output("direct") {
        Some(_) => read_output(exec.as_mut(), "direct")?,
        None => vec![Vec4::ZERO; points.len()],
    };

    exec.adopt(Arc::new(paths))?;
    upload_scene(exec.as_mut(), &device)?;
    if let Some(primary) = exec.schedule().resource("primary") {
        exec.upload(primary, 0, bytemuck::cast_slice(&points))?;
    }
    let mut frames = 0;
    progress(frames, options.size[0] * options.size[1]);
    loop {
        let (size, samples, seed) = (options.size, options.samples, options.seed);
        upload_reference(
            exec.as_mut(),
            &device,
            &ReferenceUpdate {
                size,
                samples,
                number: frames,
                seed,
                emitters: options.emitters,
            },
        )?;
        exec.run()?;
        frames += 1;
        // Every path has at least one segment, so that nothing can be done before.
        if frames >= samples && frames.is_multiple_of(LOOK_EVERY) {
            let remaining: Vec<u32> = read_output(exec.as_mut(), "remaining")?;
            let remaining = remaining.first().copied().unwrap_or_default();
            progress(frames, remaining);
            if remaining == 0 {
                break;
            }
        } else if frames.is_multiple_of(LOOK_EVERY) {
            exec.wait()?;
            progress(frames, options.size[0] * options.size[1]);
        }
    }
    let paths: Vec<ReferencePath> = read_output(exec.as_mut(), "paths")?;
    let primary = Primary {
        rays,
        points,
        direct,
    };
    compose(view, &device, options, &primary, &paths, frames)
}

/// What runs: the frame that finds the primary surfaces, and the one that runs again and again.
///
/// # Errors
/// [`RenderError::Graph`].
pub(crate) fn schedules(
    device: &DeviceScene,
    size: [u32; 2],
) -> Result<[Schedule; 2], RenderError> {
    let sizes = SceneSizes::of(device);
    let mut primary = Graph::new("gbuffer");
    let per_point = settings().lights_per_point(sizes.lights());
    gbuffer_frame(&mut primary, size, &sizes, per_point);
    let mut paths = Graph::new("reference");
    reference_frame(&mut paths, size, &sizes, device);
    Ok([compile(primary)?, compile(paths)?])
}

fn settings() -> Settings {
    Settings {
        lights: MOST_LIGHTS,
        ..Settings::default()
    }
}

/// What the pixels see first.
struct Primary {
    rays: Vec<Ray>,
    points: Vec<SurfacePoint>,
    direct: Vec<Vec4>,
}

fn compose(
    view: &View,
    device: &DeviceScene,
    options: &ReferenceOptions,
    primary: &Primary,
    paths: &[ReferencePath],
    frames: u32,
) -> Result<(Picture, Certainty), RenderError> {
    let points = &primary.points;
    let mean = |p: &ReferencePath| p.sum / p.done.max(1) as f32;
    let mut picture = surface_channels(points, options.size, view, device.origin)?;
    set(&mut picture, "E", paths.iter().map(mean))?;
    let indirect: Vec<Vec3> = paths
        .iter()
        .zip(points)
        .map(|(p, s)| surface::albedo(s) * std::f32::consts::FRAC_1_PI * mean(p))
        .collect();
    set(&mut picture, "indirect", indirect.iter().copied())?;
    set(
        &mut picture,
        "direct",
        primary.direct.iter().map(|d| d.truncate()),
    )?;
    let sky = &device.environment;
    let color = |i: usize| {
        let point = &points[i];
        if surface::is_surface(point) {
            let direct =
                surface::albedo(point) * std::f32::consts::FRAC_1_PI * primary.direct[i].truncate();
            point.emission + direct + indirect[i]
        } else {
            environment::radiance(&sky.texels, sky.side, primary.rays[i].direction)
        }
    };
    set(&mut picture, "", (0..points.len()).map(color))?;
    let variance = |p: &ReferencePath| {
        let n = f64::from(p.done.max(2));
        let mean = f64::from(luminance(p.sum)) / n;
        ((f64::from(p.sum_squared) / n - mean * mean) / (n - 1.0)).max(0.0)
    };
    let firefly = |p: &ReferencePath| p.largest > 0.5 * luminance(p.sum) && p.done > 8;
    let seen = || paths.iter().filter(|p| p.done > 0);
    let count = seen().count().max(1) as f64;
    let average = seen().map(|p| f64::from(luminance(mean(p)))).sum::<f64>() / count;
    let error = (seen().map(variance).sum::<f64>() / count).sqrt();
    picture.set_scalar(
        "standard_error.Y",
        paths.iter().map(|p| variance(p).sqrt() as f32).collect(),
    )?;
    picture.set_scalar(
        "firefly.A",
        paths
            .iter()
            .map(|p| f32::from(u8::from(firefly(p))))
            .collect(),
    )?;
    let certainty = Certainty {
        samples: options.samples,
        standard_error: if average > 0.0 { error / average } else { 0.0 },
        fireflies: paths.iter().filter(|p| firefly(p)).count(),
        frames,
        segments: paths.iter().map(|p| u64::from(p.segments)).sum(),
        warnings: device.warnings.clone(),
    };
    Ok((picture, certainty))
}
