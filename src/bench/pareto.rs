//! The best that can be had for a time.
use super::Row;

/// Marks every [`After`](super::After) of which no other has a smaller MAPE in no more time, or the same in less.
pub(super) fn mark(rows: &mut [Row]) {
    let mut all: Vec<(f64, f64, &mut bool)> = rows
        .iter_mut()
        .flat_map(|row| &mut row.after)
        .map(|after| {
            let figures = (after.seconds.mean, after.errors.mape.mean);
            (figures.0, figures.1, &mut after.pareto)
        })
        .filter(|(seconds, error, _)| seconds.is_finite() && error.is_finite())
        .collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut best = (f64::INFINITY, f64::INFINITY);
    for (seconds, error, pareto) in all {
        // Equals are both on the front.
        *pareto = error < best.1 || (seconds, error) == best;
        if error < best.1 {
            best = (seconds, error);
        }
    }
}
