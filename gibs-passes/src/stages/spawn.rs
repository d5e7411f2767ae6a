//! `spawn/write_to_persistent_storage`: new surfels from the G-buffer (S1-S3).
use super::positional_update::radius_at;
use super::resolve_hits::{map_point, map_transposed};
use crate::data::{
    Camera, Frame, GridShape, NONE, SurfacePoint, SurfelBirth, SurfelIrradiance, SurfelPose,
    SurfelSettings, Transform,
};
use crate::shared::{depth, hash, lengths, mark, octahedral, plane, surface};
use gibs_graph::{Workgroup, stage};
use glam::UVec2;

stage! {
    /// Writes each claimed surfel: fixed to the node whose transform id the G-buffer names, with its normal and its plane,
    /// its depth function at the diameter everywhere, no irradiance yet. Its identity is a hash of its quarter of a tile and of the frame.
    pub stage Spawn {
        wgsl: gibs_shaders::stages::SPAWN,
        workgroup: [64, 1, 1],
        ports: {
            uniform camera: Camera,
            uniform frame: Frame,
            uniform grid: GridShape,
            uniform settings: SurfelSettings,
            read claims: UVec2,
            read points: SurfacePoint,
            read transforms: Transform,
            write births: SurfelBirth,
            write poses: SurfelPose,
            write irradiance: SurfelIrradiance,
            optional_write depths: u32,
        },
        cpu: kernel,
        wide: None,
    }
}

/// Marks a claim's place among the hits of rays, where others are pixels.
pub const AT_HIT: u32 = 1 << 31;

/// Sine of the angle from which on a surface counts as rising above a surfel.
pub const RISES: f32 = 0.25;

/// Distance from a pixel's surface to the nearest one in the picture that rises above it, within two target radii, metres: above
/// its plane, and, as the next facet of a coarse mesh does not, above the normal of shading.
/// Irradiance changes over such distances (Ward, Rubinstein and Clear 1988, "A Ray Tracing Solution for Diffuse
/// Interreflection": the harmonic mean distance to surfaces sets the spacing of samples), and a disc that ends at a wall says
/// nothing behind it. Between pixels a surface goes on in its plane, so that the distance is that to the plane, but at most
/// the width of a pixel less than that to the pixel.
fn clearance(p: &Views<'_>, pixel: u32) -> f32 {
    let (width, height) = (p.camera.width, p.camera.height);
    let (x, y) = (pixel % width, pixel / width);
    let reach = (2.0 * p.settings.radius_pixels) as u32;
    let own = &p.points[pixel as usize];
    let position = own.position;
    let normals = [own.geometric_normal, own.shading_normal].map(octahedral::unpack);
    let mut nearest = f32::MAX;
    for row in y.saturating_sub(reach)..=(y + reach).min(height - 1) {
        for column in x.saturating_sub(reach)..=(x + reach).min(width - 1) {
            let point = &p.points[(row * width + column) as usize];
            if !surface::is_surface(point) {
                continue;
            }
            let d = point.position - position;
            let squared = d.dot(d);
            let h = d.dot(normals[0]).min(d.dot(normals[1]));
            if h > 0.0 && h * h > RISES * RISES * squared {
                let across = octahedral::unpack(point.geometric_normal).dot(d).abs();
                let pixel = p.camera.pixel_angle * (point.position - p.camera.eye).length();
                nearest = nearest.min(across.max(squared.sqrt() - pixel));
            }
        }
    }
    nearest
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    for tile in group.range(p.claims.len() as u32) {
        let claim = p.claims[tile];
        if claim.x == NONE {
            continue;
        }
        let slot = claim.x as usize;
        let at_hit = claim.y & AT_HIT;
        let point = &p.points[(claim.y & !AT_HIT) as usize];
        let transform = &p.transforms[point.transform_id as usize];
        let geometric = octahedral::unpack(point.geometric_normal);
        let normal = match p.settings.geometric_normals {
            0 => octahedral::unpack(point.shading_normal),
            _ => geometric,
        };
        let clearance = match at_hit {
            0 => clearance(p, claim.y),
            _ => f32::MAX,
        };
        let lengths = lengths::pack(point.offset, clearance);
        let clearance = lengths::down(lengths);
        let local = |normal| map_transposed(&transform.to_world, normal).normalize();
        p.births.set(
            slot,
            SurfelBirth {
                position: map_point(&transform.to_local, point.position),
                transform_id: point.transform_id,
                normal: octahedral::pack(local(normal)),
                frame: p.frame.number,
                plane: octahedral::pack(local(geometric)),
                lengths,
            },
        );
        let identity = hash::hash3(tile as u32 | at_hit, p.frame.number, p.frame.seed);
        p.poses.set(
            slot,
            SurfelPose {
                position: point.position,
                radius: radius_at(point.position, clearance, p.camera, p.grid, p.settings),
                normal,
                // Nothing hides yet, but in this frame the depth function learns what does.
                mark: mark::of(identity, plane::pack(geometric), false),
            },
        );
        p.irradiance.set(slot, SurfelIrradiance::default());
        if !p.depths.is_empty() {
            let texels = depth::count(p.settings.depth_side);
            (slot * texels..(slot + 1) * texels)
                .for_each(|texel| p.depths.set(texel, depth::UNKNOWN));
        }
    }
}
