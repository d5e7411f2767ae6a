//! Plots of one scene on one backend.
use super::Measured;
use crate::bench::{After, Kind, Mean, Row};
use crate::plot::{Axis, Marks, Plot, Series};
use crate::words::scene_name;

/// An error that is drawn.
#[derive(Clone, Copy)]
pub(super) struct Drawn {
    /// The axis.
    label: &'static str,
    scale: f64,
    of: fn(&After) -> Mean,
}

pub(super) const MAPE: Drawn = Drawn {
    label: "MAPE of indirect irradiance, %",
    scale: 100.0,
    of: |after| after.errors.mape,
};
pub(super) const REL_MSE: Drawn = Drawn {
    label: "relMSE of indirect irradiance",
    scale: 1.0,
    of: |after| after.errors.rel_mse,
};

/// What an error is drawn over.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Over {
    Frames,
    Rays,
    Seconds,
}

impl Over {
    pub const ALL: [Self; 3] = [Self::Seconds, Self::Rays, Self::Frames];

    pub fn name(self) -> &'static str {
        match self {
            Self::Frames => "frames",
            Self::Rays => "rays",
            Self::Seconds => "seconds",
        }
    }

    fn axis(self) -> Axis {
        Axis::log(match self {
            Self::Frames => "frames from an empty cache",
            Self::Rays => "rays from an empty cache",
            Self::Seconds => "seconds from an empty cache",
        })
    }

    fn of(self, after: &After) -> f64 {
        match self {
            Self::Frames => f64::from(after.frames),
            Self::Rays => after.total_rays,
            Self::Seconds => after.seconds.mean,
        }
    }

    /// Whether a row belongs there: of the two ways to give path tracing as much, the one that is equal in this.
    fn takes(self, kind: Kind) -> bool {
        match kind {
            Kind::Settings => true,
            Kind::Element => false,
            Kind::EqualRays => self == Self::Rays,
            Kind::EqualTime => self != Self::Rays,
        }
    }
}

/// All plots as SVG, each with a name: the MAPE over seconds, rays and frames, with 95 % confidence bands, and the front.
pub fn plots(measured: &Measured) -> Vec<(String, String)> {
    let curves = Over::ALL.map(|over| {
        let plot = curves(measured, over, MAPE);
        (over.name().to_owned(), plot.svg())
    });
    let front = ("front".to_owned(), front(measured).svg());
    curves.into_iter().chain([front]).collect()
}

/// An error of settings and baselines.
pub(super) fn curves(measured: &Measured, over: Over, drawn: Drawn) -> Plot {
    let rows = measured.rows.iter().filter(|row| over.takes(row.kind));
    of_rows(measured, rows, over, drawn)
}

/// An error with each element switched.
pub(super) fn elements(measured: &Measured, over: Over, drawn: Drawn) -> Plot {
    let rows = measured.rows.iter().enumerate();
    let rows = rows.filter(|(i, row)| *i == 0 || row.kind == Kind::Element);
    of_rows(measured, rows.map(|(_, row)| row), over, drawn)
}

fn of_rows<'a>(
    measured: &Measured,
    rows: impl Iterator<Item = &'a Row>,
    over: Over,
    drawn: Drawn,
) -> Plot {
    let series = rows.map(|row| Series {
        name: row.name.clone(),
        points: points(row, over, drawn),
        band: row
            .after
            .iter()
            .map(|a| (drawn.of)(a).ends().map(|end| end * drawn.scale))
            .collect(),
        marks: Marks::Joined,
    });
    Plot {
        title: title(measured, &format!("error over {}", over.name())),
        x: over.axis(),
        y: Axis::log(drawn.label),
        series: series.collect(),
    }
}

fn points(row: &Row, over: Over, drawn: Drawn) -> Vec<[f64; 2]> {
    let point = |a: &After| [over.of(a), (drawn.of)(a).mean * drawn.scale];
    row.after.iter().map(point).collect()
}

/// Seconds and error of everything, and the front that nothing is better than.
pub(super) fn front(measured: &Measured) -> Plot {
    // Those that the curves have come first, so that they have the same colours here.
    let place = |row: &&Row| match row.kind {
        Kind::Settings => 0,
        Kind::EqualTime => 1,
        Kind::EqualRays => 2,
        Kind::Element => 3,
    };
    let mut rows: Vec<&Row> = measured.rows.iter().collect();
    rows.sort_by_key(place);
    let mut series: Vec<Series> = rows
        .iter()
        .map(|row| Series {
            name: row.name.clone(),
            points: points(row, Over::Seconds, MAPE),
            marks: Marks::Scattered,
            ..Series::default()
        })
        .collect();
    let after = measured.rows.iter().flat_map(|row| &row.after);
    let best = after.filter(|a| a.pareto);
    let mut best: Vec<[f64; 2]> = best
        .map(|a| [a.seconds.mean, a.errors.mape.mean * MAPE.scale])
        .collect();
    best.sort_by(|a, b| a[0].total_cmp(&b[0]));
    series.push(Series {
        name: "Pareto front".into(),
        points: best,
        marks: Marks::Stairs,
        ..Series::default()
    });
    Plot {
        title: title(measured, "the least error for a time"),
        x: Over::Seconds.axis(),
        y: Axis::log(MAPE.label),
        series,
    }
}

fn title(measured: &Measured, what: &str) -> String {
    format!(
        "{} on {}: {what}",
        scene_name(&measured.scene),
        measured.backend
    )
}
