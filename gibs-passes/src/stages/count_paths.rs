//! `persistent/count_paths`: the place of each path that goes on, and how many there are.
use crate::shared::batch::args;
use gibs_graph::{DispatchArgs, Workgroup, stage};

/// Paths per word of `goes_on`.
pub const PATHS_PER_WORD: u32 = 32;

stage! {
    /// Writes for each word of 32 paths how many go on before it, and the size of the dispatch for those that do. One
    /// workgroup counts them all: they are a 32nd of the paths, and most segments have few.
    pub stage CountPaths {
        wgsl: gibs_shaders::stages::COUNT_PATHS,
        workgroup: [256, 1, 1],
        ports: {
            uniform batch: DispatchArgs,
            read goes_on: u32,
            write before: u32,
            write next: DispatchArgs,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, _: Workgroup) {
    let words = p.batch.count.div_ceil(PATHS_PER_WORD) as usize;
    let mut sum = 0;
    for (i, &word) in p.goes_on[..words].iter().enumerate() {
        p.before.set(i, sum);
        sum += word.count_ones();
    }
    p.next.set(0, args(sum));
}
