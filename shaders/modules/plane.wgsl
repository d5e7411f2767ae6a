// The plane that a surfel lies in, in 16 bits: the surface's own, where the normal of shading may lean away from it.
import package::octahedral::octahedral_encode;

/// Steps from the middle of the octahedral square to its edge.
const PLANE_STEPS: f32 = 127.0;

/// Sine of the angle below a plane up to which a direction may be above the surface.
const PLANE_OFF: f32 = 0.017;

/// What `plane_unpack` counts in.
const PLANE_STEP: f32 = 1.0 / 128.0;

/// The plane with a normal, up to 0.017 radians off.
fn plane_pack(normal: vec3<f32>) -> u32 {
    let p = octahedral_encode(normal);
    let x = u32(floor((p.x * 0.5 + 0.5) * (2.0 * PLANE_STEPS) + 0.5));
    let y = u32(floor((p.y * 0.5 + 0.5) * (2.0 * PLANE_STEPS) + 0.5));
    return x | (y << 8u);
}

/// A normal of the plane in the low bits of a word, in multiples of a 128th: no unit vector.
fn plane_unpack(bits: u32) -> vec3<f32> {
    let x = f32(bits & 0xffu) - PLANE_STEPS;
    let y = f32((bits >> 8u) & 0xffu) - PLANE_STEPS;
    let z = PLANE_STEPS - abs(x) - abs(y);
    let below = max(-z, 0.0);
    return vec3<f32>(x - select(-below, below, x >= 0.0), y - select(-below, below, y >= 0.0), z) * PLANE_STEP;
}
