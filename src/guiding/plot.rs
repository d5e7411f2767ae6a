//! Error against rays, both axes logarithmic, as noise falls by a power of the rays.
use super::{Error, Row};
use crate::plot::{Axis, Plot, Series};

/// The errors under one environment, with bands two standard errors wide to either side, as SVG.
pub fn plot(title: &str, rows: &[Row]) -> String {
    let curve = |name: &str, of: fn(&Row) -> Error| Series {
        name: name.into(),
        points: rows
            .iter()
            .map(|row| [f64::from(row.rays), of(row).error * 100.0])
            .collect(),
        band: rows.iter().map(|row| band(of(row))).collect(),
        ..Series::default()
    };
    let plot = Plot {
        title: title.into(),
        x: Axis::log("rays of a probe"),
        y: Axis::log("relative error of irradiance, %"),
        series: vec![
            curve("cosine lobe", |row| row.cosine),
            curve("guided", |row| row.guided),
        ],
    };
    plot.svg()
}

fn band(e: Error) -> [f64; 2] {
    [e.error - e.plus_minus, e.error + e.plus_minus].map(|end| end * 100.0)
}
