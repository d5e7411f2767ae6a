//! `apply/upsample`: every pixel's light from that of the selected ones (S13).
use crate::data::{Camera, Gathered, SurfacePoint};
use crate::shared::surface;
use crate::shared::upsample;
use gibs_graph::{Workgroup, stage};
use glam::UVec2;

stage! {
    /// What the surfels say at each pixel where nothing was gathered: the mean of the two or four selected ones around it, all of
    /// which see its surface, which is bilinear interpolation; nothing where there is no surface. Selected pixels, and those of a
    /// block with contrasts, keep what they have. Those around an open pixel see its surface and have even coordinates, so that they
    /// are selected: what one invocation reads no other one writes.
    pub stage Upsample {
        wgsl: gibs_shaders::stages::UPSAMPLE,
        workgroup: [64, 1, 1],
        ports: {
            uniform camera: Camera,
            read points: SurfacePoint,
            read selected: u32,
            read contrasts: u32,
            read_write gathered: Gathered,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    let size = UVec2::new(p.camera.width, p.camera.height);
    for i in group.range(size.x * size.y) {
        if p.selected[i] != 0 {
            continue;
        }
        if !surface::is_surface(&p.points[i]) {
            p.gathered.set(i, Gathered::default());
            continue;
        }
        let at = UVec2::new(i as u32 % size.x, i as u32 / size.x);
        if p.contrasts[upsample::block_of(at, size.x) as usize] == 0 {
            p.gathered.set(i, between(p, at, size.x));
        }
    }
}

/// The mean of the selected pixels around one.
fn between(p: &Views<'_>, at: UVec2, width: u32) -> Gathered {
    let (low, high) = upsample::around(at);
    let of = |x: u32, y: u32| p.gathered.get((y * width + x) as usize);
    upsample::mean([
        &of(low.x, low.y),
        &of(high.x, low.y),
        &of(low.x, high.y),
        &of(high.x, high.y),
    ])
}
