//! Medians, percentiles, and how far runs differ.
use crate::statistics::{moments, quantile, student};
use serde::{Deserialize, Serialize};

/// A figure over frames of several runs, milliseconds.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    /// Median over all frames.
    pub median: f64,
    /// 95th percentile over all frames.
    pub p95: f64,
    /// Median of each run.
    pub of_runs: Vec<f64>,
}

/// A ratio with its 95 % confidence interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// The ratio.
    pub ratio: f64,
    /// Its lower and upper bound; `None` where there are too few runs to tell.
    pub bounds: Option<[f64; 2]>,
}

impl Figure {
    /// Of values per frame, run by run; zeros where there are none.
    pub fn of(runs: &[Vec<f64>]) -> Self {
        let all = runs.concat();
        let at = |values: &[f64], share| quantile(values, share).unwrap_or_default();
        Self {
            median: at(&all, 0.5),
            p95: at(&all, 0.95),
            of_runs: runs.iter().map(|run| at(run, 0.5)).collect(),
        }
    }
}

impl Figure {
    /// Whether every run took some time.
    pub(super) fn took_time(&self) -> bool {
        !self.of_runs.is_empty() && self.of_runs.iter().all(|ms| *ms > 0.0)
    }

    /// The geometric mean of the runs' medians, or the median where one of them is zero.
    pub(super) fn mean_of_runs(&self) -> f64 {
        if !self.took_time() {
            return self.median;
        }
        let logs: Vec<f64> = self.of_runs.iter().map(|ms| ms.ln()).collect();
        moments(&logs).0.exp()
    }

    /// What is wrong with it where its median is none of frames of runs with such medians, all with as many frames: it lies
    /// between those, but for rounding, and below the 95th percentile.
    pub(super) fn outside_its_runs(&self) -> Option<String> {
        const ROUNDING: f64 = 1e-9;
        let least = self.of_runs.iter().copied().fold(f64::MAX, f64::min);
        let most = self.of_runs.iter().copied().fold(0.0, f64::max);
        let median = self.median;
        if median < least * (1.0 - ROUNDING) || median > most * (1.0 + ROUNDING) {
            return Some(format!(
                "a median of {median} milliseconds, where runs have from {least} to {most}"
            ));
        }
        let p95 = self.p95;
        (p95 < median * (1.0 - ROUNDING)).then(|| {
            format!("a 95th percentile of {p95} milliseconds below the median of {median}")
        })
    }
}

/// Runs without which there is no interval: of two, Student's t of one degree of freedom makes one of any width.
const LEAST_RUNS: usize = 3;

impl Interval {
    /// The ratio of paired values, by the Student interval of the mean of their logarithms.
    pub fn of_pairs(pairs: impl Iterator<Item = (f64, f64)>) -> Self {
        let logs: Vec<f64> = pairs
            .filter(|(new, old)| *new > 0.0 && *old > 0.0)
            .map(|(new, old)| (new / old).ln())
            .collect();
        let (mean, variance) = moments(&logs);
        let count = logs.len();
        Self::around(mean, (variance / count as f64).sqrt(), count.max(1) - 1)
    }

    /// The ratio of values that are paired within runs: of three runs and more by the Student interval of the runs' means, so that
    /// what runs differ by is in it; of fewer by that of all pairs, in which it is not.
    pub fn of_paired_runs(runs: &[Vec<(f64, f64)>]) -> Self {
        if runs.len() < LEAST_RUNS {
            return Self::of_pairs(runs.iter().flatten().copied());
        }
        let mean = |run: &Vec<(f64, f64)>| (Self::of_pairs(run.iter().copied()).ratio, 1.0);
        Self::of_pairs(runs.iter().map(mean))
    }

    /// The ratio of the means of two independent samples, by Welch's interval on their logarithms: B. L. Welch, "The
    /// generalization of Student's problem when several different population variances are involved", 1947.
    pub fn of_samples(new: &[f64], old: &[f64]) -> Self {
        let logs = |values: &[f64]| -> Vec<f64> {
            let above = values.iter().filter(|value| **value > 0.0);
            above.map(|value| value.ln()).collect()
        };
        let (new, old) = (logs(new), logs(old));
        let ((a, va), (b, vb)) = (moments(&new), moments(&old));
        if new.len() < LEAST_RUNS || old.len() < LEAST_RUNS {
            return Self::around(a - b, 0.0, 0);
        }
        let (na, nb) = (new.len() as f64, old.len() as f64);
        let (ea, eb) = (va / na, vb / nb);
        let error = (ea + eb).sqrt();
        // Welch and Satterthwaite's degrees of freedom, rounded down; at least those of the smaller sample.
        let least = new.len().min(old.len()) - 1;
        let freedom = (ea + eb).powi(2) / (ea.powi(2) / (na - 1.0) + eb.powi(2) / (nb - 1.0));
        Self::around(a - b, error, least.max(freedom as usize))
    }

    fn around(log: f64, error: f64, freedom: usize) -> Self {
        Self {
            ratio: log.exp(),
            bounds: (freedom > 0).then(|| {
                let reach = student::quantile(freedom as u32) * error;
                [(log - reach).exp(), (log + reach).exp()]
            }),
        }
    }
}
