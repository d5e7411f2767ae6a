// Emitter sampling: emissive triangles by power, the sky by its map.
import package::estimator::estimator_luminance;
import package::types::{Emitter, Frame};
import package::vector::{vector_cross, vector_dot};

/// Share of the distance to a point on an emitter that a shadow ray covers, so that it ends before the emitter.
const EMITTER_REACH: f32 = 1.0 - 1.0 / 4096.0;

/// Bit of an emitter's flags: shines on both sides.
const EMITTER_BOTH_SIDES: u32 = 1u;
/// Bit of an emitter's flags: its front is the clockwise side.
const EMITTER_MIRRORED: u32 = 2u;

/// Probability of drawing the sky rather than a triangle: one half where both can be; negative where neither can.
fn emitter_sky_share(frame: Frame) -> f32 {
    let triangles = frame.emitter_power > 0.0;
    if frame.sky_sampled != 0u {
        return select(1.0, 0.5, triangles);
    }
    return select(-1.0, 0.0, triangles);
}

/// Barycentric weights of the second and third vertex, uniform over a triangle.
fn emitter_triangle_point(a: f32, b: f32) -> vec2<f32> {
    let root = sqrt(a);
    return vec2<f32>(root * (1.0 - b), root * b);
}

/// Cosine at the emitter between its normal and the way back to the viewer, positive on the side that shines; zero or
/// less on the dark side.
fn emitter_facing(emitter: Emitter, direction: vec3<f32>) -> f32 {
    let normal = vector_cross(emitter.e1, emitter.e2);
    let length = sqrt(vector_dot(normal, normal));
    if length <= 0.0 {
        return 0.0;
    }
    let front = select(-1.0, 1.0, (emitter.flags & EMITTER_MIRRORED) != 0u);
    let cosine = vector_dot(normal, direction) / length * front;
    if (emitter.flags & EMITTER_BOTH_SIDES) != 0u {
        return abs(cosine);
    }
    return cosine;
}

/// Radiance that an emitter sends against `direction`, W/(m^2 sr).
fn emitter_radiance(emitter: Emitter, direction: vec3<f32>) -> vec3<f32> {
    if emitter_facing(emitter, direction) > 0.0 {
        return emitter.radiance;
    }
    return vec3<f32>();
}

/// Density per solid angle, 1/sr, with which sampling by power draws the point of a surface with this radiance that a
/// viewer sees at this distance under this cosine: luminance over the power of all emitters is the density per area.
fn emitter_density(frame: Frame, radiance: vec3<f32>, cosine: f32, distance: f32) -> f32 {
    if cosine <= 0.0 || frame.emitter_power <= 0.0 {
        return 0.0;
    }
    return estimator_luminance(radiance) / frame.emitter_power * distance * distance / cosine;
}
