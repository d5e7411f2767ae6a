//! Pictures of where two results differ.
use crate::html::{escaped, png};
use gibs_graph::check::{Capture, PortReport, Report, apart};
use gibs_graph::{Layout, Order};
use image::{Rgb, RgbImage};
use std::fmt::Write;

/// What the pictures show.
pub(super) const LEGEND: &str = "<h2>Pictures of differences</h2><p>The first of each step. A pixel is an element, row by row: \
<span class=v style=\"background:#000\">equal</span> <span class=v style=\"background:#3c3cff\">one ULP or less</span> \
<span class=v style=\"background:#e63c3c\">half of the bits</span> \
<span class=v style=\"background:#fff;color:#000;border:1px solid\">all bits</span></p>";

/// Pictures of the first two results of a capture.
pub(super) fn pictures(page: &mut String, report: &Report, capture: &Capture, size: [u32; 2]) {
    let [a, b, ..] = &capture.results[..] else {
        return;
    };
    let _ = write!(
        page,
        "<h3>{}, {}</h3><p>Frame {}; <code>{}</code> against <code>{}</code>.</p>",
        escaped(&capture.case),
        escaped(&capture.label),
        capture.frame,
        escaped(&b.lane),
        escaped(&a.lane)
    );
    for ((&id, x), y) in a.buffers.iter().zip(&a.outputs).zip(&b.outputs) {
        let buffer = &capture.buffers[id as usize];
        let (off, how) = match order(report, capture, id) {
            Order::InOrder => (distances(&buffer.element, x, y), String::new()),
            Order::Any => {
                let [x, y] = [x, y].map(|bytes| sorted(&buffer.element, bytes));
                let how = "; both sorted, since they may come in any order";
                (distances(&buffer.element, &x, &y), how.to_owned())
            }
            Order::AnyWithin(lists) => {
                let how = format!(
                    "; place by place, so that what stands elsewhere in one of the {} shows too, which is no difference",
                    lists.name
                );
                (distances(&buffer.element, x, y), how)
            }
        };
        let unequal = off.iter().filter(|ulps| **ulps > 0.0).count();
        if let Some(picture) = picture(&off, size) {
            let _ = write!(
                page,
                "<figure><img width=\"{w}\" alt=\"differences\" src=\"{picture}\">\
                 <figcaption><code>{key}</code>: {unequal} of {all} elements unequal{how}</figcaption></figure>",
                w = 384,
                key = escaped(&buffer.key),
                all = off.len(),
                how = escaped(&how)
            );
        }
    }
}

/// Which elements of a buffer that a captured step writes were held against each other.
fn order(report: &Report, capture: &Capture, buffer: u32) -> Order {
    let bound = |port: &PortReport| {
        let mut bindings = capture.bindings.iter();
        bindings.any(|b| b.buffer == buffer && b.access.writes() && b.port == port.port)
    };
    let cases = report.cases.iter().filter(|case| case.name == capture.case);
    let steps = cases.flat_map(|case| &case.steps);
    let mut ports = steps
        .filter(|step| step.label == capture.label)
        .flat_map(|step| &step.ports);
    let port = ports.find(|port| bound(port));
    port.map_or(Order::InOrder, |port| port.comparator.order)
}

/// The elements in the order of their bytes; what is left over behind them.
fn sorted(element: &Layout, bytes: &[u8]) -> Vec<u8> {
    let elements = bytes.chunks_exact(element.size().max(1) as usize);
    let rest = elements.remainder();
    let mut elements: Vec<&[u8]> = elements.collect();
    elements.sort_unstable();
    elements.push(rest);
    elements.concat()
}

/// How far elements are apart. Those that only a sign of zero, or which NaN it is, tells apart have no distance, and
/// are drawn as the smallest.
fn distances(element: &Layout, a: &[u8], b: &[u8]) -> Vec<f64> {
    let mut off = apart(element, a, b);
    let size = element.size().max(1) as usize;
    let pairs = a.chunks_exact(size).zip(b.chunks_exact(size));
    for (ulps, (a, b)) in off.iter_mut().zip(pairs) {
        if a != b && *ulps == 0.0 {
            *ulps = f64::MIN_POSITIVE;
        }
    }
    off
}

/// Widest picture; longer results are shown by the largest difference of neighbours.
const SIDE: usize = 256;

/// Differences as a PNG, encoded; `None` where there is nothing to show.
fn picture(off: &[f64], [columns, rows]: [u32; 2]) -> Option<String> {
    if off.iter().all(|ulps| *ulps == 0.0) {
        return None;
    }
    let per_pixel = off.len().div_ceil(SIDE * SIDE);
    let pixels: Vec<f64> = off
        .chunks(per_pixel)
        .map(|chunk| chunk.iter().copied().fold(0.0, f64::max))
        .collect();
    let width = match u64::from(columns) * u64::from(rows) == off.len() as u64 && per_pixel == 1 {
        true => columns as usize,
        false => (pixels.len() as f64).sqrt().ceil() as usize,
    };
    let mut image = RgbImage::new(width as u32, pixels.len().div_ceil(width) as u32);
    for (i, &ulps) in pixels.iter().enumerate() {
        image.put_pixel((i % width) as u32, (i / width) as u32, color(ulps));
    }
    png(&image)
}

/// Black for equal, then over a logarithmic scale from blue (one ULP) over red (half of the bits of a float) to white.
fn color(ulps: f64) -> Rgb<u8> {
    if ulps <= 0.0 {
        return Rgb([0, 0, 0]);
    }
    let t = ((ulps + 1.0).log2() / 24.0).clamp(0.0, 1.0);
    let mix = |from: f64, to: f64, t: f64| (from + (to - from) * t) as u8;
    match t < 0.5 {
        true => Rgb([mix(60.0, 230.0, 2.0 * t), 60, mix(255.0, 60.0, 2.0 * t)]),
        false => {
            let t = 2.0 * t - 1.0;
            Rgb([
                mix(230.0, 255.0, t),
                mix(60.0, 255.0, t),
                mix(60.0, 255.0, t),
            ])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gibs_graph::Element;

    fn bytes(values: &[f32]) -> Vec<u8> {
        values.iter().flat_map(|x| x.to_ne_bytes()).collect()
    }

    #[test]
    fn a_zero_of_the_other_sign_is_drawn() {
        let off = distances(&f32::layout(), &bytes(&[0.0, 1.0]), &bytes(&[-0.0, 1.0]));
        assert!(off[0] > 0.0 && off[1] == 0.0, "{off:?}");
        assert_ne!(color(off[0]), color(0.0));
        assert!(picture(&off, [2, 1]).is_some());
    }

    #[test]
    fn what_only_stands_elsewhere_is_not_drawn() {
        let (a, b) = (bytes(&[1.0, 2.0, 3.0]), bytes(&[3.0, 1.0, 2.0]));
        let [x, y] = [&a, &b].map(|bytes| sorted(&f32::layout(), bytes));
        assert!(
            distances(&f32::layout(), &x, &y)
                .iter()
                .all(|ulps| *ulps == 0.0)
        );
    }
}
