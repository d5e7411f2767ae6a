//! `apply/pack_pixels`: the selected pixels, without gaps (S13).
use gibs_graph::{Workgroup, stage};

stage! {
    /// Writes the indices of the selected pixels one after the other, in the order of the picture.
    pub stage PackPixels {
        wgsl: gibs_shaders::stages::PACK_PIXELS,
        workgroup: [64, 1, 1],
        ports: {
            read selected: u32,
            read scanned: u32,
            write pixels: u32,
        },
        cpu: kernel,
        wide: Some(wide_kernel),
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    for i in group.range(p.selected.len() as u32) {
        if p.selected[i] != 0 {
            p.pixels.set(p.scanned[i] as usize, i as u32);
        }
    }
}

/// Pixels of a workgroup.
const LANES: usize = 64;

/// One that is not selected is written over by the next one, so that no branch depends on which are.
fn wide_kernel(p: &Views<'_>, group: Workgroup) {
    let range = group.range(p.selected.len() as u32);
    let Some(&first) = p.scanned.get(range.start) else {
        return;
    };
    let mut pixels = [0; LANES];
    let mut count = 0;
    for (i, &selected) in range.clone().zip(&p.selected[range]) {
        pixels[count % LANES] = i as u32;
        count += usize::from(selected != 0);
    }
    for (slot, &pixel) in (first as usize..).zip(&pixels[..count]) {
        p.pixels.set(slot, pixel);
    }
}
