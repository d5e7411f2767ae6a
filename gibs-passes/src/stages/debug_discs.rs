//! `debug/discs`: surfels on the surfaces that the pixels see, as a debug view shows them (F3).
use crate::data::{Camera, DebugPixel, GridShape, SurfacePoint, SurfelPose, SurfelSettings};
use crate::shared::debug::{self, DebugView};
use crate::shared::depth::{Depth, Depths};
use crate::shared::guide::{Guide, Guides};
use crate::shared::{depth as depths, lists, lookup, octahedral, sampling, surface};
use gibs_graph::{DispatchArgs, Workgroup, stage};
use glam::{UVec2, Vec3};

stage! {
    /// Draws the surfels that a lookup at each pixel's surface visits and whose value is not negative: the one with the
    /// nearest centre of those that overlap the point, or, in views of what a lookup gathers, all of them by their
    /// weights.
    pub stage DebugDiscs {
        wgsl: gibs_shaders::stages::DEBUG_DISCS,
        workgroup: [64, 1, 1],
        ports: {
            uniform batch: DispatchArgs,
            uniform camera: Camera,
            uniform grid: GridShape,
            uniform settings: SurfelSettings,
            read points: SurfacePoint,
            read cells: UVec2,
            read entries: u32,
            read poses: SurfelPose,
            read values: f32,
            optional_read depths: u32,
            optional_read guides: u32,
            write debug: DebugPixel,
        },
        cpu: kernel,
        wide: None,
    }
}

/// How much a disc darkens to its rim in the view that shows discs as such.
const RIM: f32 = 0.6;

/// Share of a disc's radius that its guide is drawn on: about as much as its neighbours leave of it.
const GUIDE_REACH: f32 = 0.5;

/// Mean distance in the direction of a point at `d` from the surfel, as a lookup asks for it; along the normal
/// at the centre, where no lookup asks.
fn mean_distance(depth: Depth<'_>, pose: &SurfelPose, d: Vec3) -> f32 {
    let distance = d.length();
    let local = match distance >= 0.02 * pose.radius {
        true => sampling::to_local(d / distance, pose.normal),
        false => Vec3::Z,
    };
    depths::depth_moments(depth, Vec3::new(local.x, local.y, local.z.max(0.0))).x
}

/// The guide's texel at a point of the disc's middle, which is the hemisphere seen from above; nothing beyond.
fn guide_at(guide: Guide<'_>, pose: &SurfelPose, d: Vec3) -> f32 {
    let local = sampling::to_local(d / (GUIDE_REACH * pose.radius), pose.normal);
    let squared = 1.0 - local.x * local.x - local.y * local.y;
    if squared < 0.0 {
        return debug::NOTHING.value;
    }
    let direction = Vec3::new(local.x, local.y, squared.sqrt());
    guide.texel(guide.texel_of(direction)) as f32 / 255.0
}

/// Summed weight of the surfels that have a value, in the order of a lookup; or the mean of their values.
fn weighted(
    point: Vec3,
    normal: Vec3,
    s: &lists::Surfels<'_>,
    values: &[f32],
    mean: bool,
) -> DebugPixel {
    let (mut weights, mut sum) = (0.0, 0.0);
    for &id in s.around(point).ids {
        let id = id as usize;
        let pose = &s.poses[id];
        let d = point - pose.position;
        let mut weight = lookup::falloff(d, pose) * lookup::alignment(normal, pose);
        let value = values[id];
        if weight <= 0.0 || value < 0.0 {
            continue;
        }
        weight *= lookup::share(s, id, d);
        if weight < lookup::LEAST_WEIGHT {
            continue;
        }
        weights += weight;
        sum += value * weight;
    }
    match mean {
        false => debug::pixel(weights, 1.0),
        true if weights <= 0.0 => debug::NOTHING,
        true => debug::pixel(sum / weights, 1.0),
    }
}

/// The surfel with the nearest centre, of those that have a value and that overlap the point; and the square of its
/// distance.
fn nearest(
    point: Vec3,
    normal: Vec3,
    s: &lists::Surfels<'_>,
    values: &[f32],
) -> Option<(usize, f32)> {
    let mut found = None;
    let mut least = f32::MAX;
    for &id in s.around(point).ids {
        let id = id as usize;
        let pose = &s.poses[id];
        let d = point - pose.position;
        let squared = d.dot(d);
        let overlaps = || lookup::falloff(d, pose) * lookup::alignment(normal, pose) > 0.0;
        if squared < least && values[id] >= 0.0 && overlaps() {
            found = Some((id, squared));
            least = squared;
        }
    }
    found
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    let surfels = lists::Surfels {
        cells: p.cells.slice(),
        entries: p.entries.slice(),
        poses: p.poses.slice(),
        depths: Depths::new(p.depths.slice(), p.settings.depth_side),
        grid: p.grid,
        settings: p.settings,
    };
    let guides = Guides::new(p.guides.slice(), p.settings.guide_side);
    let view = DebugView::of(p.settings.debug);
    let values = p.values.slice();
    for i in group.range(p.batch.count) {
        let point = &p.points[i];
        if !surface::is_surface(point) {
            p.debug.set(i, debug::NOTHING);
            continue;
        }
        let normal = octahedral::unpack(point.shading_normal);
        if let Some(DebugView::Coverage | DebugView::RayCount) = view {
            let mean = view == Some(DebugView::RayCount);
            let pixel = weighted(point.position, normal, &surfels, values, mean);
            p.debug.set(i, pixel);
            continue;
        }
        let Some((id, squared)) = nearest(point.position, normal, &surfels, values) else {
            p.debug.set(i, debug::NOTHING);
            continue;
        };
        let pose = &p.poses[id];
        let d = point.position - pose.position;
        let nothing = debug::NOTHING.value;
        let pixel = match view {
            Some(DebugView::DepthFunction) => {
                let depth = surfels.depths.get(id);
                debug::pixel(depth.map_or(nothing, |f| mean_distance(f, pose, d)), 1.0)
            }
            Some(DebugView::Guide) => {
                let guide = guides.get(id);
                debug::pixel(guide.map_or(nothing, |g| guide_at(g, pose, d)), 1.0)
            }
            Some(DebugView::Surfels) => {
                let rim = squared / (pose.radius * pose.radius);
                let light = debug::headlight(p.camera.eye - point.position, normal);
                debug::pixel(values[id], (1.0 - RIM * rim) * light)
            }
            _ => debug::pixel(values[id], 1.0),
        };
        p.debug.set(i, pixel);
    }
}
