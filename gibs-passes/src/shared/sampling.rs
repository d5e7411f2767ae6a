//! Directions over the hemisphere.
use super::portable::sin_cos_turns;
use glam::Vec3;

/// Two unit vectors that make a right-handed frame with the unit vector `n` (Duff et al. 2017, "Building an
/// Orthonormal Basis, Revisited").
#[inline]
pub fn basis(n: Vec3) -> (Vec3, Vec3) {
    let sign = if n.z >= 0.0 { 1.0 } else { -1.0 };
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (
        Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
        Vec3::new(b, sign + n.y * n.y * a, -n.y),
    )
}

/// From the frame of `n` to the world.
#[inline]
pub fn to_world(local: Vec3, n: Vec3) -> Vec3 {
    let (tangent, bitangent) = basis(n);
    (tangent * local.x + bitangent * local.y + n * local.z).normalize()
}

/// From the world to the frame of `n`.
#[inline]
pub fn to_local(world: Vec3, n: Vec3) -> Vec3 {
    let (tangent, bitangent) = basis(n);
    Vec3::new(world.dot(tangent), world.dot(bitangent), world.dot(n))
}

/// A direction about +z with density `cos / pi`, from two numbers in `[0, 1)` (Malley's method).
#[inline]
pub fn cosine_hemisphere(u: f32, v: f32) -> Vec3 {
    let radius = u.sqrt();
    let (sin, cos) = sin_cos_turns(v);
    Vec3::new(radius * cos, radius * sin, (1.0 - u).max(0.0).sqrt())
}

/// Steps of [`r2`] along its axes, as shares of 2^32.
pub const R2_STEPS: [u32; 2] = [0xc13f_a9a9, 0x91e1_0da5];

/// Point `index` of the additive recurrence of Roberts 2018 ("The Unreasonable Effectiveness of Quasirandom
/// Sequences"), shifted by `shift`; exact in integers, so any index keeps full precision.
#[inline]
pub fn r2(index: u32, shift: (u32, u32)) -> (f32, f32) {
    let x = index.wrapping_mul(R2_STEPS[0]).wrapping_add(shift.0);
    let y = index.wrapping_mul(R2_STEPS[1]).wrapping_add(shift.1);
    (super::hash::unit(x), super::hash::unit(y))
}

/// Where a ray along `direction` begins that leaves `position` on a surface with geometric normal `n`, so that it
/// misses that surface: `offset` to the side that it leaves to, where what goes below it by a sine of no more than `below` leaves
/// above, for a normal that is off by so much. The offset is a bound of the position's rounding
/// error (Waechter and Binder 2019 motivate a bound that scales with the coordinates; see `surface::offset`).
#[inline]
pub fn start(position: Vec3, n: Vec3, offset: f32, below: f32, direction: Vec3) -> Vec3 {
    if n.dot(direction) >= -below {
        position + n * offset
    } else {
        position - n * offset
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The share of samples in each of 8x8 equal-probability cells of the hemisphere under `cos / pi`: `z^2` uniform
    /// in `[0, 1]` and azimuth uniform. 400 per cell expected; 5 standard deviations of a binomial count are 100.
    #[test]
    fn cosine_samples_follow_their_density() {
        let mut counts = [[0u32; 8]; 8];
        for i in 0..25_600u32 {
            let (u, v) = r2(i, (12_345, 67_890));
            let d = cosine_hemisphere(u, v);
            assert!((d.length() - 1.0).abs() < 1e-6);
            let row = ((d.z * d.z * 8.0) as usize).min(7);
            let turn = (d.y.atan2(d.x) / std::f32::consts::TAU).rem_euclid(1.0);
            counts[row][((turn * 8.0) as usize).min(7)] += 1;
        }
        for &count in counts.iter().flatten() {
            assert!(count.abs_diff(400) < 100, "{counts:?}");
        }
    }

    #[test]
    fn frames_are_orthonormal() {
        for i in 0..10_000u32 {
            let u = |k| super::super::hash::unit(super::super::hash::hash2(i, k)) * 2.0 - 1.0;
            let n = Vec3::new(u(0), u(1), u(2)).normalize();
            let (t, b) = basis(n);
            assert!((t.cross(b) - n).length() < 1e-5, "{n}");
            let d = Vec3::new(u(3), u(4), u(5)).normalize();
            assert!(to_world(to_local(d, n), n).distance(d) < 1e-5);
        }
    }
}
