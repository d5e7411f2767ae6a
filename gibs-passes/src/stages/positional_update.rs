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
    /// marked, so that lookups in this frame leave it out. `gone` is 1 for surfels that [`Recycle`](super::recycle::Recycle) has
    /// chosen, and for those whose node the scene has lost.
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
            write gone: u32,
        },
        cpu: kernel,
        wide: Some(wide_kernel),
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

/// What a surfel's radius depends on, but for the surfel.
#[derive(Clone, Copy)]
pub struct View<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// The grid of the cells.
    pub grid: &'a GridShape,
    /// Settings.
    pub settings: &'a SurfelSettings,
}

/// Surfels where their nodes are now, as large as the clearance of their birth lets them be; marks have the plane alone.
#[inline]
pub fn place_each(
    view: &View<'_>,
    births: &[SurfelBirth; 8],
    transforms: &[&Transform; 8],
) -> [SurfelPose; 8] {
    std::array::from_fn(|lane| {
        let (birth, transform) = (&births[lane], transforms[lane]);
        let position = map_point(&transform.to_world, birth.position);
        let turned =
            |packed| map_transposed(&transform.to_local, octahedral::unpack(packed)).normalize();
        let clearance = lengths::down(birth.lengths);
        SurfelPose {
            position,
            radius: radius_at(position, clearance, view.camera, view.grid, view.settings),
            normal: turned(birth.normal),
            mark: plane::pack(turned(birth.plane)),
        }
    })
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    update(p, group, place_each);
}

fn wide_kernel(p: &Views<'_>, group: Workgroup) {
    simd::run(
        #[inline(always)]
        || update(p, group, simd::place),
    );
}

#[inline(always)]
fn update(
    p: &Views<'_>,
    group: Workgroup,
    place: impl Fn(&View<'_>, &[SurfelBirth; 8], &[&Transform; 8]) -> [SurfelPose; 8],
) {
    let view = View {
        camera: p.camera,
        grid: p.grid,
        settings: p.settings,
    };
    let range = group.range(p.poses.len() as u32);
    for first in range.clone().step_by(8) {
        let slots = first..range.end.min(first + 8);
        let mut stays = 0;
        for i in slots.clone() {
            let (lives, goes) = (p.poses.get(i).radius > 0.0, goes(p, i));
            p.gone.set(i, u32::from(lives && goes));
            stays |= u32::from(lives && !goes) << (i - first);
        }
        if stays == 0 {
            continue;
        }
        // Those that stay have a node; the others need one to be looked up.
        let births = std::array::from_fn(|lane| p.births.get((first + lane).min(range.end - 1)));
        let node = |birth: &SurfelBirth| p.transforms.get(birth.transform_id as usize);
        let Some(any) = births.iter().find_map(node) else {
            continue;
        };
        let transforms = births.each_ref().map(|birth| node(birth).unwrap_or(any));
        let placed = place(&view, &births, &transforms);
        for (lane, i) in slots.enumerate() {
            if stays >> lane & 1 != 0 {
                p.unseen.set(i, recycling::one_more(p.unseen.get(i)));
                follow(p, i, &births[lane], &placed[lane]);
            }
        }
    }
}

/// The surfel in a slot, if there is one, goes.
#[inline(always)]
fn goes(p: &Views<'_>, i: usize) -> bool {
    let node = p.births.get(i).transform_id;
    p.unseen.get(i) == recycling::CHOSEN || node as usize >= p.transforms.len()
}

/// Brings a surfel to its place, with a radius that heeds what its depth function knows.
#[inline(always)]
fn follow(p: &Views<'_>, i: usize, birth: &SurfelBirth, placed: &SurfelPose) {
    let texels = depth::count(p.settings.depth_side);
    let own = i * texels..(i + 1) * texels;
    let depth = || own.clone().map(|texel| p.depths.get(texel));
    let pose = p.poses.get(i);
    let number = p.frame.number;
    let mut radius = placed.radius;
    if number.wrapping_sub(birth.frame) < LEARNS_FOR {
        let mut birth = *birth;
        if radius > LEARNS_UP_TO * pose.radius {
            birth.frame = number.wrapping_sub(LEARNS_FOR);
            p.births.set(i, birth);
        } else if !p.depths.is_empty() && depth::is_crowded(depth()) {
            let clearance = lengths::down(birth.lengths).min(SHRINKS_TO * pose.radius);
            birth.lengths = lengths::pack(lengths::up(birth.lengths), clearance);
            p.births.set(i, birth);
            let clearance = lengths::down(birth.lengths);
            radius = radius_at(placed.position, clearance, p.camera, p.grid, p.settings);
        }
    }
    if radius != pose.radius && !p.depths.is_empty() {
        let shrinks = pose.radius / radius;
        for texel in own.clone() {
            p.depths
                .set(texel, depth::rescaled(p.depths.get(texel), shrinks));
        }
    }
    let open = p.depths.is_empty() || depth::is_open(depth());
    let mark = mark::of(mark::identity(pose.mark), placed.mark, open);
    p.poses.set(
        i,
        SurfelPose {
            radius,
            mark,
            ..*placed
        },
    );
}
