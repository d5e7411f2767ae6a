// The environment as an octahedral map: `xyz` is radiance, W/(m^2 sr); `w` is the density of emitter sampling per area
// of the square `[-1, 1]^2`. Reads the stage's global `environment`.
import package::octahedral::{octahedral_decode, octahedral_encode};

fn environment_at(x: f32, side: u32) -> u32 {
    return min(u32(max((x * 0.5 + 0.5) * f32(side), 0.0)), side - 1u);
}

/// The texel that a direction falls into.
fn environment_texel(side: u32, direction: vec3<f32>) -> vec4<f32> {
    let p = octahedral_encode(direction);
    return environment[environment_at(p.y, side) * side + environment_at(p.x, side)];
}

/// Direction at a point of a texel; `u` and `v` in `[0, 1)`.
fn environment_direction(side: u32, x: u32, y: u32, u: f32, v: f32) -> vec3<f32> {
    let size = f32(side);
    return octahedral_decode(vec2<f32>((f32(x) + u) / size * 2.0 - 1.0, (f32(y) + v) / size * 2.0 - 1.0));
}

/// Solid angle per area of the octahedral square `[-1, 1]^2` at a direction: with `s = |x| + |y| + |z|` of the unit
/// vector, `s^3`.
fn environment_solid_angle_per_area(direction: vec3<f32>) -> f32 {
    let s = abs(direction.x) + abs(direction.y) + abs(direction.z);
    return s * s * s;
}
