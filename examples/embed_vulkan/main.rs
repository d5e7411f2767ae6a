//! Surfel GI in an engine that has a Vulkan device of its own.
//!
//! ```sh
//! cargo run --release --example embed_vulkan
//! cargo run --release --example embed_vulkan -- --validate
//! ```
//!
//! The engine rasterizes the G-buffers of two views, gibs lights both within the same command buffer, and the engine
//! gets two images of indirect light. At the end they are held against frames whose surfaces gibs traced itself. With
//! `--validate`, the validation layer watches, and has to stay silent.
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

use engine::{World, views};
use frames::Frames;
use gibs::passes::data::HostGbuffer;
use gibs::passes::frame::{Screen, Settings};
use gibs::passes::shared::gbuffer::NORMALS_OCTAHEDRAL;
use gibs::{Gi, HostImage};
use gibs_backend_vulkan::ash::vk;
use gibs_backend_vulkan::{ImageUse, ImportedImage, VulkanBackend, VulkanExecutable};
use gpu::Gpu;
use instance::Log;
use memory::Image;
use raster::{Gbuffer, Raster};
use std::error::Error;
use std::process::ExitCode;

const SIZE: [u32; 2] = [160, 120];
const FRAMES: u32 = 48;

/// One view with all that gibs keeps for it.
struct Lit<'a> {
    gi: Gi,
    exec: VulkanExecutable,
    gbuffer: Gbuffer<'a>,
    indirect: Image<'a>,
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

fn light(log: Option<&Log>) -> Result<bool, Box<dyn Error>> {
    // The engine: a device, a world, a renderer.
    let gpu = Gpu::new(log)?;
    println!("on {}", gpu.name);
    let world = World::room();
    let raster = Raster::new(&gpu, &world)?;

    // gibs, once: a backend from the engine's device, and for each view a schedule and the images it works on.
    // SAFETY: the handles belong together, the device has the features, and `gpu` is dropped after what gibs makes from
    // it. There is only this thread.
    let backend = unsafe {
        let (entry, instance) = (gpu.instance.entry.clone(), gpu.instance.raw.clone());
        let (physical, device) = (gpu.physical, gpu.device.clone());
        VulkanBackend::from_host(
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
        ..Settings::default()
    };
    let mut lit = Vec::new();
    for view in &views {
        let gi = Gi::new(&scene, view, SIZE, &settings, Screen::Imported)?;
        let mut exec = backend.prepare_vulkan(gi.schedule().clone())?;
        gi.upload_scene(&mut exec)?;
        gibs::graph::Executable::wait(&mut exec)?;
        let gbuffer = raster.gbuffer(SIZE)?;
        let usage = vk::ImageUsageFlags::STORAGE | vk::ImageUsageFlags::TRANSFER_SRC;
        let indirect = Image::new(&gpu, SIZE, vk::Format::R16G16B16A16_SFLOAT, usage)?;
        for (image, lent, entry, exit) in [
            (HostImage::Depth, &gbuffer.depth, DEPTH, DEPTH),
            (HostImage::Normal, &gbuffer.normal, COLOR, COLOR),
            (HostImage::Albedo, &gbuffer.albedo, COLOR, COLOR),
            (HostImage::Ids, &gbuffer.objects, COLOR, COLOR),
            (HostImage::Indirect, &indirect, DISCARDED, COPIED),
        ] {
            let resource = gi.image(image).ok_or("the frame imports nothing")?;
            let (aspect, view, image) = (lent.aspect, lent.view, lent.raw);
            let lent = ImportedImage {
                image,
                view,
                aspect,
                entry,
                exit,
            };
            // SAFETY: the images are of this device and size, of formats and for uses that fit, in the layouts of their
            // entries when a frame comes, each for one resource, and outlive the executable.
            unsafe { exec.import_image(resource, lent) }?;
        }
        lit.push(Lit {
            gi,
            exec,
            gbuffer,
            indirect,
        });
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

    let near_far = HostGbuffer::perspective(raster::NEAR.into(), Some(raster::FAR.into()), false)?;
    let conventions = HostGbuffer {
        normals: NORMALS_OCTAHEDRAL,
        ..near_far
    };
    for _ in 0..FRAMES {
        let commands = frames.begin()?;
        for (view, lit) in views.iter().zip(&mut lit) {
            // SAFETY: the commands are being recorded; the G-buffer is in the layouts that gibs brings it back to.
            unsafe { raster.draw(commands, &lit.gbuffer, &view.camera) };
            // gibs, each frame: what changed, then its commands among the engine's.
            lit.gi
                .begin_frame(&mut lit.exec, &view.camera, Some(&conventions))?;
            // SAFETY: the commands are being recorded, and are submitted below, once and in order; the fences see to it
            // that no more than two frames are under way, and `frames` that all are done before the executable goes.
            unsafe { lit.exec.record(commands) }?;
        }
        // SAFETY: as above.
        unsafe { frames.submit() }?;
    }

    let mut agrees = true;
    for (i, (view, lit)) in views.iter().zip(&lit).enumerate() {
        // SAFETY: the image has half floats and this size, and each frame leaves it to be copied.
        let indirect = unsafe { frames.read_halves(&lit.indirect, SIZE) }?;
        let name = format!("view {i}");
        agrees &= verdict::agrees(&name, &indirect, &scene, view, &settings, SIZE, FRAMES)?;
    }
    Ok(agrees)
}

fn run() -> Result<bool, Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let log = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => None,
        ["--validate"] => Some(Log::default()),
        _ => return Err("the only argument is --validate".into()),
    };
    let agrees = light(log.as_ref());
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
