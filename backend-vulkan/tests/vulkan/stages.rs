//! Small stages whose results are known.
//!
//! The CPU kernels are never run here: what a stage gives is stated in each test.

/// A module with a stage of WGSL `$text` over 64 invocations.
macro_rules! stages {
    ($($(#[$meta:meta])* $module:ident $name:ident { $($ports:tt)* } $text:literal)*) => {
        $(pub mod $module {
            gibs_graph::stage! {
                $(#[$meta])*
                pub stage $name {
                    wgsl: gibs_graph::WgslSource {
                        name: stringify!($module),
                        text: $text,
                        modules: &[],
                        features: &[],
                    },
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

gibs_graph::element! {
    /// A uniform.
    pub struct Line {
        /// Factor.
        factor: u32,
        /// Summand.
        offset: u32,
        /// Nothing.
        padding: [u32; 2],
    }
}

stages! {
    /// Doubles every number.
    double Double { read source: u32, write target_: u32 }
    "@group(0) @binding(0) var<storage, read> source: array<u32>;
     @group(0) @binding(1) var<storage, read_write> target_: array<u32>;
     @compute @workgroup_size(64)
     fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
         let i = id.y * groups.x * 64u + id.x;
         if i < arrayLength(&source) { target_[i] = 2u * source[i]; }
     }"

    /// Adds the source to the total.
    accumulate Accumulate { read source: u32, read_write total: u32 }
    "@group(0) @binding(0) var<storage, read> source: array<u32>;
     @group(0) @binding(1) var<storage, read_write> total: array<u32>;
     @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
         if id.x < arrayLength(&source) { total[id.x] += source[id.x]; }
     }"

    /// now = 2 before + 1.
    advance Advance { previous before: u32, write now: u32 }
    "@group(0) @binding(1) var<storage, read_write> now: array<u32>;
     @group(0) @binding(0) var<storage, read> before: array<u32>;
     @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
         if id.x < arrayLength(&before) { now[id.x] = 2u * before[id.x] + 1u; }
     }"

    /// Adds every number to one counter.
    count Count { read source: u32, atomic counter: u32 }
    "@group(0) @binding(0) var<storage, read> source: array<u32>;
     @group(0) @binding(1) var<storage, read_write> counter: array<atomic<u32>>;
     @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
         if id.x < arrayLength(&source) { atomicAdd(&counter[0], source[id.x]); }
     }"

    /// Asks for as many workgroups along each axis as the source says.
    plan Plan { read source: u32, write args: gibs_graph::DispatchArgs }
    "struct DispatchArgs { x: u32, y: u32, z: u32, count: u32, first: u32, pad0: u32, pad1: u32, pad2: u32 }
     @group(0) @binding(0) var<storage, read> source: array<u32>;
     @group(0) @binding(1) var<storage, read_write> args: array<DispatchArgs>;
     @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
         if id.x == 0u { args[0] = DispatchArgs(source[0], source[1], source[2], 0u, 0u, 0u, 0u, 0u); }
     }"

    /// Adds 1 per workgroup, times the step, to one counter.
    tally Tally { read step_: u32, atomic counter: u32 }
    "@group(0) @binding(0) var<storage, read> step_: array<u32>;
     @group(0) @binding(1) var<storage, read_write> counter: array<atomic<u32>>;
     @compute @workgroup_size(64) fn main(@builtin(local_invocation_index) lane: u32) {
         if lane == 0u { atomicAdd(&counter[0], step_[0]); }
     }"

    /// factor source + offset.
    line Affine { uniform line: crate::stages::Line, read source: u32, write target_: u32 }
    "struct Line { factor: u32, offset: u32, padding: vec2<u32> }
     @group(0) @binding(0) var<uniform> line: Line;
     @group(0) @binding(1) var<storage, read> source: array<u32>;
     @group(0) @binding(2) var<storage, read_write> target_: array<u32>;
     @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
         if id.x < arrayLength(&source) { target_[id.x] = line.factor * source[id.x] + line.offset; }
     }"

    /// A uniform made on the device.
    make_line MakeLine { read source: u32, write line: crate::stages::Line }
    "struct Line { factor: u32, offset: u32, padding: array<u32, 2> }
     @group(0) @binding(0) var<storage, read> source: array<u32>;
     @group(0) @binding(1) var<storage, read_write> line: array<Line>;
     @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
         if id.x == 0u { line[0].factor = source[0]; line[0].offset = source[1]; }
     }"

    /// Sum of each workgroup's numbers, through workgroup memory that starts at zero.
    sums Sums { read source: u32, write target_: u32 }
    "@group(0) @binding(0) var<storage, read> source: array<u32>;
     @group(0) @binding(1) var<storage, read_write> target_: array<u32>;
     var<workgroup> sum: atomic<u32>;
     @compute @workgroup_size(64)
     fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(workgroup_id) group: vec3<u32>) {
         if id.x < arrayLength(&source) { atomicAdd(&sum, source[id.x]); }
         workgroupBarrier();
         target_[group.x] = atomicLoad(&sum);
     }"

    /// How many numbers the kernel sees.
    length Length { read source: u32, write target_: u32 }
    "@group(0) @binding(0) var<storage, read> source: array<u32>;
     @group(0) @binding(1) var<storage, read_write> target_: array<u32>;
     @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
         if id.x == 0u { target_[0] = arrayLength(&source); }
     }"

    /// Seen by wide CPU kernels beside a device port.
    beside Beside { read source: u32, host_only tree: u32, write target_: u32 }
    "@group(0) @binding(0) var<storage, read> source: array<u32>;
     @group(0) @binding(1) var<storage, read_write> target_: array<u32>;
     @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
         if id.x < arrayLength(&source) { target_[id.x] = source[id.x] + 1u; }
     }"

    /// Does not parse.
    broken Broken { read source: u32, write target_: u32 }
    "@group(0) @binding(0) var<storage, read> source: array<u32>;
     @compute @workgroup_size(64) fn main() { this is not a shader; }"

    /// Has no binding for its target.
    unbound Unbound { read source: u32, write target_: u32 }
    "@group(0) @binding(0) var<storage, read> source: array<u32>;
     @group(0) @binding(1) var<storage, read_write> elsewhere: array<u32>;
     @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
         elsewhere[id.x] = source[id.x];
     }"

    /// Stores every texel.
    half_texels HalfTexels { sampled source: gibs_graph::Float, stored target_: gibs_graph::Rgba16Float }
    "@group(0) @binding(0) var source: texture_2d<f32>;
     @group(0) @binding(1) var target_: texture_storage_2d<rgba16float, write>;
     @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
         let size = textureDimensions(source);
         let at = vec2(id.x % size.x, id.x / size.x);
         if at.y < size.y { textureStore(target_, at, textureLoad(source, at, 0)); }
     }"

    /// Stores every texel.
    full_texels FullTexels { sampled source: gibs_graph::Float, stored target_: gibs_graph::Rgba32Float }
    "@group(0) @binding(0) var source: texture_2d<f32>;
     @group(0) @binding(1) var target_: texture_storage_2d<rgba32float, write>;
     @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
         let size = textureDimensions(source);
         let at = vec2(id.x % size.x, id.x / size.x);
         if at.y < size.y { textureStore(target_, at, textureLoad(source, at, 0)); }
     }"

    /// Stores every texel.
    byte_texels ByteTexels { sampled source: gibs_graph::Float, stored target_: gibs_graph::Rgba8Unorm }
    "@group(0) @binding(0) var source: texture_2d<f32>;
     @group(0) @binding(1) var target_: texture_storage_2d<rgba8unorm, write>;
     @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
         let size = textureDimensions(source);
         let at = vec2(id.x % size.x, id.x / size.x);
         if at.y < size.y { textureStore(target_, at, textureLoad(source, at, 0)); }
     }"

    /// The bits of every texel.
    texel_bits TexelBits { sampled source: gibs_graph::Float, write target_: [u32; 4] }
    "@group(0) @binding(0) var source: texture_2d<f32>;
     @group(0) @binding(1) var<storage, read_write> target_: array<vec4<u32>>;
     @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
         let size = textureDimensions(source);
         let at = vec2(id.x % size.x, id.x / size.x);
         if at.y < size.y { target_[id.x] = bitcast<vec4<u32>>(textureLoad(source, at, 0)); }
     }"

    /// Every texel.
    texel_ids TexelIds { sampled source: gibs_graph::Uint, write target_: [u32; 4] }
    "@group(0) @binding(0) var source: texture_2d<u32>;
     @group(0) @binding(1) var<storage, read_write> target_: array<vec4<u32>>;
     @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
         let size = textureDimensions(source);
         let at = vec2(id.x % size.x, id.x / size.x);
         if at.y < size.y { target_[id.x] = textureLoad(source, at, 0); }
     }"
}
