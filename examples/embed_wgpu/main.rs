//! Surfel GI in an engine that has a wgpu device of its own.
//!
//! ```sh
//! cargo run --release --example embed_wgpu
//! ```
//!
//! The engine rasterizes the G-buffers of two views, gibs lights both within the same submission, and the engine gets
//! two images of indirect light. At the end they are held against frames whose surfaces gibs traced itself.
#[path = "../shared/engine.rs"]
mod engine;
mod raster;
#[path = "../shared/verdict.rs"]
mod verdict;

use engine::{World, views};
use gibs::passes::data::HostGbuffer;
use gibs::passes::frame::{Screen, Settings};
use gibs::{Gi, HostImage};
use gibs_backend_wgpu::{WgpuBackend, WgpuExecutable, wgpu};
use raster::{Gbuffer, NEAR, Raster, read_halves, texture};
use std::error::Error;
use std::process::ExitCode;

const SIZE: [u32; 2] = [160, 120];
const FRAMES: u32 = 48;

/// One view with all that gibs keeps for it.
struct Lit {
    gi: Gi,
    exec: WgpuExecutable,
    gbuffer: Gbuffer,
    indirect: wgpu::Texture,
}

fn run() -> Result<bool, Box<dyn Error>> {
    // The engine: a device, a world, a renderer.
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = pollster::block_on(instance.request_adapter(&Default::default()))?;
    let (device, queue) = pollster::block_on(adapter.request_device(&Default::default()))?;
    println!("on {}", adapter.get_info().name);
    let world = World::room();
    let raster = Raster::new(&device, &world);

    // gibs, once: a backend from the engine's device, and for each view a schedule and the images it works on.
    let backend = WgpuBackend::from_device(&adapter.get_info(), device.clone(), queue.clone());
    let scene = world.scene();
    let views = views();
    let settings = Settings {
        rays: 20_000,
        ..Settings::default()
    };
    let mut lit = Vec::new();
    for view in &views {
        let gi = Gi::new(&scene, view, SIZE, &settings, Screen::Imported)?;
        let mut exec = backend.prepare_wgpu(gi.schedule().clone())?;
        gi.upload_scene(&mut exec)?;
        let gbuffer = raster.gbuffer(&device, SIZE);
        let usage = wgpu::TextureUsages::STORAGE_BINDING
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC;
        let indirect = texture(&device, SIZE, wgpu::TextureFormat::Rgba16Float, usage);
        let output = indirect.create_view(&Default::default());
        for (image, texture) in [
            (HostImage::Depth, &gbuffer.depth),
            (HostImage::Normal, &gbuffer.normal),
            (HostImage::Albedo, &gbuffer.albedo),
            (HostImage::Ids, &gbuffer.objects),
            (HostImage::Indirect, &output),
        ] {
            let resource = gi.image(image).ok_or("the frame imports nothing")?;
            exec.import_image(resource, texture)?;
        }
        lit.push(Lit {
            gi,
            exec,
            gbuffer,
            indirect,
        });
    }

    let aspect = SIZE[0] as f32 / SIZE[1] as f32;
    let conventions = HostGbuffer::perspective(NEAR.into(), None, true)?;
    for _ in 0..FRAMES {
        let mut encoder = device.create_command_encoder(&Default::default());
        for (view, lit) in views.iter().zip(&mut lit) {
            raster.draw(&queue, &mut encoder, &lit.gbuffer, &view.camera, aspect);
            // gibs, each frame: what changed, then its commands among the engine's.
            lit.gi
                .begin_frame(&mut lit.exec, &view.camera, Some(&conventions))?;
            lit.exec.record(&mut encoder)?;
        }
        queue.submit([encoder.finish()]);
    }

    let mut agrees = true;
    for (i, (view, lit)) in views.iter().zip(&lit).enumerate() {
        let indirect = read_halves(&device, &queue, &lit.indirect)?;
        let name = format!("view {i}");
        agrees &= verdict::agrees(&name, &indirect, &scene, view, &settings, SIZE, FRAMES)?;
    }
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
