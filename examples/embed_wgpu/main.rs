//! Surfel GI in an engine that has a wgpu device of its own.
//!
//! ```sh
//! cargo run --release --example embed_wgpu
//! ```
//!
//! The engine rasterizes the G-buffers of two views, gibs lights both within the same submission, and the engine gets
//! two images of indirect light. They are held against the frames that gibs makes of the same G-buffers on the processor,
//! and against frames whose surfaces gibs traced itself. Then the sun goes down and one view gets another size, and the
//! next frames are held against the processor's again.
#[path = "../shared/engine.rs"]
mod engine;
mod raster;
#[path = "../shared/verdict.rs"]
mod verdict;

use engine::{World, evening, views};
use gibs::graph::Executable;
use gibs::passes::data::{HostGbuffer, HostGbufferError};
use gibs::passes::frame::{Screen, Settings};
use gibs::view::View;
use gibs::{Gi, HostImage};
use gibs_backend_wgpu::{WgpuBackend, WgpuExecutable, wgpu};
use raster::{Gbuffer, NEAR, Raster, read_halves, texture};
use std::error::Error;
use std::process::ExitCode;
use std::sync::Arc;
use verdict::Twin;

const SIZE: [u32; 2] = [160, 120];
const FRAMES: u32 = 48;
/// Of the first view, and frames, after the sun has moved.
const LATER_SIZE: [u32; 2] = [120, 96];
const LATER_FRAMES: u32 = 16;

/// The engine's device.
struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
}

/// One view with all that gibs keeps for it.
struct Lit {
    gi: Gi,
    exec: WgpuExecutable,
    gbuffer: Gbuffer,
    indirect: wgpu::Texture,
    /// What checks it.
    twin: Twin,
}

/// An image for indirect light.
fn indirect(device: &wgpu::Device, size: [u32; 2]) -> wgpu::Texture {
    let usage = wgpu::TextureUsages::STORAGE_BINDING
        | wgpu::TextureUsages::TEXTURE_BINDING
        | wgpu::TextureUsages::COPY_SRC;
    texture(device, size, wgpu::TextureFormat::Rgba16Float, usage)
}

impl Lit {
    /// Lends gibs the images that it works on: once, and again after every change that has it run another schedule.
    fn lend(&mut self) -> Result<(), Box<dyn Error>> {
        let output = self.indirect.create_view(&Default::default());
        for (image, texture) in [
            (HostImage::Depth, &self.gbuffer.depth),
            (HostImage::Normal, &self.gbuffer.normal),
            (HostImage::Albedo, &self.gbuffer.albedo),
            (HostImage::Ids, &self.gbuffer.objects),
            (HostImage::Indirect, &output),
        ] {
            let resource = self.gi.image(image).ok_or("the frame imports nothing")?;
            self.exec.import_image(resource, texture)?;
        }
        Ok(())
    }
}

/// How the engine's G-buffer is to be read.
fn conventions() -> Result<HostGbuffer, HostGbufferError> {
    HostGbuffer::perspective(NEAR.into(), None, true)
}

fn draw(
    gpu: &Gpu,
    raster: &Raster,
    views: &[View],
    lit: &mut [Lit],
    frames: u32,
) -> Result<(), Box<dyn Error>> {
    for _ in 0..frames {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        for (view, lit) in views.iter().zip(lit.iter_mut()) {
            let [width, height] = lit.gi.size().map(|side| side as f32);
            let aspect = width / height;
            raster.draw(&gpu.queue, &mut encoder, &lit.gbuffer, &view.camera, aspect);
            // gibs, each frame: what changed, then its commands among the engine's.
            lit.gi
                .begin_frame(&mut lit.exec, &view.camera, Some(&conventions()?))?;
            lit.exec.record(&mut encoder)?;
        }
        gpu.queue.submit([encoder.finish()]);
    }
    Ok(())
}

/// Holds the light of the last of some frames against the same on the processor.
fn check(
    gpu: &Gpu,
    views: &[View],
    lit: &mut [Lit],
    frames: u32,
    when: &str,
) -> Result<bool, Box<dyn Error>> {
    let mut agrees = true;
    for (i, (view, lit)) in views.iter().zip(lit).enumerate() {
        let indirect = read_halves(&gpu.device, &gpu.queue, &lit.indirect)?;
        let surfaces = lit.gbuffer.read(&gpu.device, &gpu.queue)?;
        let (name, camera) = (format!("view {i}: {when}"), &view.camera);
        agrees &= lit
            .twin
            .agrees(&name, &indirect, &surfaces, camera, &conventions()?, frames)?;
    }
    Ok(agrees)
}

fn run() -> Result<bool, Box<dyn Error>> {
    // The engine: a device, a world, a renderer.
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = pollster::block_on(instance.request_adapter(&Default::default()))?;
    let (device, queue) = pollster::block_on(adapter.request_device(&Default::default()))?;
    println!("on {}", adapter.get_info().name);
    let gpu = Gpu { device, queue };
    let world = World::room();
    let raster = Raster::new(&gpu.device, &world);

    // gibs, once: a backend from the engine's device, and for each view a schedule and the images it works on.
    let (device, queue) = (gpu.device.clone(), gpu.queue.clone());
    let backend = WgpuBackend::from_device(&adapter.get_info(), device, queue);
    let scene = world.scene();
    let views = views();
    let settings = Settings {
        rays: 20_000,
        ..Settings::default()
    };
    let mut lit = Vec::new();
    for view in &views {
        let mut gi = Gi::new(&scene, view, SIZE, &settings, Screen::Imported)?;
        let mut exec = backend.prepare_wgpu(gi.schedule().clone())?;
        gi.upload_scene(&mut exec)?;
        let mut made = Lit {
            gi,
            exec,
            gbuffer: raster.gbuffer(&gpu.device, SIZE),
            indirect: indirect(&gpu.device, SIZE),
            twin: Twin::new(&scene, view, SIZE, &settings)?,
        };
        made.lend()?;
        lit.push(made);
    }

    draw(&gpu, &raster, &views, &mut lit, FRAMES)?;
    let mut agrees = check(&gpu, &views, &mut lit, FRAMES, "at noon")?;
    for (i, (view, lit)) in views.iter().zip(&lit).enumerate() {
        let indirect = read_halves(&gpu.device, &gpu.queue, &lit.indirect)?;
        let name = format!("view {i}");
        agrees &=
            verdict::agrees_with_traced(&name, &indirect, &scene, view, &settings, SIZE, FRAMES)?;
    }

    // The sun moves, and the first view's window gets smaller. What was recorded has been submitted. Surfels stay.
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
        lit.twin.change(change)?;
        if i == 0 {
            lit.gbuffer = raster.gbuffer(&gpu.device, LATER_SIZE);
            lit.indirect = indirect(&gpu.device, LATER_SIZE);
        }
        if !Arc::ptr_eq(&schedule, lit.gi.schedule()) {
            lit.lend()?;
        }
    }
    draw(&gpu, &raster, &views, &mut lit, LATER_FRAMES)?;
    agrees &= check(&gpu, &views, &mut lit, LATER_FRAMES, "in the evening")?;
    Ok(agrees)
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
