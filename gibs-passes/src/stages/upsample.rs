//! `apply/upsample`: every pixel's light from that of the selected ones (S13).
use crate::data::{Camera, Gathered, SurfacePoint};
use crate::shared::{surface, upsample};
use gibs_graph::{Workgroup, stage};
use glam::UVec2;

stage! {
    /// What the surfels say at each pixel: at a selected one what was gathered there, at another the mean of the two or
    /// four selected ones around it, all of which see its surface. That is bilinear interpolation. `contrasts` is 1 for
    /// each block of 2x2 pixels between whose corners light differs by more than [`upsample::CONTRAST`], where the next
    /// frame will not interpolate. The corners are the pixels with even coordinates, its own and the next ones, that see
    /// a surface.
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
            write contrasts: u32,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    let size = UVec2::new(p.camera.width, p.camera.height);
    for i in group.range(size.x * size.y) {
        let at = UVec2::new(i as u32 % size.x, i as u32 / size.x);
        let gathered = if p.selected[i] != 0 {
            p.packed[p.scanned[i] as usize]
        } else if surface::is_surface(&p.points[i]) {
            between(p, at, size.x)
        } else {
            Gathered::default()
        };
        p.gathered.set(i, gathered);
        if at % 2 == UVec2::ZERO {
            let block = upsample::block_of(at, size.x) as usize;
            p.contrasts.set(block, u32::from(contrast(p, at, size)));
        }
    }
}

/// Light differs much between the corners of the block that begins at a pixel.
fn contrast(p: &Views<'_>, at: UVec2, size: UVec2) -> bool {
    let (mut least, mut most) = (f32::MAX, 0.0f32);
    for corner in [(0, 0), (2, 0), (0, 2), (2, 2)] {
        let corner = at + UVec2::from(corner);
        let i = (corner.y * size.x + corner.x) as usize;
        if corner.cmplt(size).all() && p.selected[i] != 0 {
            let light = upsample::light(&p.packed[p.scanned[i] as usize]);
            least = least.min(light);
            most = most.max(light);
        }
    }
    most > upsample::CONTRAST * least
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
