//! Holds what an engine got against the same frame with traced surfaces.
use gibs::graph::Backend;
use gibs::passes::frame::Settings;
use gibs::passes::scene::Scene;
use gibs::view::View;
use gibs::{RenderError, Renderer};
use glam::Vec4;

/// Largest difference of the mean light that is accepted: surfaces of a rasterizer and of rays differ along edges, and
/// surfels are born in other places.
const ACCEPTED: f64 = 0.03;

/// Renders the same frames on the CPU and prints how the means of indirect irradiance compare, W/m^2.
///
/// # Errors
/// What the renderer says.
pub fn agrees(
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
    let agrees = difference.abs() <= ACCEPTED && indirect.iter().all(|p| p.is_finite());
    println!(
        "{name}: mean indirect irradiance {got:.4} W/m^2, {expected:.4} with traced surfaces ({:+.2} %): {}",
        difference * 100.0,
        if agrees { "agrees" } else { "DIFFERS" }
    );
    Ok(agrees)
}
