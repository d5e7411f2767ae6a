//! Student's t distribution, for confidence intervals over few seeds.

/// How much of the distribution an interval holds.
pub(crate) const CONFIDENCE: f64 = 0.95;

/// The t that |T| does not exceed with a probability of [`CONFIDENCE`], for so many degrees of freedom; the mean of `n` values
/// is certain to t (of n - 1) standard errors. Infinite for none.
pub(crate) fn quantile(freedom: u32) -> f64 {
    if freedom == 0 {
        return f64::INFINITY;
    }
    // The probability rises with the angle; halving the interval finds it to the last bits.
    let (mut low, mut high) = (0.0, std::f64::consts::FRAC_PI_2);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        match within(middle, freedom) < CONFIDENCE {
            true => low = middle,
            false => high = middle,
        }
    }
    low.tan() * f64::from(freedom).sqrt()
}

/// The probability that |T| does not exceed sqrt(freedom) tan(angle): the finite sums of M. Abramowitz and I. Stegun, "Handbook
/// of Mathematical Functions", 1964, 26.7.3 and 26.7.4.
fn within(angle: f64, freedom: u32) -> f64 {
    let (sine, cosine) = angle.sin_cos();
    let odd = !freedom.is_multiple_of(2);
    // Of odd degrees the powers of the cosine are odd, of even ones even, up to freedom - 2.
    let (mut term, mut power) = match odd {
        true => (cosine, 1),
        false => (1.0, 0),
    };
    let mut sum = 0.0;
    while power + 2 <= freedom {
        sum += term;
        power += 2;
        term *= cosine * cosine * f64::from(power - 1) / f64::from(power);
    }
    match odd {
        true => (angle + sine * sum) * std::f64::consts::FRAC_2_PI,
        false => sine * sum,
    }
}

#[cfg(test)]
mod tests {
    use super::quantile;

    /// NIST/SEMATECH e-Handbook of Statistical Methods, 1.3.6.7.2, upper 0.025 points.
    #[test]
    fn quantiles_are_those_of_the_tables() {
        let table = [
            (1, 12.706),
            (2, 4.303),
            (3, 3.182),
            (4, 2.776),
            (5, 2.571),
            (6, 2.447),
            (7, 2.365),
            (8, 2.306),
            (9, 2.262),
            (10, 2.228),
            (15, 2.131),
            (20, 2.086),
            (30, 2.042),
            (60, 2.000),
            (100, 1.984),
            (999, 1.962),
        ];
        for (freedom, t) in table {
            let own = quantile(freedom);
            assert!((own - t).abs() < 6e-4, "{freedom}: {own}, not {t}");
        }
        assert!(quantile(0).is_infinite());
    }
}
