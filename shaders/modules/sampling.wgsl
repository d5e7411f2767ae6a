// Directions over the hemisphere.
import package::hash::hash_unit;
import package::portable::portable_sin_cos_turns;
import package::vector::{vector_dot, vector_normalize};

/// Two unit vectors that make a right-handed frame with a third.
struct SamplingBasis {
    tangent: vec3<f32>,
    bitangent: vec3<f32>,
}

/// The frame of the unit vector `n` (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
fn sampling_basis(n: vec3<f32>) -> SamplingBasis {
    let s = select(-1.0, 1.0, n.z >= 0.0);
    let a = -1.0 / (s + n.z);
    let b = n.x * n.y * a;
    return SamplingBasis(
        vec3<f32>(1.0 + s * n.x * n.x * a, s * b, -s * n.x),
        vec3<f32>(b, s + n.y * n.y * a, -n.y),
    );
}

/// From the frame of `n` to the world.
fn sampling_to_world(local: vec3<f32>, n: vec3<f32>) -> vec3<f32> {
    let basis = sampling_basis(n);
    return vector_normalize(basis.tangent * local.x + basis.bitangent * local.y + n * local.z);
}

/// From the world to the frame of `n`.
fn sampling_to_local(world: vec3<f32>, n: vec3<f32>) -> vec3<f32> {
    let basis = sampling_basis(n);
    return vec3<f32>(vector_dot(world, basis.tangent), vector_dot(world, basis.bitangent), vector_dot(world, n));
}

/// A direction about +z with density `cos / pi`, from two numbers in `[0, 1)` (Malley's method).
fn sampling_cosine_hemisphere(u: f32, v: f32) -> vec3<f32> {
    let radius = sqrt(u);
    let turned = portable_sin_cos_turns(v);
    return vec3<f32>(radius * turned.y, radius * turned.x, sqrt(max(1.0 - u, 0.0)));
}

/// Point `index` of the additive recurrence of Roberts 2018 ("The Unreasonable Effectiveness of Quasirandom
/// Sequences"), shifted by `shift`; exact in integers.
fn sampling_r2(index: u32, shift: vec2<u32>) -> vec2<f32> {
    return vec2<f32>(hash_unit(index * 0xc13fa9a9u + shift.x), hash_unit(index * 0x91e10da5u + shift.y));
}

/// Where a ray along `direction` begins that leaves `position` on a surface with geometric normal `n`: `offset` to the
/// side that it leaves to.
fn sampling_start(position: vec3<f32>, n: vec3<f32>, offset: f32, below: f32, direction: vec3<f32>) -> vec3<f32> {
    if vector_dot(n, direction) >= -below {
        return position + n * offset;
    }
    return position - n * offset;
}
