//! `gbuffer/import`: an engine's G-buffer as surface points.
use crate::data::{Camera, HostGbuffer, SurfacePoint};
use crate::shared::{gbuffer, octahedral, surface};
use gibs_graph::{Float, ImageView, Uint, Workgroup, stage};
use glam::{UVec2, Vec3, Vec4};

stage! {
    /// Decodes depth, normal, albedo and transform id of every pixel; see [`HostGbuffer`] for the conventions. Both normals
    /// are the one given, on the side that is seen, until [`super::geometric_normals::GeometricNormals`] tells them apart.
    pub stage ImportGbuffer {
        wgsl: gibs_shaders::stages::IMPORT_GBUFFER,
        workgroup: [8, 8, 1],
        ports: {
            uniform camera: Camera,
            uniform host: HostGbuffer,
            sampled depth: Float,
            sampled normal: Float,
            sampled albedo: Float,
            sampled ids: Uint,
            write points: SurfacePoint,
        },
        cpu: kernel,
        wide: None,
    }
}

/// Side of a workgroup, texels.
pub const TILE: u32 = 8;

fn kernel(p: &Views<'_>, group: Workgroup) {
    for lane in 0..TILE * TILE {
        let x = group.id[0] * TILE + lane % TILE;
        let y = group.id[1] * TILE + lane / TILE;
        if x >= p.camera.width || y >= p.camera.height {
            continue;
        }
        let at = UVec2::new(x, y);
        let i = (y * p.camera.width + x) as usize;
        p.points.set(i, point(p, at));
    }
}

fn load<T: gibs_graph::Sampled<Value = Vec4>>(image: &ImageView<'_, T>, at: UVec2) -> Vec4 {
    image.load(at.x, at.y)
}

fn point(p: &Views<'_>, at: UVec2) -> SurfacePoint {
    let z = load(&p.depth, at).x;
    let id = p.ids.load(at.x, at.y).x;
    if z == p.host.depth_clear || id >= p.host.nodes {
        return surface::MISS;
    }
    let position = gbuffer::position(at, z, p.camera, p.host);
    let given = gbuffer::normal(load(&p.normal, at), p.host);
    let normal = octahedral::pack(gbuffer::facing(given, position - p.camera.eye));
    let (albedo_rg, albedo_b_flags) = surface::pack_albedo(load(&p.albedo, at).truncate(), 0);
    SurfacePoint {
        position,
        offset: gbuffer::offset(position, z, p.camera, p.host),
        geometric_normal: normal,
        shading_normal: normal,
        albedo_rg,
        albedo_b_flags,
        emission: Vec3::ZERO,
        transform_id: id,
    }
}
