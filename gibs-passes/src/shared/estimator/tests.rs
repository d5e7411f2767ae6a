//! Tests of `shared/estimator.rs`.
use super::*;
use crate::shared::hash;

fn run(frames: u32, rays: u32, value: impl Fn(u32) -> Vec3) -> SurfelIrradiance {
    let mut state = SurfelIrradiance::default();
    for i in 0..frames {
        state = update(&state, value(i), rays, i, true);
    }
    state
}

/// Surfels of one cell, each with samples of its own, which judge their drift together.
fn cell(surfels: u32, frames: u32, sample: impl Fn(u32, u32) -> f32) -> Vec<SurfelIrradiance> {
    let mut states = vec![SurfelIrradiance::default(); surfels as usize];
    for frame in 0..frames {
        let drift = states.iter().fold(Drift::default(), |sum, s| sum.with(s));
        let [share, change] = to_forget(&drift, &Drift::default()).to_array();
        for (i, state) in (0..).zip(&mut states) {
            let kept = forget(state, share, change, frame);
            *state = update(&kept, Vec3::splat(sample(i, frame)), 4, frame, false);
        }
    }
    states
}

/// Bright once in `1 / chance` times, with a mean of one.
fn rare(i: u32, frame: u32, seed: u32, chance: f32) -> f32 {
    let bright = hash::unit(hash::hash3(i, frame, seed)) < chance;
    if bright { 1.0 / chance } else { 0.0 }
}

fn mean(states: &[SurfelIrradiance]) -> f32 {
    states.iter().map(|s| s.mean.x).sum::<f32>() / states.len() as f32
}

#[test]
fn a_constant_is_kept() {
    let state = run(1000, 4, |_| Vec3::new(0.1, 2.0, 30.0));
    assert!((state.mean - Vec3::new(0.1, 2.0, 30.0)).abs().max_element() < 1e-5);
    assert_eq!((state.samples, state.drawn), (4000, 4000));
}

/// Uniform noise on [0, 2): mean 1, variance 1/3. After 1000 frames weights of at most 2i/n^2 leave a standard error of at
/// most sqrt(4/3 / 1000 / 3) = 0.021; 5 of those are 0.105.
#[test]
fn noise_converges_to_its_mean() {
    for seed in 0..20 {
        let noise = |i| Vec3::splat(2.0 * hash::unit(hash::hash2(i, seed)));
        let state = run(1000, 4, noise);
        assert!(
            (state.mean.x - 1.0).abs() < 0.105,
            "seed {seed}: {}",
            state.mean.x
        );
    }
}

/// Of one ray, the variance of uniform noise on [0, 2) in samples of 4 is 4/3; the short mean of samples of variance 1/3
/// has 0.08 / 1.92 of that. Both are estimates over about 25 samples: a relative error of sqrt(2 / 25) = 0.28 each, and
/// less in the mean over 40 runs, 0.045; 4 of those are 0.18.
#[test]
fn variances_are_those_of_a_ray_and_of_the_short_mean() {
    let (mut ray, mut short) = (0.0, 0.0);
    for seed in 0..40 {
        let noise = |i| Vec3::splat(2.0 * hash::unit(hash::hash2(i, seed)));
        let state = run(500, 4, noise);
        ray += state.variance / 40.0;
        short += state.short_noise / 40.0;
    }
    assert!((ray / (4.0 / 3.0) - 1.0).abs() < 0.18, "{ray}");
    let expected = SHORT_BLEND / (2.0 - SHORT_BLEND) / 3.0;
    assert!((short / expected - 1.0).abs() < 0.18, "{short}");
}

/// While the mean is a plain one, the variance is the mean of the first guess, n times the sample squared, and of a ray's own
/// variance once for every later sample. Of eight samples of four rays, uniform in 0 to 2: (4 (1 + 1/3) + 7 * 4/3) / 8. One run
/// is off by a third; the mean of 2000 by 0.0075, and four of those are 0.03.
#[test]
fn the_first_rays_have_the_variance_of_all() {
    let runs = (0..2000).map(|seed| {
        let noise = |i| Vec3::splat(2.0 * hash::unit(hash::hash2(i, seed)));
        run(8, 4, noise).variance
    });
    let mean = runs.sum::<f32>() / 2000.0;
    let expected = (4.0 * (4.0 / 3.0) + 7.0 * (4.0 / 3.0)) / 8.0;
    assert!(
        (mean / expected - 1.0).abs() < 0.03,
        "{mean}, not {expected}"
    );
}

/// Samples that are 0 but for one in twenty, which is 20: the standard error of a surfel is sqrt(4/3 * 19 / 1000) =
/// 0.16, of the mean over 16 runs of 32 surfels 0.0070; 5 of those are 0.035. An estimator that follows each
/// surfel's own short mean comes out 8 % low on the like.
#[test]
fn rare_light_is_not_lost() {
    let runs = (0..16).map(|seed| mean(&cell(32, 1000, |i, f| rare(i, f, seed, 0.05))));
    let mean = runs.sum::<f32>() / 16.0;
    assert!((mean - 1.0).abs() < 0.035, "{mean}");
}

/// Chance alone makes a cell forget little: over 16 runs, 90 % of the rays still count in the mean.
#[test]
fn chance_is_not_taken_for_a_change() {
    let counted = (0..16).map(|seed| {
        let states = cell(32, 1000, |i, f| rare(i, f, seed, 0.05));
        states[0].samples as f32 / 4000.0
    });
    let counted = counted.sum::<f32>() / 16.0;
    assert!(counted > 0.9, "{counted}");
}

/// A plain mean would keep 400/430 of the light.
#[test]
fn a_light_that_went_out_is_gone_within_thirty_frames() {
    for seed in 0..8 {
        let states = cell(32, 430, |i, f| match f < 400 {
            true => rare(i, f, seed, 0.2),
            false => 0.0,
        });
        assert!(mean(&states) < 0.05, "{} is left", mean(&states));
    }
}

/// Half the light goes: within thirty frames the mean is nearer to what is left than to what was.
#[test]
fn a_light_that_fades_is_followed() {
    for seed in 0..8 {
        let states = cell(32, 430, |i, f| {
            rare(i, f, seed, 0.2) * if f < 400 { 1.0 } else { 0.5 }
        });
        let left = mean(&states);
        assert!((0.4..0.65).contains(&left), "{left}");
    }
}

#[test]
fn a_cell_follows_all_others_unless_it_knows_better() {
    let share = |cell, everywhere| {
        let drift = |sum| Drift {
            sum,
            noise: 1.0,
            ..Drift::default()
        };
        to_forget(&drift(cell), &drift(everywhere)).x
    };
    assert_eq!(share(0.0, 0.0), 0.0);
    assert_eq!(share(-5.0, 0.0), 1.0);
    assert_eq!(share(-1.0, -9.0), 1.0);
    assert_eq!(share(0.5, -9.0), 0.0);
    assert_eq!(share(1.0, 9.0), 1.0);
    // What is not significant is no measure of the change.
    let few = Drift {
        sum: -0.36,
        noise: 0.1,
        level: 1.0,
        pad: 0,
    };
    let all = Drift {
        sum: -100.0,
        noise: 1.0,
        level: 500.0,
        pad: 0,
    };
    assert_eq!(to_forget(&few, &all), Vec2::new(1.0, 0.2));
    let half = share(-0.25, -9.0);
    assert!((0.4..0.6).contains(&half), "{half}");
}

#[test]
fn what_is_forgotten_counts_for_fewer_rays() {
    let state = run(200, 4, |_| Vec3::ONE);
    let half = forget(&state, 0.5, 1.0, 200);
    assert_eq!((half.samples, half.since), (400, 100));
    assert_eq!(forget(&state, 0.0, 1.0, 200), state);
    // Of a ray's variance of 1, 1 / (8 * 0.02)^2 = 39 rays leave an error of 8 * 2 %.
    let noisy = SurfelIrradiance {
        variance: 1.0,
        ..state
    };
    assert_eq!(forget(&noisy, 1.0, 0.02, 200).samples, 39);
    assert_eq!(forget(&noisy, 1.0, 0.0, 200), noisy);
    let none = forget(&state, 1.0, 1.0, 200);
    let anew = update(&none, Vec3::splat(3.0), 2, 200, false);
    assert_eq!((anew.samples, anew.since, anew.drawn), (2, 200, 802));
    assert_eq!(anew.mean, Vec3::splat(3.0));
}

#[test]
fn the_clamp_keeps_the_colour_and_cuts_nothing_else() {
    let state = run(200, 4, |i| Vec3::splat(hash::unit(hash::hash2(i, 5))));
    assert_eq!(clamped(&state, Vec3::ONE, 4), Vec3::ONE);
    let cut = clamped(&state, Vec3::new(100.0, 50.0, 0.0), 4);
    assert!(cut.x < 100.0 && (cut.x - 2.0 * cut.y).abs() < 1e-5 && cut.z == 0.0);
    // Mean 1/2, and eight times the deviation of about sqrt(1/12).
    assert!((2.0..4.0).contains(&luminance(cut)), "{cut}");
}

#[test]
fn scaling_by_a_power_of_two_is_exact() {
    let noise = |i: u32| Vec3::splat(hash::unit(hash::hash2(i, 3)));
    let one = run(300, 2, noise);
    let many = run(300, 2, |i| noise(i) * 1024.0);
    assert_eq!(one.mean * 1024.0, many.mean);
    let drift = |state: &SurfelIrradiance| Drift::default().with(state).relative();
    assert_eq!(drift(&one), drift(&many));
}

#[test]
fn darkness_stays_finite() {
    let states = cell(4, 100, |_, _| 0.0);
    assert!(
        states
            .iter()
            .all(|s| s.mean == Vec3::ZERO && s.short_noise == 0.0)
    );
}

/// 100 000 frames: the count stays bounded and the mean stays put.
#[test]
fn a_long_life_ends_nowhere() {
    let state = run(100_000, 4, |i| {
        Vec3::splat(0.5 + hash::unit(hash::hash2(i, 9)))
    });
    assert_eq!(state.samples, MOST_SAMPLES);
    assert!((MOST_SAMPLES / 2..MOST_SAMPLES).contains(&state.drawn));
    assert!((state.mean.x - 1.0).abs() < 0.01, "{}", state.mean.x);
}
