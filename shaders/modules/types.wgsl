// The element types of the frame's edges; each has the fields of the Rust struct of the same name.

/// Index that stands for nothing.
const NONE: u32 = 0xffffffffu;
/// In place of a pixel where a surfel would be born: a hole in a crowded cell.
const CROWDED: u32 = 0xfffffffeu;
/// Largest finite number.
const F32_MAX: f32 = 0x1.fffffep+127f;

struct DispatchArgs {
    x: u32,
    y: u32,
    z: u32,
    count: u32,
    first: u32,
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

struct BvhNode {
    min: vec3<f32>,
    first: u32,
    max: vec3<f32>,
    count: u32,
}

struct Triangle {
    v0: vec3<f32>,
    primitive: u32,
    e1: vec3<f32>,
    material_flags: u32,
    e2: vec3<f32>,
    transform_id: u32,
}

struct Instance {
    world_to_object: array<vec4<f32>, 3>,
    object_to_world: array<vec4<f32>, 3>,
    root: u32,
    first_triangle: u32,
    transform_id: u32,
    flags: u32,
}

struct Ray {
    origin: vec3<f32>,
    t_min: f32,
    direction: vec3<f32>,
    t_max: f32,
}

struct Hit {
    t: f32,
    u: f32,
    v: f32,
    triangle: u32,
    instance: u32,
}

struct Camera {
    eye: vec3<f32>,
    width: u32,
    right: vec3<f32>,
    height: u32,
    up: vec3<f32>,
    pixel_angle: f32,
    forward: vec3<f32>,
    pad: u32,
}

struct HostGbuffer {
    depth_scale: f32,
    depth_offset: f32,
    depth_clear: f32,
    depth_step: f32,
    jitter: vec2<f32>,
    normals: u32,
    radiance: u32,
    exposure: f32,
    nodes: u32,
    pad1: u32,
    pad2: u32,
}

struct Frame {
    number: u32,
    seed: u32,
    lights: u32,
    lights_per_point: u32,
    environment_side: u32,
    sky_sampled: u32,
    emitter_power: f32,
    samples: u32,
}

struct GridShape {
    centre: vec3<f32>,
    half: f32,
    side: u32,
    slices: u32,
    growth: f32,
    per_octave: f32,
}

struct SurfelSettings {
    capacity: u32,
    ray_budget: u32,
    radius_pixels: f32,
    coverage: f32,
    lookup: u32,
    depth_blend: f32,
    clamp: u32,
    steered: u32,
    stride: u32,
    hit_births: u32,
    debug: u32,
    geometric_normals: u32,
    depth_side: u32,
    fallback: u32,
    guide_side: u32,
    faintest: f32,
}

struct Corners {
    normals: array<u32, 3>,
    smooth_: u32,
    uvs: array<vec2<f32>, 3>,
}

struct Material {
    base_color: vec3<f32>,
    alpha: f32,
    emission: vec3<f32>,
    flags: u32,
    base_u: vec3<f32>,
    base_texels: u32,
    base_v: vec3<f32>,
    base_size: u32,
    emission_u: vec3<f32>,
    emission_texels: u32,
    emission_v: vec3<f32>,
    emission_size: u32,
    cutoff: f32,
    base_sampler: u32,
    emission_sampler: u32,
    pad: u32,
}

struct SurfacePoint {
    position: vec3<f32>,
    offset: f32,
    geometric_normal: u32,
    shading_normal: u32,
    albedo_rg: u32,
    albedo_b_flags: u32,
    emission: vec3<f32>,
    transform_id: u32,
}

struct Light {
    position: vec3<f32>,
    kind: u32,
    intensity: vec3<f32>,
    cos_outer: f32,
    direction: vec3<f32>,
    cos_inner: f32,
}

struct Emitter {
    v0: vec3<f32>,
    cumulative: f32,
    e1: vec3<f32>,
    flags: u32,
    e2: vec3<f32>,
    pad: u32,
    radiance: vec3<f32>,
    pad1: u32,
}

struct LightSample {
    irradiance: vec3<f32>,
    pad: u32,
}

struct Transform {
    to_world: array<vec4<f32>, 3>,
    to_local: array<vec4<f32>, 3>,
}

struct SurfelPose {
    position: vec3<f32>,
    radius: f32,
    normal: vec3<f32>,
    mark: u32,
}

struct SurfelBirth {
    position: vec3<f32>,
    transform_id: u32,
    normal: u32,
    plane: u32,
    frame: u32,
    lengths: u32,
}

struct SurfelIrradiance {
    mean: vec3<f32>,
    samples: u32,
    short_mean: vec3<f32>,
    since: u32,
    variance: f32,
    short_noise: f32,
    drawn: u32,
    pad: u32,
}

struct SurfelLight {
    irradiance: vec3<f32>,
    trust: f32,
}

struct Neighbours {
    mean: vec3<f32>,
    packed: u32,
}

struct Drift {
    sum: f32,
    noise: f32,
    level: f32,
    pad: u32,
}

struct ClampedLight {
    taken: f32,
    brought: f32,
    samples: u32,
    pad: u32,
}

struct Gathered {
    irradiance: vec3<f32>,
    weight: f32,
    average: vec3<f32>,
    confidence: f32,
}

struct DebugPixel {
    value: f32,
    shade: f32,
}

struct Path {
    throughput: vec3<f32>,
    root: u32,
    seed: u32,
    surfel: u32,
    cosine: f32,
    density: f32,
}

struct ReferencePath {
    scale: vec3<f32>,
    segment: u32,
    sample: vec3<f32>,
    seed: u32,
    sum: vec3<f32>,
    done: u32,
    sum_squared: f32,
    largest: f32,
    segments: u32,
    pad: u32,
}

struct SurfelCounters {
    live: u32,
    starved: u32,
    born: u32,
    recycled: u32,
    used: u32,
}
