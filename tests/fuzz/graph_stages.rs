//! Small stages with exact results: integers, and floats that are small integers. Each writes every element of what it
//! writes.
pub use crate::graph_stages_mixed::*;
use gibs_graph::DispatchArgs;
use gibs_graph::glam::UVec4;

macro_rules! stages {
    ($($module:ident $name:ident { $($ports:tt)* } wide($wide:expr) $text:literal $kernel:item)*) => {
        $(pub mod $module {
            #[allow(unused_imports, reason = "each uses some")]
            use super::*;
            use gibs_graph::Workgroup;

            gibs_graph::stage! {
                #[doc = stringify!($module)]
                pub stage $name {
                    wgsl: gibs_graph::WgslSource {
                        name: concat!("fuzz ", stringify!($module)),
                        text: $text,
                        modules: &[],
                        features: &[],
                    },
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

pub(crate) use stages;

stages! {
    mix Mix { read a: u32, read b: u32, write target_: u32 } wide(Some(wide_mix))
    "@group(0) @binding(0) var<storage, read> a: array<u32>;
     @group(0) @binding(1) var<storage, read> b: array<u32>;
     @group(0) @binding(2) var<storage, read_write> target_: array<u32>;
     @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
         let i = id.x;
         if i < arrayLength(&target_) {
             target_[i] = a[i % arrayLength(&a)] * 3u + (b[(i * 7u + 1u) % arrayLength(&b)] ^ i);
         }
     }"
    fn kernel(p: &Views<'_>, group: Workgroup) {
        for i in group.range(p.target_.len() as u32) {
            let b = p.b[(i * 7 + 1) % p.b.len()] ^ i as u32;
            p.target_.set(i, p.a[i % p.a.len()].wrapping_mul(3).wrapping_add(b));
        }
    }

    shift Shift { uniform amount: UVec4, read_write total: u32 } wide(None)
    "@group(0) @binding(0) var<uniform> amount: vec4<u32>;
     @group(0) @binding(1) var<storage, read_write> total: array<u32>;
     @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
         if id.x < arrayLength(&total) { total[id.x] = total[id.x] * 5u + amount[id.x % 4u]; }
     }"
    fn kernel(p: &Views<'_>, group: Workgroup) {
        for i in group.range(p.total.len() as u32) {
            p.total.update(i, |x| *x = x.wrapping_mul(5).wrapping_add(p.amount[i % 4]));
        }
    }

    age Age { previous before: u32, write now: u32 } wide(None)
    "@group(0) @binding(0) var<storage, read> before: array<u32>;
     @group(0) @binding(1) var<storage, read_write> now: array<u32>;
     @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
         if id.x < arrayLength(&now) { now[id.x] = 2u * before[id.x % arrayLength(&before)] + 1u; }
     }"
    fn kernel(p: &Views<'_>, group: Workgroup) {
        for i in group.range(p.now.len() as u32) {
            p.now.set(i, p.before[i % p.before.len()].wrapping_mul(2).wrapping_add(1));
        }
    }

    count Count { read source: u32, atomic counts: u32 } wide(None)
    "@group(0) @binding(0) var<storage, read> source: array<u32>;
     @group(0) @binding(1) var<storage, read_write> counts: array<atomic<u32>>;
     @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
         if id.x < arrayLength(&source) {
             let x = source[id.x];
             atomicAdd(&counts[x % arrayLength(&counts)], x);
         }
     }"
    fn kernel(p: &Views<'_>, group: Workgroup) {
        for i in group.range(p.source.len() as u32) {
            let x = p.source[i];
            p.counts.add(x as usize % p.counts.len(), x);
        }
    }

    sums Sums { read source: u32, write target_: u32 } wide(None)
    "@group(0) @binding(0) var<storage, read> source: array<u32>;
     @group(0) @binding(1) var<storage, read_write> target_: array<u32>;
     var<workgroup> sum: atomic<u32>;
     @compute @workgroup_size(64)
     fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
         let i = group.x * 64u + lane;
         if i < arrayLength(&source) { atomicAdd(&sum, source[i]); }
         workgroupBarrier();
         if lane == 0u && group.x < arrayLength(&target_) { target_[group.x] = atomicLoad(&sum) + 1u; }
     }"
    fn kernel(p: &Views<'_>, group: Workgroup) {
        let at = group.linear() as usize;
        let sum = p.source[group.range(p.source.len() as u32)].iter().fold(1_u32, |sum, x| sum.wrapping_add(*x));
        if at < p.target_.len() {
            p.target_.set(at, sum);
        }
    }

    plan Plan { read source: u32, write args: DispatchArgs } wide(None)
    "struct DispatchArgs { x: u32, y: u32, z: u32, count: u32, first: u32, pad0: u32, pad1: u32, pad2: u32 }
     @group(0) @binding(0) var<storage, read> source: array<u32>;
     @group(0) @binding(1) var<storage, read_write> args: array<DispatchArgs>;
     @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
         if id.x < arrayLength(&args) {
             let s = source[id.x % arrayLength(&source)];
             args[id.x] = DispatchArgs(s % 4u, 1u + s / 4u % 2u, 1u + s / 8u % 2u, s / 16u % 200u, s / 64u % 9u, 0u, 0u, 0u);
         }
     }"
    fn kernel(p: &Views<'_>, group: Workgroup) {
        for i in group.range(p.args.len() as u32) {
            let s = p.source[i % p.source.len()];
            p.args.set(i, DispatchArgs {
                x: s % 4,
                y: 1 + s / 4 % 2,
                z: 1 + s / 8 % 2,
                count: s / 16 % 200,
                first: s / 64 % 9,
                ..DispatchArgs::default()
            });
        }
    }

    mark Mark { uniform args: DispatchArgs, read_write marks: u32 } wide(None)
    "struct DispatchArgs { x: u32, y: u32, z: u32, count: u32, first: u32, pad0: u32, pad1: u32, pad2: u32 }
     @group(0) @binding(0) var<uniform> args: DispatchArgs;
     @group(0) @binding(1) var<storage, read_write> marks: array<u32>;
     @compute @workgroup_size(64)
     fn main(@builtin(local_invocation_index) lane: u32, @builtin(workgroup_id) id: vec3<u32>, @builtin(num_workgroups) n: vec3<u32>) {
         let i = ((id.z * n.y + id.y) * n.x + id.x) * 64u + lane;
         if i < args.count && args.first + i < arrayLength(&marks) { marks[args.first + i] += i + n.x; }
     }"
    fn kernel(p: &Views<'_>, group: Workgroup) {
        for i in group.range(p.args.count) {
            let at = p.args.first as usize + i;
            if at < p.marks.len() {
                p.marks.update(at, |x| *x = x.wrapping_add(i as u32 + group.count[0]));
            }
        }
    }

    choose Choose { read source: u32, optional_read extra: u32, write target_: u32, optional_write notes: u32 } wide(None)
    "@group(0) @binding(0) var<storage, read> source: array<u32>;
     @if(extra) @group(0) @binding(1) var<storage, read> extra: array<u32>;
     @group(0) @binding(2) var<storage, read_write> target_: array<u32>;
     @if(notes) @group(0) @binding(3) var<storage, read_write> notes: array<u32>;
     @if(extra) fn more(i: u32) -> u32 { return extra[i % arrayLength(&extra)]; }
     @else fn more(i: u32) -> u32 { return 11u * i; }
     @if(notes) fn note(i: u32) { if i < arrayLength(&notes) { notes[i] = i * i; } }
     @else fn note(i: u32) {}
     @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
         if id.x < arrayLength(&target_) { target_[id.x] = source[id.x % arrayLength(&source)] + more(id.x); }
         note(id.x);
     }"
    fn kernel(p: &Views<'_>, group: Workgroup) {
        for i in group.range(p.target_.len() as u32) {
            let more = if p.extra.is_empty() { 11 * i as u32 } else { p.extra[i % p.extra.len()] };
            p.target_.set(i, p.source[i % p.source.len()].wrapping_add(more));
        }
        for i in group.range(p.notes.len() as u32) {
            p.notes.set(i, (i * i) as u32);
        }
    }
}

fn wide_mix(p: &mix::Views<'_>, group: gibs_graph::Workgroup) {
    let range = group.range(p.target_.len() as u32);
    for i in range.rev() {
        let b = p.b[(i * 7 + 1) % p.b.len()] ^ i as u32;
        let a = p.a[i % p.a.len()];
        p.target_.set(i, a.wrapping_add(a << 1).wrapping_add(b));
    }
}
