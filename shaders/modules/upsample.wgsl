// The screen passes at half the width and height: which pixels stand for the picture, and what lies between them.
import package::estimator::estimator_luminance;
import package::lookup::lookup_complete;
import package::octahedral::octahedral_unpack;
import package::types::{Camera, Gathered, SurfacePoint};
import package::vector::{vector_dot, vector_length};

/// An edge lies between two points where one is off the other's plane by more than this share of a pixel's width there.
const UPSAMPLE_PLANE_TOLERANCE: f32 = 0.3;
/// An edge lies between two points where the cosine of their normals is below this.
const UPSAMPLE_NORMAL_TOLERANCE: f32 = 0.85;

/// Where the light at the corners of a block of 2x2 pixels differs by more than this factor, every pixel of it is lit by itself.
const UPSAMPLE_CONTRAST: f32 = 2.0;

/// The pixel by which gap filling sees a texel of `stride` x `stride` pixels in a frame: each in turn.
fn upsample_pixel_of(texel: vec2<u32>, stride: u32, frame: u32, size: vec2<u32>) -> vec2<u32> {
    let turn = vec2<u32>((frame ^ (frame >> 1u)) & 1u, frame & 1u) % stride;
    return min(texel * stride + turn, size - 1u);
}

/// The lowest and the highest, in `xy` and `zw`, of the pixels with even coordinates around a pixel.
fn upsample_around(at: vec2<u32>) -> vec4<u32> {
    let odd = at % 2u;
    return vec4<u32>(at - odd, at + odd);
}

/// The block of 2x2 pixels that a pixel lies in, of a picture of this width.
fn upsample_block_of(at: vec2<u32>, width: u32) -> u32 {
    return at.y / 2u * ((width + 1u) / 2u) + at.x / 2u;
}

/// A pixel of a block, of the four in the order in which they are packed; it may lie beyond a picture of this width.
fn upsample_pixel_in(block: u32, number: u32, width: u32) -> vec2<u32> {
    let blocks = max((width + 1u) / 2u, 1u);
    return 2u * vec2<u32>(block % blocks, block / blocks) + vec2<u32>(number & 1u, number >> 1u);
}

/// By how much light differs: luminance of the irradiance, W/m^2.
fn upsample_light(gathered: Gathered) -> f32 {
    return estimator_luminance(lookup_complete(gathered));
}

/// How far a point may be off another's plane, metres; rounding of the points included.
fn upsample_tolerance(point: SurfacePoint, camera: Camera) -> f32 {
    let distance = vector_length(point.position - camera.eye);
    return UPSAMPLE_PLANE_TOLERANCE * camera.pixel_angle * distance + point.offset;
}

/// No edge lies between two points.
fn upsample_continuous(a: SurfacePoint, b: SurfacePoint, tolerance: f32) -> bool {
    let d = b.position - a.position;
    if b.transform_id != a.transform_id || abs(vector_dot(octahedral_unpack(a.geometric_normal), d)) > tolerance {
        return false;
    }
    // In a plane, which is where most neighbours lie, nothing is left to ask.
    let flat = b.geometric_normal == a.geometric_normal;
    if !flat && abs(vector_dot(octahedral_unpack(b.geometric_normal), d)) > tolerance {
        return false;
    }
    if b.shading_normal == a.shading_normal {
        return true;
    }
    let shading = octahedral_unpack(a.shading_normal);
    return vector_dot(octahedral_unpack(b.shading_normal), shading) >= UPSAMPLE_NORMAL_TOLERANCE;
}

/// The mean of what the surfels say at four points. The average that fills in is weighed by what each point lacks.
fn upsample_mean(a: Gathered, b: Gathered, c: Gathered, d: Gathered) -> Gathered {
    var mean: Gathered;
    let weight = (a.weight + b.weight) + (c.weight + d.weight);
    mean.irradiance = ((a.irradiance + b.irradiance) + (c.irradiance + d.irradiance)) * 0.25;
    mean.weight = weight * 0.25;
    let lacking = 4.0 - weight;
    // From the first to the last: drivers move sums of products about that are put together in another order.
    if lacking > 0.0 {
        let ab = a.average * (1.0 - a.weight) + b.average * (1.0 - b.weight);
        let abc = ab + c.average * (1.0 - c.weight);
        mean.average = (abc + d.average * (1.0 - d.weight)) / lacking;
    }
    if weight > 0.0 {
        let ab = a.confidence * a.weight + b.confidence * b.weight;
        let abc = ab + c.confidence * c.weight;
        mean.confidence = (abc + d.confidence * d.weight) / weight;
    }
    return mean;
}
