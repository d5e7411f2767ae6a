//! `apply/upsample`: every pixel's light from that of the selected ones (S13).
use crate::data::{Camera, Gathered, SurfacePoint};
use crate::shared::{surface, upsample};
use gibs_graph::{Workgroup, stage};
use glam::UVec2;

stage! {
    /// What the surfels say at each pixel: at a selected one what was gathered there, at another the mean of the two or
    /// four selected ones around it, all of which see its surface. That is bilinear interpolation.
    pub stage Upsample {
        wgsl: gibs_shaders::stages::UPSAMPLE,
        workgroup: [64, 1, 1],
        ports: {
            uniform camera: Camera,
            read points: SurfacePoint,
            read selected: u32,
            read scanned: u32,
            read packed: Gathered,
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
            between(p, i as u32, size.x)
        } else {
            Gathered::default()
        };
        p.gathered.set(i, gathered);
    }
}

/// The mean of the selected pixels around one.
fn between(p: &Views<'_>, i: u32, width: u32) -> Gathered {
    let (low, high) = upsample::around(UVec2::new(i % width, i / width));
    let packed = |x: u32, y: u32| &p.packed[p.scanned[(y * width + x) as usize] as usize];
    upsample::mean([
        packed(low.x, low.y),
        packed(high.x, low.y),
        packed(low.x, high.y),
        packed(high.x, high.y),
    ])
}
