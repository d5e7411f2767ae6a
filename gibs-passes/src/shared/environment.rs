//! The environment as an octahedral map: `rgb` is radiance, W/(m^2 sr); `a` is the density with which emitter
//! sampling draws the direction, per area of the square `[-1, 1]^2`.
use super::octahedral;
use glam::{Vec2, Vec3, Vec4};

/// The texel that a direction falls into.
#[inline]
pub fn texel(map: &[Vec4], side: u32, direction: Vec3) -> Vec4 {
    let p = octahedral::encode(direction);
    let at = |x: f32| (((x * 0.5 + 0.5) * side as f32) as u32).min(side - 1);
    map[(at(p.y) * side + at(p.x)) as usize]
}

/// Radiance that arrives from a direction, without interpolation between texels; black without a map.
#[inline]
pub fn radiance(map: &[Vec4], side: u32, direction: Vec3) -> Vec3 {
    if map.is_empty() {
        return Vec3::ZERO;
    }
    texel(map, side, direction).truncate()
}

/// Direction at a point of a texel; `u` and `v` in `[0, 1)`.
#[inline]
pub fn direction(side: u32, x: u32, y: u32, u: f32, v: f32) -> Vec3 {
    let at = |i: u32, f: f32| (i as f32 + f) / side as f32 * 2.0 - 1.0;
    octahedral::decode(Vec2::new(at(x, u), at(y, v)))
}

/// Solid angle per area of the octahedral square `[-1, 1]^2` at a direction: with `s = |x| + |y| + |z|` of the unit
/// vector, `s^3` (the octahedron's face has area sqrt(3) over its projection and lies at distance 1/sqrt(3)).
#[inline]
pub fn solid_angle_per_area(direction: Vec3) -> f32 {
    let s = direction.x.abs() + direction.y.abs() + direction.z.abs();
    s * s * s
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_square_covers_the_whole_sphere() {
        let side = 256;
        let area = 4.0 / f64::from(side * side);
        let sum: f64 = (0..side * side)
            .map(|i| {
                f64::from(solid_angle_per_area(direction(
                    side,
                    i % side,
                    i / side,
                    0.5,
                    0.5,
                ))) * area
            })
            .sum();
        // The midpoint rule over 256^2 texels is off by the square of the texel size.
        assert!((sum - 4.0 * std::f64::consts::PI).abs() < 1e-3, "{sum}");
    }
}
