//! `apply/select_pixels`: the pixels that the surfels light themselves (S13).
use crate::data::{Camera, SurfacePoint};
use crate::shared::{octahedral, surface, upsample};
use crate::simd;
use gibs_graph::{Workgroup, stage};
use glam::UVec2;
use std::ops::Range;

stage! {
    /// Selects the pixels with even coordinates, a quarter of them, and those at edges: where one of the two or four
    /// around a pixel sees another surface than it does, or lies beyond the picture. `selected` is 1 for those.
    pub stage SelectPixels {
        wgsl: gibs_shaders::stages::SELECT_PIXELS,
        workgroup: [64, 1, 1],
        ports: {
            uniform camera: Camera,
            read points: SurfacePoint,
            write selected: u32,
        },
        cpu: kernel,
        wide: Some(wide_kernel),
    }
}

fn wide_kernel(p: &Views<'_>, group: Workgroup) {
    let range = group.range(p.points.len() as u32);
    let set = |i, selected| p.selected.set(i, u32::from(selected));
    simd::select_pixels(p.camera, &p.points, range, set);
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    let range = group.range(p.points.len() as u32);
    let set = |i, selected| p.selected.set(i, u32::from(selected));
    select_each(p.camera, &p.points, range, set);
}

/// Calls `set` with each index of a range, and whether the surfels light this pixel.
#[inline]
pub fn select_each(
    camera: &Camera,
    points: &[SurfacePoint],
    range: Range<usize>,
    mut set: impl FnMut(usize, bool),
) {
    let size = UVec2::new(camera.width, camera.height);
    let at = |i: usize| UVec2::new(i as u32 % size.x, i as u32 / size.x);
    for i in range {
        // There is no picture yet in a frame that nobody described.
        let selected = (i as u32) < size.x * size.y
            && surface::is_surface(&points[i])
            && !between(camera, points, at(i), size);
        set(i, selected);
    }
}

/// The pixel lies between selected ones that see its surface.
#[inline]
fn between(camera: &Camera, points: &[SurfacePoint], at: UVec2, size: UVec2) -> bool {
    let (low, high) = upsample::around(at);
    if low == high || high.x >= size.x || high.y >= size.y {
        return false;
    }
    let here = &points[(at.y * size.x + at.x) as usize];
    let tolerance = upsample::tolerance(here, camera);
    let geometric = octahedral::unpack(here.geometric_normal);
    let shading = octahedral::unpack(here.shading_normal);
    let sees = |x: u32, y: u32| {
        let there = &points[(y * size.x + x) as usize];
        upsample::continuous(here, (geometric, shading), there, tolerance)
    };
    sees(low.x, low.y)
        && sees(high.x, high.y)
        && (low.x == high.x || low.y == high.y || (sees(high.x, low.y) && sees(low.x, high.y)))
}
