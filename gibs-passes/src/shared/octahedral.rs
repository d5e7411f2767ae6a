//! Unit vectors in squares (Cigolle et al. 2014, "Survey of Efficient Representations for Independent Unit Vectors").
use glam::{Vec2, Vec3};

#[inline]
fn sign(x: f32) -> f32 {
    if x >= 0.0 { 1.0 } else { -1.0 }
}

/// Unit vector to `[-1, 1]^2`, the whole sphere.
#[inline]
pub fn encode(n: Vec3) -> Vec2 {
    let scale = 1.0 / (n.x.abs() + n.y.abs() + n.z.abs());
    let p = Vec2::new(n.x * scale, n.y * scale);
    if n.z >= 0.0 {
        p
    } else {
        Vec2::new((1.0 - p.y.abs()) * sign(p.x), (1.0 - p.x.abs()) * sign(p.y))
    }
}

/// Inverse of [`encode`].
#[inline]
pub fn decode(p: Vec2) -> Vec3 {
    let z = 1.0 - p.x.abs() - p.y.abs();
    let q = if z >= 0.0 {
        p
    } else {
        Vec2::new((1.0 - p.y.abs()) * sign(p.x), (1.0 - p.x.abs()) * sign(p.y))
    };
    Vec3::new(q.x, q.y, z).normalize()
}

/// Part of a square's side that a step of a packed vector is. A product of it is doubled, not one of twice as much, so that no
/// fused operation rounds otherwise.
pub const STEP: f32 = 1.0 / 65_535.0;

/// A unit vector in 32 bits; the angle to the original stays below 1e-4.
#[inline]
pub fn pack(n: Vec3) -> u32 {
    let p = encode(n);
    let x = ((p.x * 0.5 + 0.5) * 65_535.0 + 0.5).floor() as u32;
    let y = ((p.y * 0.5 + 0.5) * 65_535.0 + 0.5).floor() as u32;
    x | (y << 16)
}

/// Inverse of [`pack`].
#[inline]
pub fn unpack(bits: u32) -> Vec3 {
    let x = (bits & 0xffff) as f32 * STEP * 2.0 - 1.0;
    let y = (bits >> 16) as f32 * STEP * 2.0 - 1.0;
    decode(Vec2::new(x, y))
}

/// Unit vector of the upper hemisphere (`z >= 0`) to `[0, 1]^2`; nothing at all, which is what a direction straight down is
/// clamped to, to the middle.
#[inline]
pub fn hemisphere_encode(d: Vec3) -> Vec2 {
    let sum = (d.x.abs() + d.y.abs() + d.z).max(1e-30);
    let (x, y) = (d.x / sum, d.y / sum);
    Vec2::new((x + y) * 0.5 + 0.5, (x - y) * 0.5 + 0.5)
}

/// Inverse of [`hemisphere_encode`].
#[inline]
pub fn hemisphere_decode(uv: Vec2) -> Vec3 {
    let (a, b) = (uv.x * 2.0 - 1.0, uv.y * 2.0 - 1.0);
    let (x, y) = ((a + b) * 0.5, (a - b) * 0.5);
    Vec3::new(x, y, 1.0 - x.abs() - y.abs()).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shared::hash;

    fn directions() -> impl Iterator<Item = Vec3> {
        let axes = [
            Vec3::X,
            Vec3::Y,
            Vec3::Z,
            Vec3::NEG_X,
            Vec3::NEG_Y,
            Vec3::NEG_Z,
        ];
        let random = (0..50_000u32).map(|i| {
            let u = |k| hash::unit(hash::hash2(i, k)) * 2.0 - 1.0;
            Vec3::new(u(0), u(1), u(2))
                .try_normalize()
                .unwrap_or(Vec3::X)
        });
        axes.into_iter().chain(random)
    }

    #[test]
    fn packed_vectors_keep_their_direction() {
        for n in directions() {
            let angle = unpack(pack(n)).cross(n).length();
            assert!(angle < 1e-4, "{n} is off by {angle}");
        }
    }

    #[test]
    fn what_is_clamped_to_nothing_is_a_place_still() {
        assert_eq!(hemisphere_encode(Vec3::ZERO), Vec2::splat(0.5));
    }

    #[test]
    fn the_hemisphere_round_trips() {
        for n in directions() {
            let n = Vec3::new(n.x, n.y, n.z.abs());
            let uv = hemisphere_encode(n);
            assert!(
                uv.min_element() >= 0.0 && uv.max_element() <= 1.0,
                "{n} maps to {uv}"
            );
            assert!(hemisphere_decode(uv).distance(n) < 1e-5, "{n}");
        }
    }
}
