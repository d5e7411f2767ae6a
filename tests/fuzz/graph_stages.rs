//! Small stages with exact results: integers, and floats that are small integers. Each writes every element of what it
//! writes.
use gibs_graph::glam::{UVec2, UVec4, Vec3, Vec4};
use gibs_graph::{DispatchArgs, Rgba32Float, Uint};

gibs_graph::element! {
    /// A struct with every kind of member.
    pub struct Row {
        /// A vector of three.
        place: Vec3,
        /// A number that stands behind it without a gap.
        id: u32,
        /// Unsigned numbers.
        pair: UVec2,
        /// Signed numbers.
        signed: [i32; 2],
    }
}

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

    raise Raise { read source: u32, write waves: Vec4 } wide(None)
    "@group(0) @binding(0) var<storage, read> source: array<u32>;
     @group(0) @binding(1) var<storage, read_write> waves: array<vec4<f32>>;
     @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
         let i = id.x;
         if i < arrayLength(&waves) {
             let s = source[i % arrayLength(&source)];
             waves[i] = vec4<f32>(f32(s & 0xffffu), f32(s >> 16u), -f32(i), 0.5);
         }
     }"
    fn kernel(p: &Views<'_>, group: Workgroup) {
        for i in group.range(p.waves.len() as u32) {
            let s = p.source[i % p.source.len()];
            p.waves.set(i, Vec4::new((s & 0xffff) as f32, (s >> 16) as f32, -(i as f32), 0.5));
        }
    }

    turn Turn { read waves: Vec4, write turned: Vec4 } wide(Some(wide_turn))
    "@group(0) @binding(0) var<storage, read> waves: array<vec4<f32>>;
     @group(0) @binding(1) var<storage, read_write> turned: array<vec4<f32>>;
     @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
         if id.x < arrayLength(&turned) {
             let w = waves[id.x % arrayLength(&waves)];
             let small = vec4<f32>(vec4<u32>(abs(w)) & vec4<u32>(0xffffu));
             turned[id.x] = 2.0 * small.yzwx + vec4<f32>(0.25, 1.0, 0.0, -3.0);
         }
     }"
    fn kernel(p: &Views<'_>, group: Workgroup) {
        for i in group.range(p.turned.len() as u32) {
            p.turned.set(i, turned(p.waves[i % p.waves.len()]));
        }
    }

    lower Lower { read waves: Vec4, read_write target_: u32 } wide(None)
    "@group(0) @binding(0) var<storage, read> waves: array<vec4<f32>>;
     @group(0) @binding(1) var<storage, read_write> target_: array<u32>;
     @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
         if id.x < arrayLength(&target_) {
             let w = waves[id.x % arrayLength(&waves)];
             target_[id.x] ^= bitcast<u32>(w.x) + u32(abs(w.z));
         }
     }"
    fn kernel(p: &Views<'_>, group: Workgroup) {
        for i in group.range(p.target_.len() as u32) {
            let w = p.waves[i % p.waves.len()];
            p.target_.update(i, |x| *x ^= w.x.to_bits().wrapping_add(w.z.abs() as u32));
        }
    }

    pack Pack { read source: u32, write rows: Row } wide(None)
    "struct Row { place: vec3<f32>, id: u32, pair: vec2<u32>, signed: array<i32, 2> }
     @group(0) @binding(0) var<storage, read> source: array<u32>;
     @group(0) @binding(1) var<storage, read_write> rows: array<Row>;
     @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
         let i = id.x;
         if i < arrayLength(&rows) {
             let s = source[i % arrayLength(&source)];
             rows[i] = Row(vec3<f32>(f32(s & 0xffu), 1.0, 0.5), i, vec2<u32>(s, ~s), array<i32, 2>(bitcast<i32>(s), -i32(i)));
         }
     }"
    fn kernel(p: &Views<'_>, group: Workgroup) {
        for i in group.range(p.rows.len() as u32) {
            let s = p.source[i % p.source.len()];
            p.rows.set(i, Row {
                place: Vec3::new((s & 0xff) as f32, 1.0, 0.5),
                id: i as u32,
                pair: UVec2::new(s, !s),
                signed: [s.cast_signed(), -(i as i32)],
            });
        }
    }

    unpack Unpack { read rows: Row, write target_: u32 } wide(None)
    "struct Row { place: vec3<f32>, id: u32, pair: vec2<u32>, signed: array<i32, 2> }
     @group(0) @binding(0) var<storage, read> rows: array<Row>;
     @group(0) @binding(1) var<storage, read_write> target_: array<u32>;
     @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
         if id.x < arrayLength(&target_) {
             let r = rows[id.x % arrayLength(&rows)];
             target_[id.x] = u32(r.place.x) + r.id + r.pair.y + bitcast<u32>(r.signed[1]);
         }
     }"
    fn kernel(p: &Views<'_>, group: Workgroup) {
        for i in group.range(p.target_.len() as u32) {
            let r = p.rows[i % p.rows.len()];
            let sum = (r.place.x as u32).wrapping_add(r.id).wrapping_add(r.pair.y);
            p.target_.set(i, sum.wrapping_add(r.signed[1].cast_unsigned()));
        }
    }

    show Show { read source: u32, sampled ids: Uint, stored shown: Rgba32Float } wide(None)
    "@group(0) @binding(0) var<storage, read> source: array<u32>;
     @group(0) @binding(1) var ids: texture_2d<u32>;
     @group(0) @binding(2) var shown: texture_storage_2d<rgba32float, write>;
     @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
         let size = textureDimensions(shown);
         if id.x < size.x * size.y {
             let at = vec2<u32>(id.x % size.x, id.x / size.x);
             let texel = textureLoad(ids, at, 0);
             let s = source[id.x % arrayLength(&source)];
             textureStore(shown, at, vec4<f32>(f32(s & 0xffffu), f32(texel.x & 0xffffu), f32(texel.w & 0xffu), 1.0));
         }
     }"
    fn kernel(p: &Views<'_>, group: Workgroup) {
        let [width, height] = p.shown.size();
        for i in group.range(width * height) {
            let (x, y) = (i as u32 % width, i as u32 / width);
            let texel = p.ids.load(x, y);
            let s = p.source[i % p.source.len()];
            let color = [s & 0xffff, texel.x & 0xffff, texel.w & 0xff, 1];
            p.shown.store(x, y, Vec4::from_array(color.map(|c| c as f32)));
        }
    }
}

fn turned(wave: Vec4) -> Vec4 {
    let small = wave.abs().to_array().map(|x| (x as u32 & 0xffff) as f32);
    let [x, y, z, w] = small;
    Vec4::new(2.0 * y + 0.25, 2.0 * z + 1.0, 2.0 * w, 2.0 * x - 3.0)
}

fn wide_turn(p: &turn::Views<'_>, group: gibs_graph::Workgroup) {
    for i in group.range(p.turned.len() as u32) {
        p.turned.set(i, turned(p.waves[i % p.waves.len()]));
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
