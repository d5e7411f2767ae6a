//! What figures over frames, runs and seeds have in common.
pub(crate) mod student;

/// A quantile, linear between values; `None` where there are none.
pub(crate) fn quantile(values: &[f64], share: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let rank = sorted.len().saturating_sub(1) as f64 * share;
    let (below, above) = (
        *sorted.get(rank.floor() as usize)?,
        *sorted.get(rank.ceil() as usize)?,
    );
    Some(below + (above - below) * rank.fract())
}

/// Mean and sample variance, whose divisor is one less than the number of values; NaN where there are too few.
pub(crate) fn moments(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (mean, squares / (count - 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_linear_between_values() {
        let values = [4.0, 1.0, 2.0, 10.0];
        assert_eq!(quantile(&values, 0.0), Some(1.0));
        assert_eq!(quantile(&values, 0.5), Some(3.0));
        assert_eq!(quantile(&values, 1.0), Some(10.0));
        // Rank 0.9 * 3 = 2.7 lies 0.7 of the way from 4 to 10.
        assert!((quantile(&values, 0.9).unwrap_or_default() - 8.2).abs() < 1e-12);
        assert_eq!(quantile(&[7.0], 0.3), Some(7.0));
        assert_eq!(quantile(&[], 0.5), None);
    }

    #[test]
    fn variances_are_of_samples() {
        let (mean, variance) = moments(&[1.0, 2.0, 6.0]);
        assert_eq!((mean, variance), (3.0, 7.0));
        assert!(moments(&[1.0]).1.is_nan());
        assert!(moments(&[]).0.is_nan());
    }
}
