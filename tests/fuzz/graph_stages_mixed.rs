//! Stages of floats, structs and images.
use crate::graph_stages::stages;
use gibs_graph::glam::{UVec2, Vec3, Vec4};
use gibs_graph::{Rgba32Float, Uint};

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

stages! {
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
