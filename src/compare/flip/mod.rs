//! The FLIP difference between two colour pictures as seen when alternating them on a screen.
//!
//! After Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild, "FLIP: A Difference
//! Evaluator for Alternating Images", Proceedings of the ACM on Computer Graphics and Interactive
//! Techniques 3(2), 2020: the variant for low dynamic range. Borders repeat the outermost pixel.

mod color;
mod filter;
#[cfg(test)]
mod tests;

use rayon::prelude::*;

use color::{from_opponent, hunt_lab, hyab, to_opponent};
use filter::{Kernel, convolve};

/// The paper's default viewing conditions: a 0.7 m wide screen of 3840 pixels seen from 0.7 m.
pub const PIXELS_PER_DEGREE: f32 = 67.0;

/// Exponent that compresses the colour difference, q_c.
const COLOR_EXPONENT: f32 = 0.7;
/// Share of the largest colour difference below which the map is linear, p_c.
const KNEE: f32 = 0.4;
/// The value that the knee is mapped to, p_t.
const KNEE_VALUE: f32 = 0.95;
/// Exponent that enlarges the feature difference, q_f.
const FEATURE_EXPONENT: f32 = 0.5;

/// The FLIP difference per pixel, 0 (none) to 1.
///
/// `reference` and `test` are linear RGB planes with Rec. 709 primaries, already exposed and
/// clamped to 0..1, in rows of `width` pixels. (The paper's input is sRGB, which its first step
/// makes linear; passing through 8-bit codes would only add rounding.) Both have the same number of
/// whole rows; the result is empty if they do not, or if there are none. The mean of the result is
/// the number commonly quoted.
pub fn flip(
    reference: [&[f32]; 3],
    test: [&[f32]; 3],
    width: usize,
    pixels_per_degree: f32,
) -> Vec<f32> {
    let pixels = reference[0].len();
    let same = reference
        .iter()
        .chain(&test)
        .all(|plane| plane.len() == pixels);
    if width == 0 || pixels == 0 || !pixels.is_multiple_of(width) || !same {
        return Vec::new();
    }
    let kernels = Kernels::new(pixels_per_degree);
    let seen = [reference, test].map(|rgb| Seen::new(rgb, width, &kernels));
    let largest = largest_color_difference();
    (0..pixels)
        .into_par_iter()
        .map(|i| {
            let [a, b] = [0, 1].map(|k| seen[k].lab.each_ref().map(|plane| plane[i]));
            let color = redistribute(hyab(a, b).powf(COLOR_EXPONENT), largest);
            let edges = (seen[0].edges[i] - seen[1].edges[i]).abs();
            let points = (seen[0].points[i] - seen[1].points[i]).abs();
            let strongest = edges.max(points);
            let feature = (strongest * std::f32::consts::FRAC_1_SQRT_2).powf(FEATURE_EXPONENT);
            color.powf(1.0 - feature)
        })
        .collect()
}

/// What the eye makes of one picture, as planes.
struct Seen {
    /// Hunt-adjusted L*a*b* of the picture blurred by the contrast sensitivity.
    lab: [Vec<f32>; 3],
    /// Magnitude of edges in the achromatic channel.
    edges: Vec<f32>,
    /// Magnitude of points and thin lines in the achromatic channel.
    points: Vec<f32>,
}

struct Kernels {
    achromatic: Vec<(f32, Kernel)>,
    red_green: Vec<(f32, Kernel)>,
    blue_yellow: Vec<(f32, Kernel)>,
    smooth: Kernel,
    edge: Kernel,
    point: Kernel,
}

impl Kernels {
    fn new(pixels_per_degree: f32) -> Self {
        let [achromatic, red_green, blue_yellow] = filter::contrast_sensitivity(pixels_per_degree);
        let [smooth, edge, point] = filter::feature_kernels(pixels_per_degree);
        Self {
            achromatic,
            red_green,
            blue_yellow,
            smooth,
            edge,
            point,
        }
    }
}

impl Seen {
    fn new(rgb: [&[f32]; 3], width: usize, kernels: &Kernels) -> Self {
        let opponent = map_planes(rgb, to_opponent);
        let blurred = [
            blur(&opponent[0], width, &kernels.achromatic),
            blur(&opponent[1], width, &kernels.red_green),
            blur(&opponent[2], width, &kernels.blue_yellow),
        ];
        let lab = map_planes([&blurred[0], &blurred[1], &blurred[2]], |color| {
            hunt_lab(from_opponent(color).map(|v| v.clamp(0.0, 1.0)))
        });
        // The features are those of the sharp picture; its achromatic channel to the range 0..1.
        let grey: Vec<f32> = opponent[0].par_iter().map(|y| (y + 16.0) / 116.0).collect();
        let (edges, points) = rayon::join(
            || feature(&grey, width, &kernels.smooth, &kernels.edge),
            || feature(&grey, width, &kernels.smooth, &kernels.point),
        );
        Self { lab, edges, points }
    }
}

/// Applies `f` to the colour of every pixel.
fn map_planes(planes: [&[f32]; 3], f: impl Fn([f32; 3]) -> [f32; 3] + Sync) -> [Vec<f32>; 3] {
    let mut result = [0, 1, 2].map(|_| vec![0.0; planes[0].len()]);
    let [a, b, c] = &mut result;
    (a, b, c)
        .into_par_iter()
        .enumerate()
        .for_each(|(i, (a, b, c))| {
            [*a, *b, *c] = f(planes.map(|plane| plane[i]));
        });
    result
}

/// The weighted sum of separable convolutions.
fn blur(plane: &[f32], width: usize, parts: &[(f32, Kernel)]) -> Vec<f32> {
    let mut sum = vec![0.0; plane.len()];
    for (weight, kernel) in parts {
        let part = convolve(plane, width, kernel, kernel);
        sum.par_iter_mut()
            .zip(part)
            .for_each(|(sum, value)| *sum += weight * value);
    }
    sum
}

/// The length of the response to `detector` along both axes, smoothed across it.
fn feature(plane: &[f32], width: usize, smooth: &Kernel, detector: &Kernel) -> Vec<f32> {
    let mut along_x = convolve(plane, width, detector, smooth);
    let along_y = convolve(plane, width, smooth, detector);
    along_x
        .par_iter_mut()
        .zip(along_y)
        .for_each(|(x, y)| *x = x.hypot(y));
    along_x
}

/// The compressed difference between pure green and pure blue, the largest there is, c_max.
fn largest_color_difference() -> f32 {
    let [green, blue] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(hunt_lab);
    hyab(green, blue).powf(COLOR_EXPONENT)
}

/// Maps compressed colour differences to 0..1: most of the range for the small ones that occur.
fn redistribute(difference: f32, largest: f32) -> f32 {
    let knee = KNEE * largest;
    if difference < knee {
        KNEE_VALUE / knee * difference
    } else {
        KNEE_VALUE + (difference - knee) / (largest - knee) * (1.0 - KNEE_VALUE)
    }
    .clamp(0.0, 1.0)
}
