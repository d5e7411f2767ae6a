//! Small stages for the tests. Their CPU kernels do nothing: only devices run here.
// Every test program uses some of them.
#![allow(dead_code)]
use gibs_graph::WgslSource;

const fn source(name: &'static str, text: &'static str) -> WgslSource {
    WgslSource {
        name,
        text,
        modules: &[],
        features: &[],
    }
}

pub mod double {
    gibs_graph::stage! {
        /// Doubles every number.
        pub stage Double {
            wgsl: super::source("double", "
                @group(0) @binding(0) var<storage, read> numbers: array<u32>;
                @group(0) @binding(1) var<storage, read_write> doubled: array<u32>;
                @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
                    if id.x < arrayLength(&doubled) { doubled[id.x] = 2u * numbers[id.x]; }
                }"),
            workgroup: [64, 1, 1],
            ports: { read numbers: u32, write doubled: u32 },
            cpu: nothing,
            wide: None,
        }
    }
    fn nothing(_: &Views<'_>, _: gibs_graph::Workgroup) {}
}

pub mod add {
    gibs_graph::stage! {
        /// Adds a number to every total. Its bindings are not in the order of the ports.
        pub stage Add {
            wgsl: super::source("add", "
                @group(0) @binding(1) var<uniform> amount: vec4<u32>;
                @group(0) @binding(0) var<storage, read_write> totals: array<u32>;
                @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
                    if id.x < arrayLength(&totals) { totals[id.x] += amount.x; }
                }"),
            workgroup: [64, 1, 1],
            ports: { uniform amount: glam::UVec4, read_write totals: u32 },
            cpu: nothing,
            wide: None,
        }
    }
    fn nothing(_: &Views<'_>, _: gibs_graph::Workgroup) {}
}

pub mod age {
    gibs_graph::stage! {
        /// One more than the frame before.
        pub stage Age {
            wgsl: super::source("age", "
                @group(0) @binding(0) var<storage, read> before: array<u32>;
                @group(0) @binding(1) var<storage, read_write> now: array<u32>;
                @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
                    if id.x < arrayLength(&now) { now[id.x] = before[id.x] + 1u; }
                }"),
            workgroup: [64, 1, 1],
            ports: { previous before: u32, write now: u32 },
            cpu: nothing,
            wide: None,
        }
    }
    fn nothing(_: &Views<'_>, _: gibs_graph::Workgroup) {}
}

pub mod count_odd {
    gibs_graph::stage! {
        /// Counts the odd numbers.
        pub stage CountOdd {
            wgsl: super::source("count_odd", "
                @group(0) @binding(0) var<storage, read> numbers: array<u32>;
                @group(0) @binding(1) var<storage, read_write> count: array<atomic<u32>>;
                @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
                    if id.x < arrayLength(&numbers) && (numbers[id.x] & 1u) == 1u { atomicAdd(&count[0], 1u); }
                }"),
            workgroup: [64, 1, 1],
            ports: { read numbers: u32, atomic count: u32 },
            cpu: nothing,
            wide: None,
        }
    }
    fn nothing(_: &Views<'_>, _: gibs_graph::Workgroup) {}
}

pub mod plan {
    gibs_graph::stage! {
        /// Makes the sizes of a dispatch from a count.
        pub stage Plan {
            wgsl: super::source("plan", "
                struct DispatchArgs { x: u32, y: u32, z: u32, count: u32, first: u32, pad0: u32, pad1: u32, pad2: u32 }
                @group(0) @binding(0) var<storage, read> count: array<u32>;
                @group(0) @binding(1) var<storage, read_write> plan: array<DispatchArgs>;
                @compute @workgroup_size(1) fn main() {
                    plan[0] = DispatchArgs((count[0] + 63u) / 64u, 1u, 1u, count[0], 0u, 0u, 0u, 0u);
                }"),
            workgroup: [1, 1, 1],
            ports: { read count: u32, write plan: gibs_graph::DispatchArgs },
            cpu: nothing,
            wide: None,
        }
    }
    fn nothing(_: &Views<'_>, _: gibs_graph::Workgroup) {}
}

pub mod mark {
    gibs_graph::stage! {
        /// Marks as many elements as were planned.
        pub stage Mark {
            wgsl: super::source("mark", "
                struct DispatchArgs { x: u32, y: u32, z: u32, count: u32, first: u32, pad0: u32, pad1: u32, pad2: u32 }
                @group(0) @binding(0) var<uniform> plan: DispatchArgs;
                @group(0) @binding(1) var<storage, read_write> marks: array<u32>;
                @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
                    if id.x < plan.count { marks[id.x] = 1u; }
                }"),
            workgroup: [64, 1, 1],
            ports: { uniform plan: gibs_graph::DispatchArgs, read_write marks: u32 },
            cpu: nothing,
            wide: None,
        }
    }
    fn nothing(_: &Views<'_>, _: gibs_graph::Workgroup) {}
}

/// Stages that cannot be built.
pub mod broken {
    pub mod syntax {
        gibs_graph::stage! {
            /// Does not parse.
            pub stage Syntax {
                wgsl: crate::stages::source("syntax", "
                    @group(0) @binding(0) var<storage, read> numbers: array<u32>;
                    @group(0) @binding(1) var<storage, read_write> doubled: array<u32>;
                    @compute @workgroup_size(64) fn main() { doubled[0] = numbers[0] }"),
                workgroup: [64, 1, 1],
                ports: { read numbers: u32, write doubled: u32 },
                cpu: nothing,
                wide: None,
            }
        }
        fn nothing(_: &Views<'_>, _: gibs_graph::Workgroup) {}
    }

    pub mod unnamed {
        gibs_graph::stage! {
            /// Has no global for one of its ports.
            pub stage Unnamed {
                wgsl: crate::stages::source("unnamed", "
                    @group(0) @binding(0) var<storage, read> numbers: array<u32>;
                    @group(0) @binding(1) var<storage, read_write> twice: array<u32>;
                    @compute @workgroup_size(64) fn main() { twice[0] = numbers[0]; }"),
                workgroup: [64, 1, 1],
                ports: { read numbers: u32, write doubled: u32 },
                cpu: nothing,
                wide: None,
            }
        }
        fn nothing(_: &Views<'_>, _: gibs_graph::Workgroup) {}
    }

    pub mod refused {
        gibs_graph::stage! {
            /// Writes what its ports say it only reads: fine WGSL, which the pipeline layout refuses.
            pub stage Refused {
                wgsl: crate::stages::source("refused", "
                    @group(0) @binding(0) var<storage, read_write> numbers: array<u32>;
                    @group(0) @binding(1) var<storage, read_write> doubled: array<u32>;
                    @compute @workgroup_size(64) fn main() { numbers[0] = 1u; doubled[0] = 1u; }"),
                workgroup: [64, 1, 1],
                ports: { read numbers: u32, write doubled: u32 },
                cpu: nothing,
                wide: None,
            }
        }
        fn nothing(_: &Views<'_>, _: gibs_graph::Workgroup) {}
    }
}
