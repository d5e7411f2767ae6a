//! `persistent/positional_update`: surfels follow the surfaces that they were born on (S5), and their radius follows
//! the camera (S8).
use super::resolve_hits::{map_point, map_transposed};
use crate::data::{
    Camera, GridShape, SurfelBirth, SurfelDepth, SurfelPose, SurfelSettings, Transform,
};
use crate::shared::{depth, grid, octahedral, recycling};
use gibs_graph::{Workgroup, stage};
use glam::Vec3;

stage! {
    /// Recomputes position, normal and radius of every live surfel from its birth and its node's transform (GIBS,
    /// "Surfelization of the Scene", "Scale"), and counts the frame among those that no pixel has seen it in. The depth
    /// function, whose distances are over the diameter, follows the radius.
    pub stage PositionalUpdate {
        wgsl: gibs_shaders::stages::POSITIONAL_UPDATE,
        workgroup: [64, 1, 1],
        ports: {
            uniform camera: Camera,
            uniform grid: GridShape,
            uniform settings: SurfelSettings,
            read births: SurfelBirth,
            read transforms: Transform,
            read_write poses: SurfelPose,
            read_write unseen: u32,
            optional_read_write depths: SurfelDepth,
        },
        cpu: kernel,
        wide: None,
    }
}

/// Least radius of a surfel beside a wall, over what it would be in the open.
pub const LEAST_SHARE: f32 = 0.25;

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

fn kernel(p: &Views<'_>, group: Workgroup) {
    for i in group.range(p.poses.len() as u32) {
        let pose = p.poses.get(i);
        if pose.radius <= 0.0 {
            continue;
        }
        p.unseen.set(i, p.unseen.get(i).saturating_add(1));
        let birth = &p.births[i];
        // The scene has lost the surfel's node: it goes in this frame.
        let Some(transform) = p.transforms.get(birth.transform_id as usize) else {
            p.unseen.set(i, recycling::LOST);
            continue;
        };
        let position = map_point(&transform.to_world, birth.position);
        let normal =
            map_transposed(&transform.to_local, octahedral::unpack(birth.normal)).normalize();
        let radius = radius_at(position, birth.clearance, p.camera, p.grid, p.settings);
        if radius != pose.radius && !p.depths.is_empty() {
            let depth = depth::rescaled(&p.depths.get(i), pose.radius / radius);
            p.depths.set(i, depth);
        }
        p.poses.set(
            i,
            SurfelPose {
                position,
                radius,
                normal,
                identity: pose.identity,
            },
        );
    }
}
