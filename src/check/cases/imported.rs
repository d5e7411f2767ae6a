//! The surfel frame over images that an engine would have drawn.
use super::{Plan, refused};
use crate::renderer::RenderError;
use crate::view::View;
use crate::{Gi, HostImage, Renderer};
use gibs_graph::check::{Case, UploadLog};
use gibs_graph::{Backend, Executable};
use gibs_passes::data::{HostGbuffer, SurfacePoint};
use gibs_passes::frame::{Screen, Settings};
use gibs_passes::scene::Scene;
use gibs_passes::shared::{octahedral, surface};
use glam::{UVec4, Vec3, Vec4};

/// The surfel frame over an engine's images, as the oracle's traced surfaces would be drawn.
pub(super) fn imported(
    name: &str,
    (scene, view): &(Scene, View),
    plan: &Plan,
    settings: &Settings,
    oracle: &dyn Backend,
) -> Result<Case<'static>, RenderError> {
    let mut traced = Renderer::new(oracle, scene, view, plan.size, settings, 0)?;
    traced.frame()?;
    let mut points: Vec<SurfacePoint> = traced.output("points")?;
    // Few scenes have a sky that their camera sees.
    points
        .iter_mut()
        .step_by(SKY)
        .for_each(|p| *p = surface::MISS);
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
    let host = HostGbuffer {
        exposure: 0.5,
        ..HostGbuffer::perspective(0.1, None, true)?
    };
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
            // Irradiance for the engine, and radiance, in turns.
            let host = HostGbuffer {
                radiance: frame % 2,
                ..host
            };
            gi.begin_frame(&mut log, &camera, Some(&host))
                .map_err(refused)?;
            Ok(log.take())
        },
    ))
}

/// Every so many pixels, one is sky.
const SKY: usize = 13;

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
