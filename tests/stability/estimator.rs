//! The estimator over a hundred thousand frames, on every backend; and depth functions without variance: shared functions
//! alone, which `tests/twins` holds every backend to.
use super::common::all_backends;
use super::lives::{Life, RAYS, means};
use super::measure::{U, deviation, mean};
use gibs::passes::shared::depth::{CHEBYSHEV_FLOOR, FARTHEST, LEAST_VARIANCE, chebyshev, moments};
use gibs::passes::shared::{depth, estimator};
use glam::Vec2;

/// A full mean takes a share `s = 4 / 131 076` of each sample, of deviation `1 / sqrt(3)`: it scatters by `sqrt(s / (2 - s) /
/// 3) = 0.23 %`, and 5 of those are 1.13 %. It is the sum of as many terms as it remembers, `1 / s`, each off by half a
/// rounding of the mean: a drift of at most `U / s = 0.20 %`. The bound is both. Over the level it is the same from 1e-12 to
/// 1e12 W/m^2.
///
/// Of drift: the mean over all frames of 12 runs scatters by what is independent in it, which is one mean in `2 / s = 65 538`
/// frames, about one a run; the bound is 5 of the deviations of a mean over 12, and the drift by rounding.
#[test]
fn a_hundred_thousand_frames_stay_at_the_mean() {
    let share = f64::from(RAYS) / f64::from(estimator::MOST_SAMPLES + RAYS);
    let scatter = (share / (2.0 - share) / 3.0).sqrt();
    let drift = U / share;
    let bound = 5.0 * scatter + drift;
    let levels = [1e-12f32, 1.0, 1e12];
    let lives: Vec<Life> = levels
        .into_iter()
        .flat_map(|level| {
            (1..=12).map(move |seed| Life {
                level,
                seed,
                birth: 0,
            })
        })
        .collect();
    for backend in all_backends() {
        let name = backend.name();
        let found = means(backend.as_ref(), &lives);
        for (level, runs) in levels.into_iter().zip(found.chunks(12)) {
            let over = |m: &f32| f64::from(*m) / f64::from(level);
            let all = runs.iter().flatten().map(over);
            let worst = all.fold(0f64, |w, m| w.max((m - 1.0).abs()));
            let averages: Vec<f64> = runs
                .iter()
                .map(|run| mean(&run.iter().map(over).collect::<Vec<_>>()))
                .collect();
            let (off, spread) = (mean(&averages) - 1.0, deviation(&averages));
            let most = 5.0 * scatter / 12f64.sqrt() + drift;
            println!(
                "{name}: level {level:e}: worst {:.3} % (bound {:.3} %), over 12 runs {:+.4} % (bound {:.4} %), scatter {:.3} % (closed form {:.3} %)",
                worst * 100.0,
                bound * 100.0,
                off * 100.0,
                most * 100.0,
                spread * 100.0,
                scatter * 100.0
            );
            assert!(worst <= bound, "{name}: {level}: {worst}");
            assert!(off.abs() <= most, "{name}: {level}: {off}");
        }
    }
}

/// A constant is kept: each of the roundings moves the mean by half a unit in its last place at most, and none away from
/// the sample. So it is within one such unit, `2 U`, for ever.
#[test]
fn a_constant_is_kept_for_a_hundred_thousand_frames() {
    let lives = [1e-12f32, 0.1, 1.0 / 3.0, 1e12].map(|level| Life {
        level,
        seed: 0,
        birth: 0,
    });
    for backend in all_backends() {
        let name = backend.name();
        for (life, means) in lives.iter().zip(means(backend.as_ref(), &lives)) {
            let off = |m: &f32| (f64::from(*m) / f64::from(life.level) - 1.0).abs();
            let worst = means.iter().map(off).fold(0.0, f64::max);
            println!(
                "{name}: a constant of {:e}: off by {worst:.2e} (bound {:.2e})",
                life.level,
                2.0 * U
            );
            assert!(worst <= 2.0 * U, "{name}: {life:?}: {worst}");
        }
    }
}

/// Ages are differences of frame numbers modulo 2^32: a life that begins 50 000 frames before the number wraps has every bit of
/// one that begins at 0.
#[test]
fn a_life_across_the_wrap_has_the_same_bits() {
    let lives = [0, u32::MAX - 50_000].map(|birth| Life {
        level: 1.0,
        seed: 7,
        birth,
    });
    for backend in all_backends() {
        let name = backend.name();
        let found = means(backend.as_ref(), &lives);
        assert!(found[0] == found[1], "{name}");
        println!("{name}: a life across the wrap of the frame number: every bit is the same");
    }
}

/// Without variance, Chebyshev's bound is that of [`LEAST_VARIANCE`], v: `(v / (v + d^2) - 0.6) / 0.4` cubed, d beyond the
/// mean, and 0 from `d = sqrt(2 v / 3)` on. In `f32`, `d` is off by `2 U` of a diameter and each of some 8 operations by U: the
/// slope of the cube is at most `3 / 0.4 * 2 d / v <= 1300` there, which makes `1300 * 2 U + 60 U`. Moments that rounding has
/// made impossible, a square below that of the mean, count as no variance.
#[test]
fn chebyshev_without_variance_has_its_closed_form() {
    let (v, floor) = (f64::from(LEAST_VARIANCE), f64::from(CHEBYSHEV_FLOOR));
    let bound = (1300.0 * 2.0 + 60.0) * U;
    let mut worst = 0f64;
    for m in [0.0f32, 1e-3, 0.25, 0.5, 0.75, FARTHEST] {
        for impossible in [0.0, 1e-6, 1e-3] {
            let of = Vec2::new(m, m * m - impossible);
            for step in 0..=2000 {
                let t = m + step as f32 * 1e-5;
                let d = f64::from(t) - f64::from(m);
                let tight = ((v / (v + d * d) - floor) / (1.0 - floor)).max(0.0);
                let found = chebyshev(of, t);
                let off = (f64::from(found) - tight.powi(3)).abs();
                assert!(off <= bound, "{of} at {t}: {found}");
                worst = worst.max(off);
            }
            for t in [0.0, m, f32::MAX, f32::INFINITY] {
                let found = chebyshev(of, t);
                assert!((0.0..=1.0).contains(&found), "{of} at {t}: {found}");
            }
        }
    }
    println!("Chebyshev without variance: off by {worst:.2e} (bound {bound:.2e})");
}

/// Moments keep half a step of 16 bits, at both ends as well, so that the variance of a texel is right to two steps, 3.1e-5,
/// less than [`LEAST_VARIANCE`]: no texel of no variance shows one.
#[test]
fn packed_moments_of_no_variance_have_none() {
    let step = 1.0 / 65_535.0;
    let mut worst = 0f64;
    for i in 0..=65_535u32 {
        let m = i as f32 / 65_535.0;
        let back = moments(depth::pack_moments(Vec2::new(m, m * m)));
        let variance = f64::from(back.y) - f64::from(back.x) * f64::from(back.x);
        assert!(variance.abs() <= 2.0 * step, "{m}: {variance}");
        worst = worst.max(variance.abs());
    }
    assert!(worst < f64::from(LEAST_VARIANCE));
    println!(
        "moments of no variance: {worst:.2e} after packing (bound {:.2e})",
        2.0 * step
    );
}
