// Irradiance from lights, none where the stage does not bind `direct`.

/// Irradiance of element `i` from the sun and the lights, W/m^2.
@if(direct)
fn direct_irradiance(i: u32) -> vec3<f32> {
    return direct[i].xyz;
}
@else
fn direct_irradiance(i: u32) -> vec3<f32> {
    return vec3<f32>(0.0);
}
