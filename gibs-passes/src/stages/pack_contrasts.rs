//! `apply/pack_contrasts`: the pixels between which light differs much, without gaps (S13).
use crate::data::{Camera, SurfacePoint};
use crate::shared::upsample::{self, is_open};
use gibs_graph::{Workgroup, stage};
use glam::UVec2;

stage! {
    /// Writes the indices of the pixels that [`CountContrasts`](super::count_contrasts::CountContrasts) counted one after the
    /// other, block by block.
    pub stage PackContrasts {
        wgsl: gibs_shaders::stages::PACK_CONTRASTS,
        workgroup: [64, 1, 1],
        ports: {
            uniform camera: Camera,
            read points: SurfacePoint,
            read selected: u32,
            read contrasts: u32,
            read scanned: u32,
            write pixels: u32,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    let size = UVec2::new(p.camera.width, p.camera.height);
    for block in group.range(p.contrasts.len() as u32) {
        if p.contrasts[block] == 0 {
            continue;
        }
        let pixels = upsample::pixels_of(block as u32, size.x).into_iter();
        let open = pixels.filter(|&at| is_open(&p.points, &p.selected, at, size));
        for (slot, at) in (p.scanned[block] as usize..).zip(open) {
            p.pixels.set(slot, at.y * size.x + at.x);
        }
    }
}
