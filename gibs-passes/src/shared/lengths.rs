//! Two lengths in a word, eight bits of each mantissa: powers of two that scale both scale what is kept exactly.

/// The bits that the first one keeps.
const HIGH: u32 = 0xffff_0000;

/// One that is rounded up and one that is rounded down, by a part in 128 at most, metres, neither negative.
#[inline]
pub fn pack(up: f32, down: f32) -> u32 {
    (up.to_bits().wrapping_add(!HIGH) & HIGH) | down.to_bits() >> 16
}

/// The one that was rounded up.
#[inline]
pub fn up(word: u32) -> f32 {
    f32::from_bits(word & HIGH)
}

/// The one that was rounded down.
#[inline]
pub fn down(word: u32) -> f32 {
    f32::from_bits(word << 16)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shared::hash;

    #[test]
    fn lengths_are_kept_to_a_part_in_128() {
        for i in 0..10_000u32 {
            let length = |k| (hash::unit(hash::hash2(i, k)) * 200.0 - 100.0).exp2();
            let (a, b) = (length(0), length(1));
            let word = pack(a, b);
            assert!((a..=a * (1.0 + 1.0 / 128.0)).contains(&up(word)), "{a}");
            assert!((b * (1.0 - 1.0 / 128.0)..=b).contains(&down(word)), "{b}");
            assert_eq!(pack(up(word), down(word)), word);
            let scaled = pack(8.0 * a, 8.0 * b);
            assert_eq!(
                (up(scaled), down(scaled)),
                (8.0 * up(word), 8.0 * down(word))
            );
        }
    }

    #[test]
    fn the_ends_stay_what_they_are() {
        assert_eq!(pack(0.0, 0.0), 0);
        assert_eq!(up(pack(0.0, f32::MAX)), 0.0);
        let most = down(pack(0.0, f32::MAX));
        assert!(most.is_finite() && most > 3.3e38);
        assert!(up(pack(f32::MAX, 0.0)).is_infinite());
        assert!(up(pack(1e-45, 0.0)) > 0.0);
    }
}
