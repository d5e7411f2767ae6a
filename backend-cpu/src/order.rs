//! The order that checking runs workgroups in.

/// Where the workgroup whose turn is `turn` stands among `total`; a permutation of `0..total`.
///
/// Turns go in strides that share no factor with `total`, so they visit everything once before they come back. Of a
/// stride near the golden ratio of 2^32, neighbours in turn stand far apart.
pub(crate) fn shuffled(turn: u32, total: u32) -> u32 {
    const STRIDE: u64 = 2_654_435_761; // prime: shares a factor with its multiples only
    let total = u64::from(total.max(1));
    let stride = if total.is_multiple_of(STRIDE) {
        total - 1
    } else {
        STRIDE
    };
    // Below 2^64: both factors are below 2^32.
    ((u64::from(turn) * stride + total / 2) % total) as u32
}

#[cfg(test)]
mod tests {
    use super::shuffled;

    #[test]
    fn every_total_is_visited_once() {
        for total in (1..=300).chain([1021, 1024, 4096, 65_535, 65_536, 131_070]) {
            let mut seen = vec![false; total as usize];
            for turn in 0..total {
                let at = shuffled(turn, total) as usize;
                assert!(!std::mem::replace(&mut seen[at], true), "{at} of {total}");
            }
        }
    }

    /// All totals have a stride without a common factor, and that makes a permutation; the greatest are too many to try
    /// each turn of.
    #[test]
    fn strides_share_no_factor_with_the_total() {
        let gcd = |mut a: u64, mut b: u64| {
            while b != 0 {
                (a, b) = (b, a % b);
            }
            a
        };
        let prime = 2_654_435_761_u32;
        for total in [
            prime - 1,
            prime,
            prime + 1,
            u32::MAX - 1,
            u32::MAX,
            65_535 * 65_535,
        ] {
            let total_ = u64::from(total);
            let stride = u64::from(shuffled(1, total)) + total_ - u64::from(shuffled(0, total));
            assert_eq!(gcd(stride % total_, total_), 1, "{total}");
            let last = (u64::from(total - 1) * (stride % total_) + total_ / 2) % total_;
            assert_eq!(u64::from(shuffled(total - 1, total)), last, "{total}");
        }
    }

    #[test]
    fn neighbours_in_turn_stand_apart() {
        for total in [64_u32, 100, 1000, 65_536] {
            let apart = (1..total)
                .filter(|&turn| shuffled(turn, total).abs_diff(shuffled(turn - 1, total)) > 1);
            assert_eq!(apart.count() as u32, total - 1, "{total}");
        }
    }
}
