//! Parts that several frames share: rays to surface points, and direct light at points.
use super::SceneInputs;
use crate::data::{Hit, Ray, SurfacePoint};
use crate::stages::{
    gather_direct, light_batch, primary_rays, resolve_hits, sample_lights, trace_any, trace_closest,
};
use gibs_graph::{Buffer, Dispatch, DispatchArgs, Graph};
use glam::Vec4;

/// How many invocations: a count on the device, and the most that there can be.
pub(crate) struct Batch<'a> {
    pub args: &'a Buffer<DispatchArgs>,
    pub most: u64,
    /// The count is always `most`, so that the host can size the dispatch.
    pub fixed: bool,
}

impl<'a> Batch<'a> {
    /// As many as the device has counted.
    pub fn on_device(args: &'a Buffer<DispatchArgs>, most: u64) -> Self {
        Batch {
            args,
            most,
            fixed: false,
        }
    }

    pub fn dispatch(&self) -> Dispatch<'a> {
        if self.fixed {
            Dispatch::Elements(self.most)
        } else {
            Dispatch::Indirect(self.args)
        }
    }
}

/// The primary surface of every pixel: rays and points.
pub(crate) fn gbuffer(
    g: &mut Graph,
    scene: &SceneInputs,
    pixels: &Batch<'_>,
) -> (Buffer<Ray>, Buffer<SurfacePoint>) {
    let rays = g.transient("gbuffer_rays", pixels.most);
    let inputs = primary_rays::Inputs {
        camera: &scene.camera,
        rays,
    };
    let rays = g
        .add::<primary_rays::PrimaryRays>("gbuffer/primary_rays", inputs, pixels.dispatch())
        .rays;
    let (_, points) = surfaces(g, "gbuffer", "", scene, pixels, &rays);
    (rays, points)
}

/// The closest surface along each ray: hits and points.
pub(crate) fn surfaces(
    g: &mut Graph,
    group: &str,
    suffix: &str,
    scene: &SceneInputs,
    batch: &Batch<'_>,
    rays: &Buffer<Ray>,
) -> (Buffer<Hit>, Buffer<SurfacePoint>) {
    let hits = g.transient(&format!("{group}_hits{suffix}"), batch.most);
    let label = format!("{group}/ray_trace{suffix}");
    let hits = trace(g, &label, scene, batch, rays, hits);
    let points = resolve(g, group, suffix, scene, batch, rays, &hits);
    (hits, points)
}

/// The closest hit of each ray of a batch; other elements of `hits` stay.
pub(crate) fn trace(
    g: &mut Graph,
    label: &str,
    scene: &SceneInputs,
    batch: &Batch<'_>,
    rays: &Buffer<Ray>,
    hits: Buffer<Hit>,
) -> Buffer<Hit> {
    let cut_outs = scene.cut_outs();
    g.add::<trace_closest::TraceClosest>(
        label,
        trace_closest::Inputs {
            batch: batch.args,
            nodes: &scene.nodes,
            triangles: &scene.triangles,
            instances: &scene.instances,
            corners: cut_outs.map(|(corners, _)| corners),
            materials: cut_outs.map(|(_, materials)| materials),
            texels: cut_outs.and(scene.textures()),
            rays,
            hits,
            structure: scene.structure.as_ref(),
            wide_nodes: &scene.wide_nodes,
            wide_packets: &scene.wide_packets,
        },
        batch.dispatch(),
    )
    .hits
}

/// What the surface is like where each ray hit.
pub(crate) fn resolve(
    g: &mut Graph,
    group: &str,
    suffix: &str,
    scene: &SceneInputs,
    batch: &Batch<'_>,
    rays: &Buffer<Ray>,
    hits: &Buffer<Hit>,
) -> Buffer<SurfacePoint> {
    let points = g.transient(&format!("{group}_points{suffix}"), batch.most);
    g.add::<resolve_hits::ResolveHits>(
        &format!("{group}/resolve_hits{suffix}"),
        resolve_hits::Inputs {
            batch: batch.args,
            rays,
            hits,
            triangles: &scene.triangles,
            instances: &scene.instances,
            corners: &scene.corners,
            materials: &scene.materials,
            texels: scene.textures(),
            points,
        },
        batch.dispatch(),
    )
    .points
}

/// Whether nothing stops each ray.
pub(crate) fn visibility(
    g: &mut Graph,
    group: &str,
    suffix: &str,
    scene: &SceneInputs,
    batch: &Batch<'_>,
    rays: &Buffer<Ray>,
) -> Buffer<u32> {
    let cut_outs = scene.cut_outs();
    let visible = g.transient(&format!("{group}_visible{suffix}"), batch.most);
    g.add::<trace_any::TraceAny>(
        &format!("{group}/shadow{suffix}"),
        trace_any::Inputs {
            batch: batch.args,
            nodes: &scene.nodes,
            triangles: &scene.triangles,
            instances: &scene.instances,
            corners: cut_outs.map(|(corners, _)| corners),
            materials: cut_outs.map(|(_, materials)| materials),
            texels: cut_outs.and(scene.textures()),
            rays,
            visible,
            structure: scene.structure.as_ref(),
            wide_nodes: &scene.wide_nodes,
            wide_packets: &scene.wide_packets,
        },
        batch.dispatch(),
    )
    .visible
}

/// Irradiance at each point from punctual lights and the sun; `None` in a scene without.
pub(crate) fn direct_light(
    g: &mut Graph,
    group: &str,
    suffix: &str,
    scene: &SceneInputs,
    per_point: u32,
    batch: &Batch<'_>,
    points: &Buffer<SurfacePoint>,
) -> Option<Buffer<Vec4>> {
    if per_point == 0 {
        return None;
    }
    // With one light a point there are as many samples as points.
    let more = (per_point > 1).then(|| {
        let lights = g.transient(&format!("{group}_light_batch{suffix}"), 1);
        let inputs = light_batch::Inputs {
            batch: batch.args,
            frame: &scene.frame,
            lights,
        };
        let label = format!("{group}/light_batch{suffix}");
        g.add::<light_batch::LightBatch>(&label, inputs, Dispatch::Groups([1, 1, 1]))
            .lights
    });
    let most = batch.most * u64::from(per_point);
    let light_batch = Batch {
        args: more.as_ref().unwrap_or(batch.args),
        most,
        fixed: batch.fixed,
    };
    let rays = g.transient(&format!("{group}_light_rays{suffix}"), most);
    let samples = g.transient(&format!("{group}_light_samples{suffix}"), most);
    let sampled = g.add::<sample_lights::SampleLights>(
        &format!("{group}/sample_lights{suffix}"),
        sample_lights::Inputs {
            batch: light_batch.args,
            frame: &scene.frame,
            points,
            lights: &scene.lights,
            rays,
            samples,
        },
        light_batch.dispatch(),
    );
    let visible = visibility(g, group, suffix, scene, &light_batch, &sampled.rays);
    let direct = g.transient(&format!("{group}_direct{suffix}"), batch.most);
    let gathered = g.add::<gather_direct::GatherDirect>(
        &format!("{group}/gather_direct{suffix}"),
        gather_direct::Inputs {
            batch: batch.args,
            frame: &scene.frame,
            samples: &sampled.samples,
            visible: &visible,
            direct,
        },
        batch.dispatch(),
    );
    Some(gathered.direct)
}
