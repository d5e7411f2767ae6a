//! The filters of FLIP. All are sums of products of a function of x and one of y.
use std::f64::consts::PI;

use rayon::prelude::*;

/// An odd number of weights; the middle one is for the pixel itself.
pub struct Kernel(Vec<f32>);

/// Parameters (a1, b1), (a2, b2) of the contrast sensitivity for the achromatic, the red-green and
/// the blue-yellow channel, b in square degrees (the paper's table 1).
const SENSITIVITY: [&[(f64, f64)]; 3] = [
    &[(1.0, 0.0047)],
    &[(1.0, 0.0053)],
    &[(34.1, 0.04), (13.5, 0.025)],
];

/// The width in degrees of the features that the eye is keenest on.
const FEATURE_WIDTH: f64 = 0.082;

/// For each opponent channel Gaussians with their weights: the inverse Fourier transform of the
/// contrast sensitivity, a sqrt(pi / b) exp(-pi^2 d^2 / b) at d degrees, normalised to the sum 1 in
/// the plane.
pub fn contrast_sensitivity(pixels_per_degree: f32) -> [Vec<(f32, Kernel)>; 3] {
    let ppd = f64::from(pixels_per_degree);
    // exp(-pi^2 d^2 / b) has the standard deviation sqrt(b / 2) / pi; all reach as far as the
    // widest.
    let widest = SENSITIVITY
        .iter()
        .copied()
        .flatten()
        .map(|&(_, b)| b)
        .fold(0.0, f64::max);
    let radius = (3.0 * (widest / 2.0).sqrt() / PI * ppd).ceil() as i32;
    SENSITIVITY.map(|gaussians| {
        let parts: Vec<(f64, Vec<f64>)> = gaussians
            .iter()
            .map(|&(a, b)| {
                let at = |x: i32| (-(PI * f64::from(x) / ppd).powi(2) / b).exp();
                let values: Vec<f64> = (-radius..=radius).map(at).collect();
                let sum: f64 = values.iter().sum();
                let weight = a * (PI / b).sqrt() * sum * sum;
                (weight, values.iter().map(|v| v / sum).collect())
            })
            .collect();
        let total: f64 = parts.iter().map(|(weight, _)| weight).sum();
        parts
            .into_iter()
            .map(|(weight, values)| ((weight / total) as f32, Kernel::new(values)))
            .collect()
    })
}

/// The smoothing Gaussian and its first derivative (edges) and second derivative (points). The
/// positive weights of a derivative sum to 1 and its negative ones to -1.
pub fn feature_kernels(pixels_per_degree: f32) -> [Kernel; 3] {
    let sigma = 0.5 * FEATURE_WIDTH * f64::from(pixels_per_degree);
    let radius = (3.0 * sigma).ceil() as i32;
    let sample = |shape: &dyn Fn(f64) -> f64| -> Vec<f64> {
        let at = |x: i32| shape(f64::from(x)) * (-0.5 * (f64::from(x) / sigma).powi(2)).exp();
        (-radius..=radius).map(at).collect()
    };
    let derivatives: [&dyn Fn(f64) -> f64; 3] = [&|_| 1.0, &|x| -x, &|x| (x / sigma).powi(2) - 1.0];
    derivatives.map(|shape| {
        let values = sample(shape);
        let positive: f64 = values.iter().map(|v| v.max(0.0)).sum();
        let negative: f64 = values.iter().map(|v| (-v).max(0.0)).sum();
        let normalised = |v: f64| {
            if v > 0.0 {
                v / positive
            } else if v < 0.0 {
                v / negative
            } else {
                0.0
            }
        };
        Kernel::new(values.into_iter().map(normalised).collect())
    })
}

impl Kernel {
    fn new(weights: Vec<f64>) -> Self {
        Self(weights.into_iter().map(|w| w as f32).collect())
    }

    fn radius(&self) -> usize {
        self.0.len() / 2
    }
}

/// Correlates a plane with `horizontal` along its rows and `vertical` along its columns. Beyond a
/// border the outermost pixel repeats.
pub fn convolve(plane: &[f32], width: usize, horizontal: &Kernel, vertical: &Kernel) -> Vec<f32> {
    let rows = convolve_rows(plane, width, horizontal);
    convolve_columns(&rows, width, vertical)
}

fn convolve_rows(plane: &[f32], width: usize, kernel: &Kernel) -> Vec<f32> {
    let radius = kernel.radius();
    let mut result = vec![0.0; plane.len()];
    result
        .par_chunks_exact_mut(width)
        .zip(plane.par_chunks_exact(width))
        .for_each_init(Vec::new, |padded, (out, row)| {
            padded.clear();
            padded.extend(std::iter::repeat_n(row[0], radius));
            padded.extend_from_slice(row);
            padded.extend(std::iter::repeat_n(row[width - 1], radius));
            // Taps outside, pixels inside: the inner loop is a plain multiply-add of two slices.
            for (tap, weight) in kernel.0.iter().enumerate() {
                add_scaled(out, &padded[tap..tap + width], *weight);
            }
        });
    result
}

fn convolve_columns(plane: &[f32], width: usize, kernel: &Kernel) -> Vec<f32> {
    let radius = kernel.radius();
    let height = plane.len() / width;
    let mut result = vec![0.0; plane.len()];
    result
        .par_chunks_exact_mut(width)
        .enumerate()
        .for_each(|(y, out)| {
            for (tap, weight) in kernel.0.iter().enumerate() {
                let row = (y + tap).saturating_sub(radius).min(height - 1);
                add_scaled(out, &plane[row * width..(row + 1) * width], *weight);
            }
        });
    result
}

fn add_scaled(out: &mut [f32], values: &[f32], weight: f32) {
    for (out, value) in out.iter_mut().zip(values) {
        *out += weight * value;
    }
}
