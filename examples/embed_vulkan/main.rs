//! Surfel GI in an engine that has a Vulkan device of its own.
//!
//! ```sh
//! cargo run --release --example embed_vulkan
//! cargo run --release --example embed_vulkan -- --validate
//! cargo run --release --example embed_vulkan -- --ray-queries
//! ```
//!
//! The engine rasterizes the G-buffers of two views, gibs lights both within the same command buffer, and the engine
//! gets two images of indirect light. They are held against the frames that gibs makes of the same G-buffers on the
//! processor, and against frames whose surfaces gibs traced itself. Then the sun goes down and one view gets another size,
//! and the next frames are held against the processor's again. With `--validate`, the validation layer watches, and has
//! to stay silent. With `--ray-queries`, gibs traces by those of the engine's device.
#![deny(clippy::undocumented_unsafe_blocks)]
#[path = "../shared/engine.rs"]
mod engine;
mod frames;
mod gpu;
mod instance;
mod memory;
mod pipeline;
mod raster;
mod shader;
#[path = "../shared/verdict.rs"]
mod verdict;

use engine::{World, evening, views};
use frames::Frames;
use gibs::graph::{Executable, ImageFormat};
use gibs::passes::data::{HostGbuffer, HostGbufferError};
use gibs::passes::frame::{Screen, Settings};
use gibs::passes::shared::gbuffer::NORMALS_OCTAHEDRAL;
use gibs::view::View;
use gibs::{Gi, HostImage};
use gibs_backend_vulkan::ash::vk;
use gibs_backend_vulkan::{ImageUse, ImportedImage, VulkanBackend, VulkanExecutable};
use gpu::Gpu;
use instance::Log;
use memory::Image;
use raster::{Gbuffer, Raster};
use std::error::Error;
use std::process::ExitCode;
use std::sync::Arc;
use verdict::{Surfaces, Twin};

const SIZE: [u32; 2] = [160, 120];
const FRAMES: u32 = 48;
/// Of the first view, and frames, after the sun has moved.
const LATER_SIZE: [u32; 2] = [120, 96];
const LATER_FRAMES: u32 = 16;

/// One view with all that gibs keeps for it.
struct Lit<'a> {
    gi: Gi,
    exec: VulkanExecutable,
    gbuffer: Gbuffer<'a>,
    indirect: Image<'a>,
    /// What checks it.
    twin: Twin,
}

/// Before and after gibs, the G-buffer is drawn.
const COLOR: ImageUse = ImageUse {
    layout: raster::COLOR_LAYOUT,
    stage: raster::COLOR_STAGE,
    access: raster::COLOR_ACCESS,
};
const DEPTH: ImageUse = ImageUse {
    layout: raster::DEPTH_LAYOUT,
    stage: raster::DEPTH_STAGE,
    access: raster::DEPTH_ACCESS,
};
/// Before gibs, nothing matters of the light; after it, the light is copied.
const DISCARDED: ImageUse = ImageUse {
    layout: vk::ImageLayout::UNDEFINED,
    stage: vk::PipelineStageFlags::empty(),
    access: vk::AccessFlags::empty(),
};
const COPIED: ImageUse = ImageUse {
    layout: vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
    stage: vk::PipelineStageFlags::TRANSFER,
    access: vk::AccessFlags::TRANSFER_READ,
};

/// An image for indirect light.
fn indirect(gpu: &Gpu, size: [u32; 2]) -> Result<Image<'_>, Box<dyn Error>> {
    let usage = vk::ImageUsageFlags::STORAGE | vk::ImageUsageFlags::TRANSFER_SRC;
    Image::new(gpu, size, vk::Format::R16G16B16A16_SFLOAT, usage)
}

impl Lit<'_> {
    /// Lends gibs the images that it works on: once, and again after every change that has it run another schedule.
    ///
    /// # Safety
    /// When a frame comes, the G-buffer is in the layouts in which it is drawn.
    unsafe fn lend(&mut self) -> Result<(), Box<dyn Error>> {
        let gbuffer = &self.gbuffer;
        for (image, lent, entry, exit) in [
            (HostImage::Depth, &gbuffer.depth, DEPTH, DEPTH),
            (HostImage::Normal, &gbuffer.normal, COLOR, COLOR),
            (HostImage::Albedo, &gbuffer.albedo, COLOR, COLOR),
            (HostImage::Ids, &gbuffer.objects, COLOR, COLOR),
            (HostImage::Indirect, &self.indirect, DISCARDED, COPIED),
        ] {
            let resource = self.gi.image(image).ok_or("the frame imports nothing")?;
            let (aspect, view, image) = (lent.aspect, lent.view, lent.raw);
            let lent = ImportedImage {
                image,
                view,
                aspect,
                entry,
                exit,
            };
            // SAFETY: the images are of this device and size, of formats and for uses that fit, each for one resource, and
            // outlive the executable or its schedule; the layouts are the caller's promise.
            unsafe { self.exec.import_image(resource, lent) }?;
        }
        Ok(())
    }
}

/// How the engine's G-buffer is to be read.
fn conventions() -> Result<HostGbuffer, HostGbufferError> {
    let near_far = HostGbuffer::perspective(raster::NEAR.into(), Some(raster::FAR.into()), false)?;
    Ok(HostGbuffer {
        normals: NORMALS_OCTAHEDRAL,
        ..near_far
    })
}

/// Draws and lights frames.
///
/// # Safety
/// What gibs was lent is as [`Lit::lend`] wants it, and everything outlives `frames`.
unsafe fn draw(
    frames: &mut Frames<'_>,
    raster: &Raster<'_>,
    views: &[View],
    lit: &mut [Lit<'_>],
    count: u32,
) -> Result<(), Box<dyn Error>> {
    for _ in 0..count {
        let commands = frames.begin()?;
        for (view, lit) in views.iter().zip(lit.iter_mut()) {
            // SAFETY: the commands are being recorded; the G-buffer is in the layouts that gibs brings it back to.
            unsafe { raster.draw(commands, &lit.gbuffer, &view.camera) };
            // gibs, each frame: what changed, then its commands among the engine's.
            lit.gi
                .begin_frame(&mut lit.exec, &view.camera, Some(&conventions()?))?;
            // SAFETY: the commands are being recorded, and are submitted below, once and in order; the fences see to it
            // that no more than two frames are under way, and `frames` that all are done before the executable goes.
            unsafe { lit.exec.record(commands) }?;
        }
        // SAFETY: as above.
        unsafe { frames.submit() }?;
    }
    Ok(())
}

/// The light of the last frame, and the G-buffer that it was made of.
///
/// # Safety
/// As [`draw`], after a frame.
unsafe fn read(
    frames: &mut Frames<'_>,
    lit: &Lit<'_>,
) -> Result<(Vec<glam::Vec4>, Surfaces), Box<dyn Error>> {
    let (size, gbuffer) = (lit.gi.size(), &lit.gbuffer);
    let halves =
        |bytes: &[u8]| bytemuck::pod_collect_to_vec(&ImageFormat::Rgba16Float.decode(bytes));
    // SAFETY: the images have texels of so many bytes and this size; each frame leaves the light to be copied, and the
    // G-buffer to be drawn.
    unsafe {
        let light = frames.read(&lit.indirect, size, 8, COPIED)?;
        let normals = frames.read(&gbuffer.normal, size, 4, COLOR)?;
        // Two of its texels are as long as one with four half floats.
        let pairs: Vec<glam::Vec4> = halves(&normals);
        let normals = pairs.iter().flat_map(|p| [[p.x, p.y], [p.z, p.w]]);
        let surfaces = Surfaces::new(
            &frames.read(&gbuffer.depth, size, 4, DEPTH)?,
            normals
                .map(|[x, y]| glam::Vec4::new(x, y, 0.0, 0.0))
                .collect(),
            &frames.read(&gbuffer.albedo, size, 4, COLOR)?,
            &frames.read(&gbuffer.objects, size, 4, COLOR)?,
        );
        Ok((halves(&light), surfaces))
    }
}

fn light(log: Option<&Log>, ray_queries: bool) -> Result<bool, Box<dyn Error>> {
    // The engine: a device, a world, a renderer.
    let gpu = Gpu::new(log, ray_queries)?;
    let how = if ray_queries { " with ray queries" } else { "" };
    println!("on {}{how}", gpu.name);
    let world = World::room();
    let raster = Raster::new(&gpu, &world)?;

    // gibs, once: a backend from the engine's device, and for each view a schedule and the images it works on.
    // SAFETY: the handles belong together, the device has the features, and `gpu` is dropped after what gibs makes from
    // it. There is only this thread.
    let backend = unsafe {
        let (entry, instance) = (gpu.instance.entry.clone(), gpu.instance.raw.clone());
        let (physical, device) = (gpu.physical, gpu.device.clone());
        let from_host = match ray_queries {
            true => VulkanBackend::from_host_with_ray_queries,
            false => VulkanBackend::from_host,
        };
        from_host(
            entry,
            instance,
            instance::API,
            physical,
            device,
            gpu.queue,
            gpu.family,
        )
    }?;
    let scene = world.scene();
    let views = views();
    let settings = Settings {
        rays: 20_000,
        ray_queries,
        ..Settings::default()
    };
    let mut lit = Vec::new();
    for view in &views {
        let mut gi = Gi::new(&scene, view, SIZE, &settings, Screen::Imported)?;
        let mut exec = backend.prepare_vulkan(gi.schedule().clone())?;
        gi.upload_scene(&mut exec)?;
        exec.wait()?;
        let mut made = Lit {
            gi,
            exec,
            gbuffer: raster.gbuffer(SIZE)?,
            indirect: indirect(&gpu, SIZE)?,
            twin: Twin::new(&scene, view, SIZE, &settings)?,
        };
        // SAFETY: the G-buffer is brought to its layouts before the first frame.
        unsafe { made.lend() }?;
        lit.push(made);
    }

    // Behind everything that frames refer to.
    let mut frames = Frames::new(&gpu)?;
    let commands = frames.begin()?;
    for lit in &lit {
        // SAFETY: the commands are being recorded.
        unsafe { raster.introduce(commands, &lit.gbuffer) };
    }
    // SAFETY: all that they refer to is dropped after `frames`, which waits for them.
    unsafe { frames.submit() }?;

    // SAFETY: the G-buffers are in their layouts, and everything was made before `frames`.
    unsafe { draw(&mut frames, &raster, &views, &mut lit, FRAMES) }?;
    let mut agrees = true;
    for (i, (view, lit)) in views.iter().zip(&mut lit).enumerate() {
        // SAFETY: as above.
        let (indirect, surfaces) = unsafe { read(&mut frames, lit) }?;
        let name = format!("view {i}");
        agrees &=
            verdict::agrees_with_traced(&name, &indirect, &scene, view, &settings, SIZE, FRAMES)?;
        let (name, host) = (format!("{name}: at noon"), conventions()?);
        agrees &= lit
            .twin
            .agrees(&name, &indirect, &surfaces, &view.camera, &host, FRAMES)?;
    }

    // The sun moves, and the first view's window gets smaller. Surfels stay. Changes take that every frame is done that
    // was recorded.
    frames.finish()?;
    let views = views.map(|view| evening(&view));
    for (i, (view, lit)) in views.iter().zip(&mut lit).enumerate() {
        let change = |gi: &mut Gi, exec: &mut dyn Executable| {
            gi.set_lights(exec, &scene, view)?;
            if i == 0 {
                gi.resize(exec, LATER_SIZE, &view.camera)?;
            }
            Ok(())
        };
        let schedule = lit.gi.schedule().clone();
        change(&mut lit.gi, &mut lit.exec)?;
        // For uploads that are too large to come along with a frame.
        lit.exec.wait()?;
        lit.twin.change(change)?;
        if i == 0 {
            // The executable forgot the images before, with the schedule before.
            lit.gbuffer = raster.gbuffer(LATER_SIZE)?;
            lit.indirect = indirect(&gpu, LATER_SIZE)?;
            let commands = frames.begin()?;
            // SAFETY: the commands are being recorded; all that they refer to is done before it goes, as `frames` waits.
            unsafe {
                raster.introduce(commands, &lit.gbuffer);
                frames.submit()?;
            }
        }
        if !Arc::ptr_eq(&schedule, lit.gi.schedule()) {
            // SAFETY: the G-buffer is in the layouts in which it is drawn.
            unsafe { lit.lend() }?;
        }
    }
    // SAFETY: as above; of what was made since, nothing goes before `frames` has waited.
    unsafe { draw(&mut frames, &raster, &views, &mut lit, LATER_FRAMES) }?;
    for (i, (view, lit)) in views.iter().zip(&mut lit).enumerate() {
        // SAFETY: as above.
        let (indirect, surfaces) = unsafe { read(&mut frames, lit) }?;
        let (name, host) = (format!("view {i}: in the evening"), conventions()?);
        let camera = &view.camera;
        agrees &= lit
            .twin
            .agrees(&name, &indirect, &surfaces, camera, &host, LATER_FRAMES)?;
    }
    Ok(agrees)
}

fn run() -> Result<bool, Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let known = ["--validate", "--ray-queries"];
    if let Some(other) = arguments.iter().find(|a| !known.contains(&a.as_str())) {
        return Err(format!("`{other}` is none of {}", known.join(", ")).into());
    }
    let has = |argument: &str| arguments.iter().any(|a| a == argument);
    let log = has("--validate").then(Log::default);
    let agrees = light(log.as_ref(), has("--ray-queries"));
    // Of Vulkan nothing is left, so the layer has said everything.
    let messages = log.as_ref().map(Log::messages);
    for message in messages.iter().flatten() {
        eprintln!("validation: {message}");
    }
    match messages.map(|messages| messages.len()) {
        None => agrees,
        Some(count) => {
            println!("messages of the validation layer: {count}");
            Ok(agrees? && count == 0)
        }
    }
}

fn main() -> ExitCode {
    match run() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}
