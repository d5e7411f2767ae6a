//! `apply/upsample`: every pixel's light from that of the selected ones (S13).
use crate::data::{Camera, Gathered, SurfacePoint};
use crate::shared::surface;
use crate::shared::upsample::{self, is_open};
use gibs_graph::{Workgroup, stage};
use glam::UVec2;

stage! {
    /// What the surfels say at each pixel: at a selected one, and in a block with contrasts, what was gathered there; at
    /// another the mean of the two or four selected ones around it, all of which see its surface. That is bilinear
    /// interpolation.
    pub stage Upsample {
        wgsl: gibs_shaders::stages::UPSAMPLE,
        workgroup: [64, 1, 1],
        ports: {
            uniform camera: Camera,
            read points: SurfacePoint,
            read selected: u32,
            read scanned: u32,
            read packed: Gathered,
            read contrasts: u32,
            read contrasts_scanned: u32,
            read contrasts_packed: Gathered,
            write gathered: Gathered,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    let size = UVec2::new(p.camera.width, p.camera.height);
    for i in group.range(size.x * size.y) {
        let gathered = if p.selected[i] != 0 {
            p.packed[p.scanned[i] as usize]
        } else if surface::is_surface(&p.points[i]) {
            let at = UVec2::new(i as u32 % size.x, i as u32 / size.x);
            let block = upsample::block_of(at, size.x);
            match p.contrasts[block as usize] {
                0 => between(p, at, size.x),
                _ => in_contrast(p, block, at, size),
            }
        } else {
            Gathered::default()
        };
        p.gathered.set(i, gathered);
    }
}

/// What was gathered at a pixel of a block with contrasts.
fn in_contrast(p: &Views<'_>, block: u32, at: UVec2, size: UVec2) -> Gathered {
    let before = upsample::pixels_of(block, size.x).into_iter();
    let before = before.take_while(|&other| other != at);
    let before = before.filter(|&other| is_open(&p.points, &p.selected, other, size));
    p.contrasts_packed[p.contrasts_scanned[block as usize] as usize + before.count()]
}

/// The mean of the selected pixels around one.
fn between(p: &Views<'_>, at: UVec2, width: u32) -> Gathered {
    let (low, high) = upsample::around(at);
    let packed = |x: u32, y: u32| &p.packed[p.scanned[(y * width + x) as usize] as usize];
    upsample::mean([
        packed(low.x, low.y),
        packed(high.x, low.y),
        packed(low.x, high.y),
        packed(high.x, high.y),
    ])
}
