//! The frames that are not of surfels on a screen: the reference, and probes.
use super::Plan;
use super::enriched::sky;
use crate::renderer::{RenderError, Shaders, device_scene};
use crate::view::View;
use gibs_graph::check::{Case, UploadLog};
use gibs_graph::{Executable, Graph, Schedule};
use gibs_passes::data::SurfacePoint;
use gibs_passes::device::{DeviceScene, EnvironmentTable};
use gibs_passes::frame::{
    ProbeFrame, ReferenceUpdate, SceneSizes, probe_frame, reference_frame, upload_probe_frame,
    upload_probes, upload_reference, upload_scene,
};
use gibs_passes::scene::{Camera, Scene};
use gibs_passes::shared::{octahedral, surface};
use glam::Vec3;
use std::sync::Arc;

fn kept(mut g: Graph) -> Result<Arc<Schedule>, RenderError> {
    g.keep_transients();
    Ok(Arc::new(Shaders::default().compile(g)?))
}

/// The path tracer, from points on a plane through what the camera looks at: it needs some, and does not ask which.
pub(super) fn reference(
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
pub(super) fn probes(plan: &Plan) -> Result<Case<'static>, RenderError> {
    let frame = ProbeFrame {
        normals: vec![Vec3::Z, Vec3::X, Vec3::new(-0.6, 0.0, 0.8)],
        per_place: 8,
        rays: 16,
        guide_side: Some(8),
    };
    let table = EnvironmentTable::build(&sky());
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
