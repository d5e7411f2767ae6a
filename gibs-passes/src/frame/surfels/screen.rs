//! The surfaces that are seen, and their light: the ends of the frame.
use super::{Grid, Light, Screen, SurfelFrame, Surfels, gather, upsample};
use crate::data::*;
use crate::frame::SceneInputs;
use crate::frame::trace::{Batch, direct_light, gbuffer};
use crate::stages::*;
use gibs_graph::{Buffer, Dispatch, Float, Graph, Rgba16Float, Uint};

/// What is seen.
pub(super) struct Seen {
    pub points: Buffer<SurfacePoint>,
    by: By,
}

/// How it was found.
enum By {
    Rays(Buffer<Ray>),
    Host(Buffer<HostGbuffer>),
}

/// What is seen, lit.
pub(super) struct Lit {
    pub points: Buffer<SurfacePoint>,
    pub gathered: Buffer<Gathered>,
    pub light: Light,
}

fn pixels(frame: &SurfelFrame) -> u64 {
    u64::from(frame.size[0]) * u64::from(frame.size[1])
}

fn batch<'a>(scene: &'a SceneInputs, frame: &SurfelFrame) -> Batch<'a> {
    Batch {
        args: &scene.pixels,
        most: pixels(frame),
        fixed: true,
    }
}

/// Finds the surfaces.
pub(super) fn see(g: &mut Graph, scene: &SceneInputs, frame: &SurfelFrame) -> Seen {
    if frame.screen == Screen::Traced {
        let (rays, points) = gbuffer(g, scene, &batch(scene, frame));
        return Seen {
            points,
            by: By::Rays(rays),
        };
    }
    let host = g.input("host", 1);
    let depth = g.import_image::<Float>("host_depth", frame.size);
    let normal = g.import_image::<Float>("host_normal", frame.size);
    let albedo = g.import_image::<Float>("host_albedo", frame.size);
    let ids = g.import_image::<Uint>("host_ids", frame.size);
    let points = g.transient("gbuffer_points", pixels(frame));
    let imported = g.add::<import_gbuffer::ImportGbuffer>(
        "gbuffer/import",
        import_gbuffer::Inputs {
            camera: &scene.camera,
            host: &host,
            depth: &depth,
            normal: &normal,
            albedo: &albedo,
            ids: &ids,
            points,
        },
        tiles(frame, import_gbuffer::TILE),
    );
    let faced = g.add::<geometric_normals::GeometricNormals>(
        "spawn/geometric_normals",
        geometric_normals::Inputs {
            camera: &scene.camera,
            host: &host,
            depth: &depth,
            points: imported.points,
        },
        tiles(frame, import_gbuffer::TILE),
    );
    Seen {
        points: faced.points,
        by: By::Host(host),
    }
}

fn tiles(frame: &SurfelFrame, side: u32) -> Dispatch<'static> {
    let [width, height] = frame.size.map(|n| n.div_ceil(side));
    Dispatch::Groups([width, height, 1])
}

/// Lights the surfaces.
#[allow(clippy::too_many_arguments, reason = "the ports of the stages")]
pub(super) fn apply(
    g: &mut Graph,
    scene: &SceneInputs,
    frame: &SurfelFrame,
    grid: &Grid,
    settings: &Buffer<SurfelSettings>,
    surfels: &Surfels,
    seen: Seen,
    per_point: u32,
) -> Lit {
    let pixel_batch = batch(scene, frame);
    let Seen { points, by } = seen;
    let light = |g: &mut Graph,
                 suffix: &str,
                 batch: &Batch<'_>,
                 pixels: Option<&Buffer<u32>>,
                 gathered: Buffer<Gathered>| {
        let label = format!("apply/lighting_apply{suffix}");
        gather(
            g, &label, grid, settings, surfels, batch, &points, pixels, gathered,
        )
    };
    let gathered = g.transient("apply_gathered", pixels(frame));
    let gathered = if frame.settings.half_resolution {
        upsample::at_half_resolution(g, scene, &points, frame.size, gathered, light)
    } else {
        light(g, "", &pixel_batch, None, gathered)
    };
    let rays = match by {
        By::Rays(rays) => rays,
        By::Host(host) => {
            let indirect = g.export_image::<Rgba16Float>("host_indirect", frame.size);
            let exported = g.add::<export_indirect::ExportIndirect>(
                "apply/export",
                export_indirect::Inputs {
                    camera: &scene.camera,
                    host: &host,
                    points: &points,
                    gathered: &gathered,
                    indirect,
                },
                tiles(frame, export_indirect::TILE),
            );
            g.output_image("host_indirect", &exported.indirect);
            let light = Light::Imported {
                indirect: exported.indirect,
            };
            return Lit {
                points,
                gathered,
                light,
            };
        }
    };
    let direct = direct_light(g, "apply", "", scene, per_point, &pixel_batch, &points);
    let irradiance = g.transient("irradiance", pixels(frame));
    let color = g.transient("color", pixels(frame));
    let composed = g.add::<compose::Compose>(
        "apply/compose",
        compose::Inputs {
            batch: &scene.pixels,
            frame: &scene.frame,
            rays: &rays,
            points: &points,
            direct: direct.as_ref(),
            gathered: &gathered,
            environment: scene.sky(),
            irradiance,
            color,
        },
        pixel_batch.dispatch(),
    );
    g.output("points", &points);
    if let Some(direct) = &direct {
        g.output("direct", direct);
    }
    g.output("irradiance", &composed.irradiance);
    g.output("color", &composed.color);
    Lit {
        points,
        gathered,
        light: Light::Traced {
            direct,
            irradiance: composed.irradiance,
            color: composed.color,
        },
    }
}
