//! Small stages, and ways to run them.
#![allow(dead_code, reason = "no test file uses all of it")]
use gibs_backend_cpu::{CpuBackend, Options};
use gibs_graph::{Backend, Executable, Graph, Schedule, WgslSource};
use std::sync::Arc;

pub const NO_KERNEL: WgslSource = WgslSource {
    name: "none",
    text: "",
    modules: &[],
    features: &[],
};

/// Lanes per workgroup of all stages.
pub const LANES: u64 = 64;

macro_rules! stages {
    ($($(#[$meta:meta])* $module:ident $name:ident { $($ports:tt)* } wide($wide:expr) $kernel:item)*) => {
        $($(#[$meta])* pub mod $module {
            use gibs_graph::Workgroup;

            gibs_graph::stage! {
                $(#[$meta])*
                pub stage $name {
                    wgsl: super::NO_KERNEL,
                    workgroup: [64, 1, 1],
                    ports: { $($ports)* },
                    cpu: kernel,
                    wide: $wide,
                }
            }

            $kernel
        })*
    };
}

stages! {
    /// target = 2 source
    double Double { read source: u32, write target: u32 } wide(None)
    fn kernel(p: &Views<'_>, group: Workgroup) {
        for i in group.range(p.source.len() as u32) {
            p.target.set(i, p.source[i].wrapping_mul(2));
        }
    }

    /// Reads one element too far, writes one too far where the source says 7, and takes a count too far where it says 9.
    beyond Beyond { read source: u32, write target: u32, atomic count: u32 } wide(None)
    fn kernel(p: &Views<'_>, group: Workgroup) {
        for i in group.range(p.source.len() as u32) {
            match p.source[i] {
                7 => p.target.set(p.target.len(), 0),
                8 => p.target.set(i, p.source[p.source.len()]),
                9 => drop(p.count.add(p.count.len(), 1)),
                _ => p.target.set(i, 0),
            }
        }
    }

    /// total += step
    accumulate Accumulate { uniform step: [u32; 4], read_write total: u32 } wide(None)
    fn kernel(p: &Views<'_>, group: Workgroup) {
        for i in group.range(p.total.len() as u32) {
            p.total.update(i, |total| *total += p.step[0]);
        }
    }

    /// now = before + 1
    advance Advance { previous before: u32, write now: u32 } wide(None)
    fn kernel(p: &Views<'_>, group: Workgroup) {
        for i in group.range(p.now.len() as u32) {
            p.now.set(i, p.before[i] + 1);
        }
    }

    /// How often each number occurs; numbers beyond the last count as it.
    histogram Histogram { read source: u32, atomic counts: u32 } wide(None)
    fn kernel(p: &Views<'_>, group: Workgroup) {
        for i in group.range(p.source.len() as u32) {
            p.counts.add((p.source[i] as usize).min(p.counts.len() - 1), 1);
        }
    }

    /// Sizes of a dispatch: the source's first three numbers.
    sizes Sizes { read source: u32, write args: gibs_graph::DispatchArgs } wide(None)
    fn kernel(p: &Views<'_>, _: Workgroup) {
        let [x, y, z] = [p.source[0], p.source[1], p.source[2]];
        p.args.set(0, gibs_graph::DispatchArgs { x, y, z, ..Default::default() });
    }

    /// Each workgroup counts itself, and notes its turn (from 1).
    visit Visit { read source: u32, atomic visits: u32, atomic turns: u32, atomic next: u32 } wide(None)
    fn kernel(p: &Views<'_>, group: Workgroup) {
        let at = group.linear() as usize;
        assert!((0..3).all(|axis| group.id[axis] < group.count[axis]));
        p.visits.add(at, 1);
        p.turns.store(at, 1 + p.next.add(0, 1));
    }

    /// Two workgroups write one element: the last of a workgroup, and the first of the next.
    overlap Overlap { read source: u32, write target: u32 } wide(None)
    fn kernel(p: &Views<'_>, group: Workgroup) {
        let range = group.range(p.source.len() as u32);
        for i in range.start..(range.end + 1).min(p.source.len()) {
            p.target.set(i, p.source[i]);
        }
    }

    /// Every lane writes the first element of its workgroup.
    repeat Repeat { read source: u32, write target: u32 } wide(None)
    fn kernel(p: &Views<'_>, group: Workgroup) {
        let range = group.range(p.source.len() as u32);
        for i in range.clone() {
            p.target.set(range.start, p.source[i]);
        }
    }

    /// The same, and reads it.
    add_up AddUp { read source: u32, read_write target: u32 } wide(None)
    fn kernel(p: &Views<'_>, group: Workgroup) {
        let range = group.range(p.source.len() as u32);
        for i in range.clone() {
            p.target.update(range.start, |sum| *sum += p.source[i]);
        }
    }

    /// Says which kernel ran: 1 for the scalar one, 2 for the wide one.
    twins Twins { read source: u32, host_only extra: u32, write target: u32 } wide(Some(super::wide_twin))
    fn kernel(p: &Views<'_>, group: Workgroup) {
        for i in group.range(p.source.len() as u32) {
            p.target.set(i, 1);
        }
    }
}

fn wide_twin(p: &twins::Views<'_>, group: gibs_graph::Workgroup) {
    for i in group.range(p.source.len() as u32) {
        p.target.set(i, 2 + p.extra[0]);
    }
}

pub fn backend(options: Options) -> CpuBackend {
    CpuBackend::new(options).unwrap()
}

/// Ready to run with the default options on two threads.
pub fn prepare(graph: Graph) -> Box<dyn Executable> {
    prepare_with(
        Options {
            threads: Some(2),
            ..Options::default()
        },
        graph,
    )
}

pub fn prepare_with(options: Options, graph: Graph) -> Box<dyn Executable> {
    backend(options).prepare(compile(graph)).unwrap()
}

pub fn compile(graph: Graph) -> Arc<Schedule> {
    Arc::new(graph.compile(None).unwrap())
}

pub fn upload(exec: &mut dyn Executable, key: &str, words: &[u32]) {
    let resource = exec.schedule().resource(key).unwrap();
    exec.upload(resource, 0, gibs_graph::bytemuck::cast_slice(words))
        .unwrap();
}

pub fn read(exec: &mut dyn Executable, key: &str) -> Vec<u32> {
    let resource = exec.schedule().resource(key).unwrap();
    let bytes = exec.read(resource).unwrap();
    bytes
        .chunks(4)
        .map(|word| u32::from_ne_bytes(word.try_into().unwrap()))
        .collect()
}
