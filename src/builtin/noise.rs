//! Repeatable chance: hashes and noise for textures and placement.

/// A number from 0 up to 1 that looks random and depends only on the arguments.
///
/// The mixing steps are the finaliser of MurmurHash3 (Austin Appleby, public domain).
pub(super) fn chance(x: i32, y: i32, seed: u32) -> f32 {
    let mut h = (x as u32).wrapping_mul(0x9E37_79B1)
        ^ (y as u32).wrapping_mul(0x85EB_CA77)
        ^ seed.wrapping_mul(0xC2B2_AE3D);
    h = (h ^ h >> 16).wrapping_mul(0x85EB_CA6B);
    h = (h ^ h >> 13).wrapping_mul(0xC2B2_AE35);
    ((h ^ h >> 16) >> 8) as f32 / (1 << 24) as f32
}

/// Smooth noise from 0 to 1 that repeats every `period` cells.
fn value_noise(x: f32, y: f32, period: i32, seed: u32) -> f32 {
    let (cell_x, cell_y) = (x.floor(), y.floor());
    let ease = |t: f32| t * t * (3.0 - 2.0 * t);
    let (fx, fy) = (ease(x - cell_x), ease(y - cell_y));
    let at = |i: i32, j: i32| {
        let (x, y) = (cell_x as i32 + i, cell_y as i32 + j);
        chance(x.rem_euclid(period), y.rem_euclid(period), seed)
    };
    let row = |j: i32| at(0, j) + (at(1, j) - at(0, j)) * fx;
    row(0) + (row(1) - row(0)) * fy
}

/// Noise of several octaves from 0 to 1 over the unit square, where it repeats; `cells` is the coarsest grid.
pub(super) fn cloud(u: f32, v: f32, cells: i32, octaves: u32, seed: u32) -> f32 {
    let (mut sum, mut weight, mut total, mut period) = (0.0, 1.0, 0.0, cells);
    for octave in 0..octaves {
        let p = period as f32;
        sum += weight * value_noise(u * p, v * p, period, seed + octave);
        total += weight;
        (weight, period) = (weight * 0.55, period * 2);
    }
    sum / total
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chance_fills_the_unit_interval_evenly() {
        let draws: Vec<f32> = (0..10_000).map(|i| chance(i % 100, i / 100, 3)).collect();
        assert!(draws.iter().all(|d| (0.0..1.0).contains(d)));
        let mean = draws.iter().sum::<f32>() / 10_000.0;
        // The standard error of the mean is 0.289 / 100; five of them.
        assert!((mean - 0.5).abs() < 0.015, "{mean}");
    }

    #[test]
    fn clouds_repeat_at_the_border() {
        for i in 0..20 {
            let t = i as f32 / 20.0;
            let (a, b) = (cloud(0.0, t, 4, 4, 1), cloud(1.0, t, 4, 4, 1));
            assert!((a - b).abs() < 1e-4, "{a} {b}");
        }
    }
}
