//! `spawn/geometric_normals`: which way the surfaces of an engine's G-buffer face (S3).
use crate::data::{Camera, HostGbuffer, SurfacePoint};
use crate::shared::{gbuffer, octahedral};
use crate::stages::import_gbuffer::TILE;
use gibs_graph::{Float, Workgroup, stage};
use glam::{UVec2, Vec3};

stage! {
    /// Finds each pixel's geometric normal from the depths around it, where those are certain enough and agree with the normal given
    /// (GIBS, "Surfel Spawning"), and turns the shading normal to its side. Without this stage both are the normal given. Surfaces that rays
    /// find have theirs from the triangle.
    pub stage GeometricNormals {
        wgsl: gibs_shaders::stages::GEOMETRIC_NORMALS,
        workgroup: [8, 8, 1],
        ports: {
            uniform camera: Camera,
            uniform host: HostGbuffer,
            sampled depth: Float,
            read_write points: SurfacePoint,
        },
        cpu: kernel,
        wide: None,
    }
}

/// Most that a point's offset, in which twice the step of its depth counts, may be over the way to a neighbour for the normal between
/// the two to count: that is off by as many radians at most.
pub const CERTAIN: f32 = 0.125;

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
        let at = UVec2::new(
            group.id[0] * TILE + lane % TILE,
            group.id[1] * TILE + lane / TILE,
        );
        if at.x >= p.camera.width || at.y >= p.camera.height {
            continue;
        }
        let i = (at.y * p.camera.width + at.x) as usize;
        let point = p.points.get(i);
        if point.transform_id != u32::MAX {
            p.points.set(i, faced(p, at, point));
        }
    }
}

/// A point with its normals.
fn faced(p: &Views<'_>, at: UVec2, point: SurfacePoint) -> SurfacePoint {
    let z = p.depth.load(at.x, at.y).x;
    let (position, given) = (point.position, octahedral::unpack(point.shading_normal));
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
    // Far away the steps of a depth buffer are as wide as pixels, and make any plane of a smooth surface.
    let shortest = across.length().min(down.length());
    let flat = match point.offset <= CERTAIN * shortest {
        true => down.cross(across),
        false => Vec3::ZERO,
    };
    let (geometric, shading) = gbuffer::sides(flat, given, position - p.camera.eye);
    SurfacePoint {
        geometric_normal: octahedral::pack(geometric),
        shading_normal: octahedral::pack(shading),
        ..point
    }
}
