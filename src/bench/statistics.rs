//! Means over seeds, and the spread of times.
use crate::statistics::{moments, quantile, student};
use serde::Serialize;

/// A mean over seeds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Mean {
    /// Mean.
    pub mean: f64,
    /// Its standard error; none for a single value.
    pub standard_error: Option<f64>,
    /// Half of its 95 % confidence interval, from Student's t for as many values; none for a single value.
    pub interval: Option<f64>,
}

impl Mean {
    /// Of values; NaN where there are none.
    pub fn of(values: impl Iterator<Item = f64>) -> Self {
        let values: Vec<f64> = values.collect();
        let (mean, variance) = moments(&values);
        let count = values.len() as f64;
        let standard_error = (values.len() > 1).then(|| (variance / count).sqrt());
        let t = student::quantile(values.len().saturating_sub(1) as u32);
        Self {
            mean,
            standard_error,
            interval: standard_error.map(|error| error * t),
        }
    }

    /// The same without an interval: of values of which some are bounds.
    pub(super) fn without_interval(self) -> Self {
        Self {
            standard_error: None,
            interval: None,
            ..self
        }
    }

    /// The ends of the confidence interval; not finite for a single value.
    pub fn ends(&self) -> [f64; 2] {
        let half = self.interval.unwrap_or(f64::NAN);
        [self.mean - half, self.mean + half]
    }
}

/// How values are spread: percentiles, linear between values.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// The 10th percentile.
    pub low: f64,
    /// The 50th.
    pub median: f64,
    /// The 90th.
    pub high: f64,
}

impl Spread {
    /// Of values; NaN where there are none.
    pub fn of(values: impl Iterator<Item = f64>) -> Self {
        let values: Vec<f64> = values.collect();
        let at = |share| quantile(&values, share).unwrap_or(f64::NAN);
        Self {
            low: at(0.1),
            median: at(0.5),
            high: at(0.9),
        }
    }
}
