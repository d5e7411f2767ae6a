// Unit vectors in squares (Cigolle et al. 2014, "Survey of Efficient Representations for Independent Unit Vectors").
import package::vector::vector_normalize;

/// Part of a square's side that a step of a packed vector is.
const OCTAHEDRAL_STEP: f32 = 1.0 / 65535.0;

fn octahedral_sign(x: f32) -> f32 {
    return select(-1.0, 1.0, x >= 0.0);
}

fn octahedral_fold(p: vec2<f32>) -> vec2<f32> {
    return vec2<f32>((1.0 - abs(p.y)) * octahedral_sign(p.x), (1.0 - abs(p.x)) * octahedral_sign(p.y));
}

/// Unit vector to `[-1, 1]^2`, the whole sphere.
fn octahedral_encode(n: vec3<f32>) -> vec2<f32> {
    let scale = 1.0 / (abs(n.x) + abs(n.y) + abs(n.z));
    let p = n.xy * scale;
    return select(octahedral_fold(p), p, n.z >= 0.0);
}

/// Inverse of `octahedral_encode`.
fn octahedral_decode(p: vec2<f32>) -> vec3<f32> {
    let z = 1.0 - abs(p.x) - abs(p.y);
    let q = select(octahedral_fold(p), p, z >= 0.0);
    return vector_normalize(vec3<f32>(q, z));
}

/// A unit vector in 32 bits; the angle to the original stays below 1e-4.
fn octahedral_pack(n: vec3<f32>) -> u32 {
    let p = octahedral_encode(n);
    let x = u32(floor((p.x * 0.5 + 0.5) * 65535.0 + 0.5));
    let y = u32(floor((p.y * 0.5 + 0.5) * 65535.0 + 0.5));
    return x | (y << 16u);
}

/// Inverse of `octahedral_pack`.
fn octahedral_unpack(bits: u32) -> vec3<f32> {
    let x = f32(bits & 0xffffu) * OCTAHEDRAL_STEP * 2.0 - 1.0;
    let y = f32(bits >> 16u) * OCTAHEDRAL_STEP * 2.0 - 1.0;
    return octahedral_decode(vec2<f32>(x, y));
}

/// Unit vector of the upper hemisphere (`z >= 0`) to `[0, 1]^2`; nothing at all, which is what a direction straight down is
/// clamped to, to the middle.
fn octahedral_hemisphere_encode(d: vec3<f32>) -> vec2<f32> {
    let sum = max(abs(d.x) + abs(d.y) + d.z, 1e-30);
    let x = d.x / sum;
    let y = d.y / sum;
    return vec2<f32>((x + y) * 0.5 + 0.5, (x - y) * 0.5 + 0.5);
}

/// Inverse of `octahedral_hemisphere_encode`.
fn octahedral_hemisphere_decode(uv: vec2<f32>) -> vec3<f32> {
    let a = uv.x * 2.0 - 1.0;
    let b = uv.y * 2.0 - 1.0;
    let x = (a + b) * 0.5;
    let y = (a - b) * 0.5;
    return vector_normalize(vec3<f32>(x, y, 1.0 - abs(x) - abs(y)));
}
