// What a surfel's depth function lets through. Reads the stage's globals `depths` and `settings`.
import package::lookup::{LOOKUP_MOMENT_SCALE, lookup_chebyshev, lookup_steps};
import package::octahedral::octahedral_hemisphere_encode;
import package::sampling::sampling_to_local;
import package::types::SurfelPose;
import package::vector::vector_length;

/// Any number of diameters.
const DEPTH_ANY: f32 = 3.4028234e38;

fn depth_texel(surfel: u32, x: f32, y: f32) -> vec2<f32> {
    let side = settings.depth_side;
    let last = f32(side) - 1.0;
    let column = u32(clamp(x, 0.0, last));
    let row = u32(clamp(y, 0.0, last));
    return lookup_steps(depths[(surfel * side + row) * side + column]);
}

/// Moments of a surfel's depth function in a direction of its frame, bilinear.
fn depth_moments(surfel: u32, local: vec3<f32>) -> vec2<f32> {
    let uv = octahedral_hemisphere_encode(local) * f32(settings.depth_side) - 0.5;
    let low = floor(uv);
    let f = uv - low;
    let top = depth_texel(surfel, low.x, low.y) * (1.0 - f.x) + depth_texel(surfel, low.x + 1.0, low.y) * f.x;
    let bottom =
        depth_texel(surfel, low.x, low.y + 1.0) * (1.0 - f.x) + depth_texel(surfel, low.x + 1.0, low.y + 1.0) * f.x;
    return (top * (1.0 - f.y) + bottom * f.y) * LOOKUP_MOMENT_SCALE;
}

/// Share of a surfel's light that reaches a point at `d` from it, by its depth function. It falls to nothing beyond the
/// diameter, of which that knows nothing.
fn depth_visibility(surfel: u32, pose: SurfelPose, d: vec3<f32>) -> f32 {
    return depth_visibility_within(DEPTH_ANY, surfel, pose, d);
}

/// `depth_visibility` of a point beyond the diameter too: what is open up to there counts as open.
fn depth_openness(surfel: u32, pose: SurfelPose, d: vec3<f32>) -> f32 {
    return depth_visibility_within(1.0, surfel, pose, d);
}

/// `depth_visibility` of what is at most so many diameters away; what is farther, as if it were there.
fn depth_visibility_within(most: f32, surfel: u32, pose: SurfelPose, d: vec3<f32>) -> f32 {
    let distance = vector_length(d);
    // Nothing fits between a surfel's centre and a point this close.
    if distance < 0.02 * pose.radius {
        return 1.0;
    }
    let local = sampling_to_local(d / distance, pose.normal);
    let clamped = vec3<f32>(local.xy, max(local.z, 0.0));
    return lookup_chebyshev(depth_moments(surfel, clamped), min(distance / (2.0 * pose.radius), most));
}
