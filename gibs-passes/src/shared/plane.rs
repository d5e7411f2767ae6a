//! The plane that a surfel lies in, in 16 bits: the surface's own, where the normal of shading may lean away from it. A surfel
//! covers what is beside it on the surface, whatever its light comes over.
use super::octahedral;
use glam::Vec3;

/// Steps from the middle of the octahedral square to its edge.
pub const STEPS: f32 = 127.0;

/// What [`unpack`] counts in.
pub const STEP: f32 = 1.0 / 128.0;

/// Sine of the angle below a plane up to which a direction may be above the surface.
pub const OFF: f32 = 0.017;

/// Bits of a plane.
pub const BITS: u32 = 16;

/// The plane with a normal, up to 0.017 radians off. Axes stay exactly what they are.
#[inline]
pub fn pack(normal: Vec3) -> u32 {
    let p = octahedral::encode(normal);
    let step = |c: f32| ((c * 0.5 + 0.5) * (2.0 * STEPS) + 0.5).floor() as u32;
    step(p.x) | step(p.y) << 8
}

/// A normal of the plane in the low bits of a word, in multiples of a 128th, which every backend computes to the same bits, and
/// which is no unit vector: what it is multiplied with has to be divided by its length, or both squared.
#[inline]
pub fn unpack(bits: u32) -> Vec3 {
    let x = (bits & 0xff) as f32 - STEPS;
    let y = (bits >> 8 & 0xff) as f32 - STEPS;
    let z = STEPS - x.abs() - y.abs();
    let below = (-z).max(0.0);
    let folded = |c: f32| if c >= 0.0 { c - below } else { c + below };
    Vec3::new(folded(x), folded(y), z) * STEP
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shared::hash;

    #[test]
    fn packed_planes_keep_their_direction() {
        for i in 0..50_000u32 {
            let u = |k| hash::unit(hash::hash2(i, k)) * 2.0 - 1.0;
            let Some(n) = Vec3::new(u(0), u(1), u(2)).try_normalize() else {
                continue;
            };
            let packed = pack(n);
            assert!(packed < 1 << BITS);
            // Half a step along both axes of the square and the whole one that it moves the third coordinate by, over the
            // distance of the middle of a face from the centre, 127 / sqrt(3).
            let angle = unpack(packed).normalize().cross(n).length();
            assert!(
                angle < 1.5f32.sqrt() * 3f32.sqrt() / STEPS,
                "{n} is off by {angle}"
            );
            assert!(angle < OFF, "{n} is off by {angle}");
            // Packed again, as for a surfel whose node has not turned, it stays; some planes have two words.
            let again = pack(unpack(packed).normalize());
            assert_eq!(unpack(again), unpack(packed), "{n}");
        }
    }

    #[test]
    fn axes_are_exact() {
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            for n in [axis, -axis] {
                assert_eq!(unpack(pack(n)), n * (STEPS * STEP));
            }
        }
    }

    #[test]
    fn no_word_is_without_a_plane() {
        for bits in 0..1 << BITS {
            assert!(
                unpack(bits).length_squared() >= (STEPS * STEP).powi(2) / 3.0,
                "{bits:#x}"
            );
        }
    }
}
