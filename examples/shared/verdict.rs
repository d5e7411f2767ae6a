//! Holds what an engine got against frames of the processor: of the same G-buffer, and with traced surfaces.
use gibs::compare::{CompareOptions, compare};
use gibs::graph::{Backend, Executable};
use gibs::passes::data::HostGbuffer;
use gibs::passes::frame::{Screen, Settings};
use gibs::passes::scene::{Camera, Scene};
use gibs::picture::Picture;
use gibs::view::View;
use gibs::{Gi, HostImage, RenderError, Renderer};
use glam::{UVec4, Vec4};
use std::error::Error;

/// Largest FLIP that is accepted between the engine's picture and that of the processor, where both trace alike.
const ACCEPTED_FLIP: f64 = 0.005;

/// Largest FLIP where the device traces by ray queries, whose hits need not be those of the traversal in software to the bit:
/// surfels of one and the other part for good at the first that differs. Twice what was seen on lavapipe (0.047 after 48 frames), for
/// want of anything to derive it from; what holds the pictures together is their mean.
const ACCEPTED_FLIP_OF_RAY_QUERIES: f64 = 0.1;

/// An engine's G-buffer, as it was read back: a value per texel, of each image what gibs reads of it.
pub struct Surfaces {
    pub depth: Vec<Vec4>,
    pub normal: Vec<Vec4>,
    pub albedo: Vec<Vec4>,
    pub ids: Vec<UVec4>,
}

impl Surfaces {
    /// From bytes: depths and ids of 32 bits, albedos of 8 bits in each of four channels.
    pub fn new(depth: &[u8], normal: Vec<Vec4>, albedo: &[u8], ids: &[u8]) -> Self {
        let depth: Vec<f32> = bytemuck::pod_collect_to_vec(depth);
        let ids: Vec<u32> = bytemuck::pod_collect_to_vec(ids);
        let (albedo, _) = albedo.as_chunks::<4>();
        let unit = |texel: &[u8; 4]| Vec4::from(texel.map(f32::from)) / 255.0;
        Self {
            depth: depth.iter().map(|&z| Vec4::new(z, 0.0, 0.0, 1.0)).collect(),
            normal,
            albedo: albedo.iter().map(unit).collect(),
            ids: ids.iter().map(|&id| UVec4::new(id, 0, 0, 0)).collect(),
        }
    }
}

/// What the engine has of gibs, once more on the processor.
pub struct Twin {
    gi: Gi,
    exec: Box<dyn Executable>,
    accepted_flip: f64,
}

impl Twin {
    /// # Errors
    /// What gibs says.
    pub fn new(
        scene: &Scene,
        view: &View,
        size: [u32; 2],
        settings: &Settings,
    ) -> Result<Self, RenderError> {
        let backend = gibs_backend_cpu::CpuBackend::new(gibs_backend_cpu::Options::default())?;
        let mut gi = Gi::new(scene, view, size, settings, Screen::Imported)?;
        let mut exec = backend.prepare(gi.schedule().clone())?;
        gi.upload_scene(exec.as_mut())?;
        let accepted_flip = match settings.ray_queries {
            true => ACCEPTED_FLIP_OF_RAY_QUERIES,
            false => ACCEPTED_FLIP,
        };
        Ok(Self {
            gi,
            exec,
            accepted_flip,
        })
    }

    /// Changes something, as the engine does.
    ///
    /// # Errors
    /// What gibs says.
    pub fn change(
        &mut self,
        change: impl FnOnce(&mut Gi, &mut dyn Executable) -> Result<(), RenderError>,
    ) -> Result<(), RenderError> {
        change(&mut self.gi, self.exec.as_mut())
    }

    /// Runs as many frames as the engine has, prints how the light of the last compares with the engine's, and returns
    /// whether it agrees.
    ///
    /// # Errors
    /// What gibs says.
    pub fn agrees(
        &mut self,
        name: &str,
        indirect: &[Vec4],
        surfaces: &Surfaces,
        camera: &Camera,
        host: &HostGbuffer,
        frames: u32,
    ) -> Result<bool, Box<dyn Error>> {
        for (image, bytes) in [
            (HostImage::Depth, bytemuck::cast_slice(&surfaces.depth)),
            (HostImage::Normal, bytemuck::cast_slice(&surfaces.normal)),
            (HostImage::Albedo, bytemuck::cast_slice(&surfaces.albedo)),
            (HostImage::Ids, bytemuck::cast_slice(&surfaces.ids)),
        ] {
            let resource = self.gi.image(image).ok_or("the frame imports nothing")?;
            self.exec.upload(resource, 0, bytes)?;
        }
        for _ in 0..frames {
            self.gi
                .begin_frame(self.exec.as_mut(), camera, Some(host))?;
            self.exec.run()?;
        }
        let resource = self.gi.image(HostImage::Indirect);
        let bytes = self.exec.read(resource.ok_or("nothing is exported")?)?;
        let expected: Vec<Vec4> = bytemuck::pod_collect_to_vec(&bytes);

        let drawn = surfaces.depth.iter().map(|z| z.x != host.depth_clear);
        let mask: Vec<f32> = drawn.map(|drawn| f32::from(u8::from(drawn))).collect();
        let picture = |pixels: &[Vec4]| {
            let [width, height] = self.gi.size();
            let mut picture = Picture::new(width, height);
            let channel = |c: usize| pixels.iter().map(|p| p[c]).collect();
            picture.set_rgb("indirect", [channel(0), channel(1), channel(2)])?;
            picture.set_scalar("mask.A", mask.clone())?;
            Ok::<_, gibs::picture::PictureError>(picture)
        };
        let options = CompareOptions {
            layer: "indirect".into(),
            ..CompareOptions::default()
        };
        let report = compare(&picture(indirect)?, &picture(&expected)?, &options)?;
        let (flip, bias) = (report.metrics.flip, report.metrics.bias);
        let agrees = report.passed() && flip <= self.accepted_flip && bias.abs() <= ACCEPTED_MEAN;
        println!(
            "{name}: FLIP {flip:.5} to the processor's frame of the same G-buffer, mean {:+.2} %: {}",
            bias * 100.0,
            if agrees { "agrees" } else { "DIFFERS" }
        );
        Ok(agrees)
    }
}

/// Largest difference of the mean light that is accepted: surfaces of a rasterizer and of rays differ along edges, and
/// surfels are born in other places.
const ACCEPTED_MEAN: f64 = 0.03;

/// Renders the same frames with traced surfaces on the processor, and prints how the means of indirect irradiance compare,
/// W/m^2.
///
/// # Errors
/// What the renderer says.
pub fn agrees_with_traced(
    name: &str,
    indirect: &[Vec4],
    scene: &Scene,
    view: &View,
    settings: &Settings,
    size: [u32; 2],
    frames: u32,
) -> Result<bool, RenderError> {
    let backend = gibs_backend_cpu::CpuBackend::new(gibs_backend_cpu::Options::default())?;
    let backend: &dyn Backend = &backend;
    let mut traced = Renderer::new(backend, scene, view, size, settings, 0)?;
    for _ in 0..frames {
        traced.frame()?;
    }
    let id = traced.executable().schedule().output("irradiance");
    let bytes = id.map_or(Ok(Vec::new()), |id| traced.executable().read(id))?;
    let expected: Vec<Vec4> = bytemuck::pod_collect_to_vec(&bytes);
    let mean = |pixels: &[Vec4]| {
        let sum: f64 = pixels
            .iter()
            .map(|p| f64::from(p.truncate().element_sum()))
            .sum();
        sum / (3.0 * pixels.len().max(1) as f64)
    };
    let (got, expected) = (mean(indirect), mean(&expected));
    let difference = got / expected - 1.0;
    let agrees = difference.abs() <= ACCEPTED_MEAN && indirect.iter().all(|p| p.is_finite());
    println!(
        "{name}: mean indirect irradiance {got:.4} W/m^2, {expected:.4} with traced surfaces ({:+.2} %): {}",
        difference * 100.0,
        if agrees { "agrees" } else { "DIFFERS" }
    );
    Ok(agrees)
}
