// The environment as an octahedral map of radiance, W/(m^2 sr). Reads the stage's global `environment`.
import package::octahedral::octahedral_encode;

fn environment_at(x: f32, side: u32) -> u32 {
    return min(u32(max((x * 0.5 + 0.5) * f32(side), 0.0)), side - 1u);
}

/// Radiance that arrives from a direction, without interpolation between texels.
fn environment_radiance(side: u32, direction: vec3<f32>) -> vec3<f32> {
    let p = octahedral_encode(direction);
    return environment[environment_at(p.y, side) * side + environment_at(p.x, side)].xyz;
}
