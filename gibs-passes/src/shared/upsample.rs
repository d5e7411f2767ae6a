//! The screen passes at half the width and height: which pixels stand for the picture, and what lies between them.
use super::estimator::luminance;
use super::lookup::complete;
use super::octahedral;
use super::surface;
use crate::data::{Camera, Gathered, SurfacePoint};
use glam::{UVec2, Vec3};

/// An edge lies between two points where one is off the other's plane by more than this share of a pixel's width there.
/// Smooth surfaces are curved by less from pixel to pixel. A third of the tolerance takes more pixels for edges and makes no
/// error smaller; at three times as much light is interpolated across steps (docs/performance.md, "Half resolution").
pub const PLANE_TOLERANCE: f32 = 0.3;

/// An edge lies between two points where the cosine of their normals is below this.
pub const NORMAL_TOLERANCE: f32 = 0.85;

/// Where the light at the corners of a block of 2x2 pixels, its own with even coordinates and the next ones, differs by more than
/// this factor, every pixel of it is lit by itself:
/// what lies between is then more than noise, as the two sides of a wall that is thinner than a pixel.
pub const CONTRAST: f32 = 2.0;

/// The pixel by which gap filling sees a texel of `stride` x `stride` pixels in a frame: each in turn, so that nothing
/// is too thin to be covered. Where the texel reaches beyond the picture, the last pixel within.
#[inline]
pub fn pixel_of(texel: UVec2, stride: u32, frame: u32, size: UVec2) -> UVec2 {
    let turn = UVec2::new((frame ^ (frame >> 1)) & 1, frame & 1) % stride;
    (texel * stride + turn).min(size - 1)
}

/// The lowest and the highest of the pixels with even coordinates around a pixel; both are the pixel itself where its
/// own are even. The highest may lie beyond the picture.
#[inline]
pub fn around(at: UVec2) -> (UVec2, UVec2) {
    let odd = at % 2;
    (at - odd, at + odd)
}

/// The block of 2x2 pixels that a pixel lies in, of a picture of this width.
#[inline]
pub fn block_of(at: UVec2, width: u32) -> u32 {
    at.y / 2 * width.div_ceil(2) + at.x / 2
}

/// The pixels of a block, in the order in which they are packed; some may lie beyond a picture of this width.
#[inline]
pub fn pixels_of(block: u32, width: u32) -> [UVec2; 4] {
    let blocks = width.div_ceil(2).max(1);
    let first = 2 * UVec2::new(block % blocks, block / blocks);
    [(0, 0), (1, 0), (0, 1), (1, 1)].map(|by| first + UVec2::from(by))
}

/// Blocks of 2x2 pixels that a picture has.
pub fn blocks(size: [u32; 2]) -> u64 {
    size.map(|n| u64::from(n.div_ceil(2))).iter().product()
}

/// A pixel lies in the picture, sees a surface and was not selected.
#[inline]
pub fn is_open(points: &[SurfacePoint], selected: &[u32], at: UVec2, size: UVec2) -> bool {
    let i = (at.y * size.x + at.x) as usize;
    at.cmplt(size).all() && selected[i] == 0 && surface::is_surface(&points[i])
}

/// By how much light differs: luminance of the irradiance, W/m^2.
#[inline]
pub fn light(gathered: &Gathered) -> f32 {
    luminance(complete(gathered))
}

/// How far a point may be off another's plane, metres; rounding of the points included.
#[inline]
pub fn tolerance(point: &SurfacePoint, camera: &Camera) -> f32 {
    let distance = (point.position - camera.eye).length();
    PLANE_TOLERANCE * camera.pixel_angle * distance + point.offset
}

/// No edge lies between two points, the first of which has these unpacked geometric and shading normals: they are of
/// one node, on each other's plane, and look the same way.
#[inline]
pub fn continuous(
    a: &SurfacePoint,
    (geometric, shading): (Vec3, Vec3),
    b: &SurfacePoint,
    tolerance: f32,
) -> bool {
    let d = b.position - a.position;
    if b.transform_id != a.transform_id || geometric.dot(d).abs() > tolerance {
        return false;
    }
    // In a plane, which is where most neighbours lie, nothing is left to ask.
    let flat = b.geometric_normal == a.geometric_normal;
    if !flat && octahedral::unpack(b.geometric_normal).dot(d).abs() > tolerance {
        return false;
    }
    b.shading_normal == a.shading_normal
        || octahedral::unpack(b.shading_normal).dot(shading) >= NORMAL_TOLERANCE
}

/// The mean of what the surfels say at four points. The average that fills in is weighed by what each point lacks, so
/// that the completed irradiance is the mean of the four completed ones; confidence by the surfels' weight.
#[inline]
pub fn mean([a, b, c, d]: [&Gathered; 4]) -> Gathered {
    let weight = (a.weight + b.weight) + (c.weight + d.weight);
    let mut mean = Gathered {
        irradiance: ((a.irradiance + b.irradiance) + (c.irradiance + d.irradiance)) * 0.25,
        weight: weight * 0.25,
        ..Gathered::default()
    };
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
    mean
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shared::surface::{MISS, is_surface};

    #[test]
    fn every_pixel_has_its_turn_within_four_frames() {
        for size in [UVec2::new(1, 1), UVec2::new(5, 2), UVec2::new(4, 3)] {
            for stride in [1, 2] {
                let mut seen = vec![false; (size.x * size.y) as usize];
                for frame in 10..14 {
                    for y in 0..size.y.div_ceil(stride) {
                        for x in 0..size.x.div_ceil(stride) {
                            let at = pixel_of(UVec2::new(x, y), stride, frame, size);
                            seen[(at.y * size.x + at.x) as usize] = true;
                        }
                    }
                }
                assert!(seen.iter().all(|seen| *seen), "{size}, {stride}");
            }
        }
    }

    #[test]
    fn a_pixel_lies_in_the_middle_of_those_around_it() {
        for at in [UVec2::new(4, 6), UVec2::new(5, 6), UVec2::new(5, 7)] {
            let (low, high) = around(at);
            assert_eq!(low + high, 2 * at);
            assert!(low % 2 == UVec2::ZERO && high % 2 == UVec2::ZERO);
        }
    }

    fn point(position: Vec3, normal: Vec3) -> SurfacePoint {
        SurfacePoint {
            position,
            geometric_normal: octahedral::pack(normal),
            shading_normal: octahedral::pack(normal),
            transform_id: 0,
            ..MISS
        }
    }

    /// Seen at a slant, two points of one plane may be far apart; a step, a crease, another node, a sky behind is an
    /// edge from either side.
    #[test]
    fn steps_creases_and_ends_are_edges() {
        let up = Vec3::Z;
        let here = point(Vec3::ZERO, up);
        let tilted = Vec3::new(0.6, 0.0, 0.8);
        let cases = [
            (point(Vec3::new(9.0, 0.0, 0.0), up), true),
            (point(Vec3::new(1.0, 0.0, 0.09), up), true),
            (point(Vec3::new(1.0, 0.0, 0.11), up), false),
            // In this one's plane, but not the reverse.
            (point(Vec3::new(1.0, 0.0, 0.0), tilted), false),
            // At the crease itself, where only the normals tell.
            (point(Vec3::ZERO, tilted), false),
            (MISS, false),
            (
                SurfacePoint {
                    transform_id: 1,
                    ..here
                },
                false,
            ),
        ];
        for (there, expected) in cases {
            let found = continuous(&here, (up, up), &there, 0.1);
            assert_eq!(found, expected, "{there:?}");
            if is_surface(&there) {
                let normal = octahedral::unpack(there.geometric_normal);
                let back = continuous(&there, (normal, normal), &here, 0.1);
                assert_eq!(back, expected, "from {there:?}");
            }
        }
    }

    /// Where nothing is missing, where all is, and in between: within the rounding of a dozen operations.
    #[test]
    fn completing_the_mean_is_the_mean_of_the_completed() {
        let gathered = |irradiance: f32, weight: f32, average: f32, confidence: f32| Gathered {
            irradiance: Vec3::splat(irradiance),
            weight,
            average: Vec3::splat(average),
            confidence,
        };
        let full = gathered(3.0, 1.0, 0.0, 1.0);
        let part = gathered(0.5, 0.25, 4.0, 0.5);
        let none = gathered(0.0, 0.0, 2.0, 0.0);
        for four in [
            [&full, &part, &none, &part],
            [&full; 4],
            [&none; 4],
            [&full, &full, &full, &part],
        ] {
            let complete = |g: &Gathered| g.irradiance + g.average * (1.0 - g.weight);
            let want = four.iter().map(|g| complete(g)).sum::<Vec3>() / 4.0;
            let got = complete(&mean(four));
            assert!(
                (got - want).abs().max_element() <= 1e-6 * want.x,
                "{four:?}"
            );
            let trusted = four.iter().map(|g| g.confidence * g.weight).sum::<f32>() / 4.0;
            let got = mean(four).confidence * mean(four).weight;
            assert!((got - trusted).abs() <= 1e-6, "{four:?}");
        }
    }
}
