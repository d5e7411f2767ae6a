//! `apply/count_contrasts`: blocks of pixels across which light differs much (S13).
use crate::data::{Camera, Gathered, SurfacePoint};
use crate::shared::upsample::{self, is_open};
use gibs_graph::{Workgroup, stage};
use glam::UVec2;

stage! {
    /// For each block of 2x2 pixels between whose corners light differs by more than [`upsample::CONTRAST`], how many of its
    /// pixels see a surface and were not selected; zero for the others. Surfaces do not tell of a wall that is thinner than a
    /// pixel and seen from its edge; light does.
    pub stage CountContrasts {
        wgsl: gibs_shaders::stages::COUNT_CONTRASTS,
        workgroup: [64, 1, 1],
        ports: {
            uniform camera: Camera,
            read points: SurfacePoint,
            read selected: u32,
            read gathered: Gathered,
            write contrasts: u32,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    let size = UVec2::new(p.camera.width, p.camera.height);
    for block in group.range(p.contrasts.len() as u32) {
        let pixels = upsample::pixels_of(block as u32, size.x);
        let count = match contrast(p, pixels[0], size) {
            true => pixels
                .iter()
                .filter(|&&at| is_open(&p.points, &p.selected, at, size))
                .count(),
            false => 0,
        };
        p.contrasts.set(block, count as u32);
    }
}

/// Light differs much between the corners of the block that begins at a pixel.
fn contrast(p: &Views<'_>, at: UVec2, size: UVec2) -> bool {
    let (mut least, mut most) = (f32::MAX, 0.0f32);
    for corner in [(0, 0), (2, 0), (0, 2), (2, 2)] {
        let corner = at + UVec2::from(corner);
        let i = (corner.y * size.x + corner.x) as usize;
        if corner.cmplt(size).all() && p.selected[i] != 0 {
            let light = upsample::light(&p.gathered[i]);
            least = least.min(light);
            most = most.max(light);
        }
    }
    most > upsample::CONTRAST * least
}
