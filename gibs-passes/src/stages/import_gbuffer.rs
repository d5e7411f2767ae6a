//! `gbuffer/import`: an engine's G-buffer as surface points.
use crate::data::{Camera, HostGbuffer, SurfacePoint};
use crate::shared::{gbuffer, octahedral, surface};
use gibs_graph::{Float, ImageView, Uint, Workgroup, stage};
use glam::{UVec2, Vec3, Vec4};

stage! {
    /// Decodes depth, normal, albedo and transform id of every pixel; see [`HostGbuffer`] for the conventions. The
    /// geometric normal is that of the depths around the pixel, where they agree with the normal given.
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

/// A point some texels away along one axis, and how much deeper it is; beyond the edge and where nothing was drawn,
/// nothing.
fn neighbour(p: &Views<'_>, at: UVec2, z: f32, dx: i32, dy: i32) -> Option<(Vec3, f32)> {
    let x =
        at.x.checked_add_signed(dx)
            .filter(|x| *x < p.camera.width)?;
    let y =
        at.y.checked_add_signed(dy)
            .filter(|y| *y < p.camera.height)?;
    let depth = p.depth.load(x, y).x;
    if depth == p.host.depth_clear {
        return None;
    }
    let here = gbuffer::view_depth(z, p.host);
    let there = gbuffer::view_depth(depth, p.host);
    Some((
        gbuffer::position(UVec2::new(x, y), depth, p.camera, p.host),
        (there - here).abs(),
    ))
}

/// The way to the nearer of two neighbours, along the positive axis.
fn way(position: Vec3, before: Option<(Vec3, f32)>, after: Option<(Vec3, f32)>) -> Vec3 {
    match (before, after) {
        (Some((b, near)), Some((_, far))) if near < far => position - b,
        (_, Some((a, _))) => a - position,
        (Some((b, _)), None) => position - b,
        (None, None) => Vec3::ZERO,
    }
}

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
    let across = way(
        position,
        neighbour(p, at, z, -1, 0),
        neighbour(p, at, z, 1, 0),
    );
    let down = way(
        position,
        neighbour(p, at, z, 0, -1),
        neighbour(p, at, z, 0, 1),
    );
    let (geometric, shading) = gbuffer::sides(down.cross(across), given, position - p.camera.eye);
    let (albedo_rg, albedo_b_flags) = surface::pack_albedo(load(&p.albedo, at).truncate(), 0);
    SurfacePoint {
        position,
        offset: gbuffer::offset(position, z, p.camera, p.host),
        geometric_normal: octahedral::pack(geometric),
        shading_normal: octahedral::pack(shading),
        albedo_rg,
        albedo_b_flags,
        emission: Vec3::ZERO,
        transform_id: id,
    }
}
