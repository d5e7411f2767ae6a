//! Figures of a run as CSV and as plots.
use super::FrameRow;
use crate::plot::{Axis, Plot, Series};
use std::fmt::Display;

/// Points of a curve; a longer run is averaged down to these.
const MOST_POINTS: usize = 150;

/// Columns of a table, and the rows below.
///
/// `before` and `after` name what each row of `rows` has beside its frame, and the row gives their values, empty ones for
/// what is not known.
pub fn csv<'a>(
    groups: &[String],
    before: &[&str],
    after: &[&str],
    rows: impl Iterator<Item = (Vec<String>, &'a FrameRow, Vec<String>)>,
) -> String {
    let fixed = [
        "live",
        "births",
        "recycled",
        "starved",
        "crowded",
        "grid_overflow",
        "slot_errors",
        "rays",
        "continued",
    ];
    let mut head: Vec<String> = before.iter().map(ToString::to_string).collect();
    head.extend(["frame".to_owned(), "ms".to_owned()]);
    head.extend(groups.iter().map(|group| format!("{group}_ms")));
    head.extend(fixed.map(str::to_owned));
    head.extend(after.iter().map(ToString::to_string));
    let mut text = head.join(",") + "\n";
    for (mut cells, row, after) in rows {
        cells.extend([row.frame.to_string(), format!("{:.3}", row.ms)]);
        cells.extend((0..groups.len()).map(|i| match row.groups_ms.get(i) {
            Some(ms) => format!("{ms:.3}"),
            None => String::new(),
        }));
        let counts = [
            row.live,
            row.births,
            row.recycled,
            row.starved,
            row.crowded,
            row.grid_overflow,
        ];
        cells.extend(counts.map(|count| count.to_string()));
        cells.push(or_empty(row.slot_errors));
        cells.extend([row.rays, row.continued].map(|count| count.to_string()));
        cells.extend(after);
        text += &(cells.join(",") + "\n");
    }
    text
}

/// A value, or nothing where it is not known.
pub fn or_empty(value: Option<impl Display>) -> String {
    value.map_or_else(String::new, |value| value.to_string())
}

/// Time of each group over the frames.
pub fn group_plot<'a>(
    title: &str,
    groups: &[String],
    rows: impl Iterator<Item = &'a FrameRow> + Clone,
) -> Plot {
    let curve = |(i, group): (usize, &String)| {
        let points = rows.clone().filter_map(|row| {
            let ms = row.groups_ms.get(i)?;
            Some([f64::from(row.frame), *ms])
        });
        (group.clone(), points.collect())
    };
    plot_of(
        title,
        Axis::linear("time of a frame's group, ms"),
        groups.iter().enumerate().map(curve).collect(),
    )
}

/// Curves over frames, each a name and points `[frame, value]`.
pub fn plot_of(title: &str, y: Axis, curves: Vec<(String, Vec<[f64; 2]>)>) -> Plot {
    let series = curves.into_iter().map(|(name, points)| Series {
        name,
        points: thinned(&points),
        band: Vec::new(),
        ..Series::default()
    });
    Plot {
        title: title.to_owned(),
        x: Axis::linear("frame"),
        y,
        series: series.collect(),
    }
}

/// Means over stretches of the curve, so that it has [`MOST_POINTS`] at most.
fn thinned(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let stretch = points.len().div_ceil(MOST_POINTS).max(1);
    let mean = |part: &[[f64; 2]]| {
        [0, 1].map(|c| part.iter().map(|p| p[c]).sum::<f64>() / part.len() as f64)
    };
    points.chunks(stretch).map(mean).collect()
}
