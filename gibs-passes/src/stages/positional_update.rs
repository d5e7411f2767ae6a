//! `persistent/positional_update`: surfels follow the surfaces that they were born on (S5), and their radius follows
//! the camera (S8).
use super::resolve_hits::{map_point, map_transposed};
use crate::data::{Camera, Frame, GridShape, SurfelBirth, SurfelPose, SurfelSettings, Transform};
use crate::shared::{depth, grid, lengths, mark, octahedral, plane, recycling};
use crate::simd;
use gibs_graph::{Workgroup, stage};
use glam::Vec3;

stage! {
    /// Recomputes position, normal, plane and radius of every live surfel from its birth and its node's transform (GIBS,
    /// "Surfelization of the Scene", "Scale"), and counts the frame among those that no pixel has seen it in. The depth
    /// function, whose distances are over the diameter, follows the radius; where it tells of surfaces close by, which the picture
    /// at its birth need not have shown, a young surfel shrinks. A surfel whose depth function hides nothing within its radius is
    /// marked, so that lookups in this frame leave it out.
    pub stage PositionalUpdate {
        wgsl: gibs_shaders::stages::POSITIONAL_UPDATE,
        workgroup: [64, 1, 1],
        ports: {
            uniform camera: Camera,
            uniform frame: Frame,
            uniform grid: GridShape,
            uniform settings: SurfelSettings,
            read transforms: Transform,
            read_write births: SurfelBirth,
            read_write poses: SurfelPose,
            read_write unseen: u32,
            optional_read_write depths: u32,
        },
        cpu: kernel,
        wide: Some(|p, group| simd::run(#[inline(always)] || kernel(p, group))),
    }
}

/// Least radius of a surfel beside a wall, over what it would be in the open.
pub const LEAST_SHARE: f32 = 0.25;

/// Age, in frames, up to which a surfel shrinks where surfaces are close.
pub const LEARNS_FOR: u32 = 32;

/// Growth in a frame beyond which a surfel learns no more, as if it were older: what it has not seen yet looks close then. A camera
/// that backs away by a thirty-second of its distance in a frame doubles it in 22.
pub const LEARNS_UP_TO: f32 = 1.03125;

/// What is left, in a frame, of the radius of a surfel that is too large for where it is.
pub const SHRINKS_TO: f32 = 0.5;

/// Radius whose projection is `radius_pixels` at this distance from the eye, within what the grid allows, metres.
#[inline]
pub fn radius_at(
    position: Vec3,
    clearance: f32,
    camera: &Camera,
    shape: &GridShape,
    settings: &SurfelSettings,
) -> f32 {
    let wanted = settings.radius_pixels * camera.pixel_angle * (position - camera.eye).length();
    let most = grid::cell_side(position, shape) * grid::RADIUS_SHARE;
    // Never zero, which means a free slot, not even where the eye is.
    let wanted = wanted.clamp(1e-4 * most, most);
    wanted.min(clearance.max(LEAST_SHARE * wanted))
}

#[inline(always)]
fn kernel(p: &Views<'_>, group: Workgroup) {
    let texels = depth::count(p.settings.depth_side);
    for i in group.range(p.poses.len() as u32) {
        let own = i * texels..(i + 1) * texels;
        let depth = || own.clone().map(|texel| p.depths.get(texel));
        let pose = p.poses.get(i);
        if pose.radius <= 0.0 {
            continue;
        }
        p.unseen.set(i, p.unseen.get(i).saturating_add(1));
        let mut birth = p.births.get(i);
        // The scene has lost the surfel's node: it goes in this frame.
        let Some(transform) = p.transforms.get(birth.transform_id as usize) else {
            p.unseen.set(i, recycling::LOST);
            continue;
        };
        let position = map_point(&transform.to_world, birth.position);
        let normal =
            map_transposed(&transform.to_local, octahedral::unpack(birth.normal)).normalize();
        let across =
            map_transposed(&transform.to_local, octahedral::unpack(birth.plane)).normalize();
        let number = p.frame.number;
        let mut clearance = lengths::down(birth.lengths);
        let open = radius_at(position, clearance, p.camera, p.grid, p.settings);
        if open > LEARNS_UP_TO * pose.radius && number.wrapping_sub(birth.frame) < LEARNS_FOR {
            birth.frame = number.wrapping_sub(LEARNS_FOR);
            p.births.set(i, birth);
        }
        let learns = number.wrapping_sub(birth.frame) < LEARNS_FOR;
        if learns && !p.depths.is_empty() && depth::is_crowded(depth()) {
            clearance = clearance.min(SHRINKS_TO * pose.radius);
            birth.lengths = lengths::pack(lengths::up(birth.lengths), clearance);
            clearance = lengths::down(birth.lengths);
            p.births.set(i, birth);
        }
        let radius = radius_at(position, clearance, p.camera, p.grid, p.settings);
        if radius != pose.radius && !p.depths.is_empty() {
            let shrinks = pose.radius / radius;
            for texel in own.clone() {
                p.depths
                    .set(texel, depth::rescaled(p.depths.get(texel), shrinks));
            }
        }
        let open = p.depths.is_empty() || depth::is_open(depth());
        p.poses.set(
            i,
            SurfelPose {
                position,
                radius,
                normal,
                mark: mark::of(mark::identity(pose.mark), plane::pack(across), open),
            },
        );
    }
}
