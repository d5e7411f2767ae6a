//! Stages without kernels, one per way of touching a resource.
#![allow(dead_code, reason = "no test file uses all of it")]
pub mod frame;
pub mod oracle;

use gibs_graph::{Buffer, Dispatch, Graph, Schedule, Step, WgslSource};

/// Elements of the test's buffers.
pub const LEN: u64 = 100;

pub const NO_KERNEL: WgslSource = WgslSource {
    name: "none",
    text: "",
    modules: &[],
    features: &[],
};

macro_rules! stages {
    ($($(#[$meta:meta])* $module:ident $name:ident { $($ports:tt)* })*) => {
        $($(#[$meta])* pub mod $module {
            gibs_graph::stage! {
                $(#[$meta])*
                pub stage $name {
                    wgsl: super::NO_KERNEL,
                    workgroup: [64, 1, 1],
                    ports: { $($ports)* },
                    cpu: kernel,
                    wide: None,
                }
            }

            fn kernel(_: &Views<'_>, _: gibs_graph::Workgroup) {}
        })*
    };
}

stages! {
    /// Reads one, writes another.
    pass Pass { read source: u32, write target: u32 }
    /// Reads two, changes a third.
    merge Merge { read first: u32, read second: u32, read_write target: u32 }
    /// Adds to counters.
    tally Tally { read source: u32, atomic target: u32 }
    /// Reads a value of the frame before.
    recall Recall { previous before: u32, write target: u32 }
    /// Makes the sizes of an indirect dispatch.
    sizes Sizes { read source: u32, write args: gibs_graph::DispatchArgs }
    /// Reads sizes as a uniform.
    batched Batched { uniform batch: gibs_graph::DispatchArgs, read_write target: u32 }
    /// Has a uniform that is too small.
    small Small { uniform config: u32, write target: u32 }
    /// Has a port for wide CPU kernels.
    hosted Hosted { host_only extra: u32, write target: u32 }
}

/// An invocation per element.
pub fn all() -> Dispatch<'static> {
    Dispatch::Elements(LEN)
}

/// A stage that reads `source` and writes `target`.
pub fn pass_on(
    g: &mut Graph,
    label: &str,
    source: &Buffer<u32>,
    target: Buffer<u32>,
) -> Buffer<u32> {
    g.add::<pass::Pass>(label, pass::Inputs { source, target }, all())
        .target
}

/// The schedule, of which the oracle has nothing to say.
pub fn compiled(g: Graph) -> Schedule {
    let schedule = g.compile(None).unwrap();
    assert_eq!(oracle::unsettled(&schedule), []);
    schedule
}

/// The step with this label.
pub fn step<'s>(schedule: &'s Schedule, label: &str) -> (usize, &'s Step) {
    let mut steps = schedule.steps.iter().enumerate();
    let labels = || {
        schedule
            .steps
            .iter()
            .map(|s| s.label.as_str())
            .collect::<Vec<_>>()
    };
    steps
        .find(|(_, step)| step.label == label)
        .unwrap_or_else(|| panic!("{label} in {:?}", labels()))
}

/// Labels of all steps, in order.
pub fn labels(schedule: &Schedule) -> Vec<&str> {
    schedule
        .steps
        .iter()
        .map(|step| step.label.as_str())
        .collect()
}

/// A bar before each step that has a barrier.
pub fn barriers(schedule: &Schedule) -> String {
    let mark = |step: &Step| if step.hazards.is_empty() { '.' } else { '|' };
    schedule.steps.iter().map(mark).collect()
}
