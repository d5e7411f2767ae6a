// The light of the sky, black where the stage does not bind `environment`.
@if(environment) import package::environment::environment_texel;

/// Radiance that arrives from a direction, without interpolation between texels, W/(m^2 sr).
@if(environment)
fn sky_radiance(side: u32, direction: vec3<f32>) -> vec3<f32> {
    return environment_texel(side, direction).xyz;
}
@else
fn sky_radiance(side: u32, direction: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(0.0);
}
