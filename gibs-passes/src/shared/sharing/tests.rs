//! Tests of `shared/sharing.rs`.
use super::*;
use crate::data::SurfelPose;
use crate::shared::{estimator, hash, lookup, plane};

#[test]
fn packing_keeps_trust_rays_and_variance() {
    for i in 0..10_000u32 {
        let unit = |k| hash::unit(hash::hash2(i, k));
        let said = Said {
            mean: Vec3::new(unit(0), unit(1), unit(2)),
            trust: 1.0 - unit(4),
            rays: 10f32.powf(16.0 * unit(5) - 8.0),
            ray_variance: 10f32.powf(12.0 * unit(6) - 6.0),
        };
        let back = Said::unpack(&said.pack());
        assert_eq!(back.mean, said.mean);
        assert!(back.trust > 0.0 && (back.trust - said.trust).abs() <= 1.0 / TRUST_STEPS);
        assert!(back.rays <= said.rays && said.rays - back.rays < back.rays / 64.0);
        let (kept, whole) = (back.ray_variance, said.ray_variance);
        assert!(kept <= whole && whole - kept < kept / 4.0);
        assert_eq!(Said::unpack(&back.pack()), back);
    }
    let none = Said::default();
    assert_eq!(Said::unpack(&none.pack()), none);
    // At their extremes, none touches another.
    let most = Said {
        trust: 1.0,
        rays: MOST_WORTH,
        ray_variance: MOST_VARIANCE,
        ..none
    };
    assert_eq!(Said::unpack(&most.pack()), most);
    let tiny = Said {
        rays: 0.0,
        ray_variance: f32::MIN_POSITIVE,
        ..most
    };
    assert_eq!(Said::unpack(&tiny.pack()), tiny);
    let least = Said {
        trust: 1e-9,
        ..none
    };
    assert!(Said::unpack(&least.pack()).trust > 0.0);
}

/// Neighbours with the same mean, and a variance of a ray of 1: that of the least spread makes them worth 400 rays.
#[test]
fn the_guess_counts_by_how_little_surfels_differ() {
    let around = SurfelIrradiance {
        mean: Vec3::ONE,
        samples: 100,
        variance: 1.0,
        ..SurfelIrradiance::default()
    };
    let mut asked = Asked::default();
    asked.add(&around, 1.0, 100, false);
    asked.add(&around, 1.0, 100, false);
    let said = asked.said();
    let rays = 1.0 / (LEAST_SPREAD * LEAST_SPREAD);
    assert!((said.rays / rays - 1.0).abs() < 1e-4, "{}", said.rays);
    assert_eq!(said.ray_variance, 1.0);
    let own = SurfelIrradiance {
        mean: Vec3::ZERO,
        samples: 50,
        ..around
    };
    let light = light(&own, 0, &said);
    assert!((light.irradiance.x - rays / (rays + 50.0)).abs() < 1e-4);
    // Scale says nothing.
    let bright = SurfelIrradiance {
        mean: around.mean * 1024.0,
        variance: around.variance * 1_048_576.0,
        ..around
    };
    let mut asked = Asked::default();
    asked.add(&bright, 1.0, 100, false);
    asked.add(&bright, 1.0, 100, false);
    assert_eq!(asked.said().pack().packed, said.pack().packed);
}

/// Where one ray in so many finds light, one of nine surfels has had one, and their rays vary as such rays do, all say the mean
/// of all: what the lucky one gives away is what the others take.
#[test]
fn what_a_lucky_one_gives_away_the_others_take() {
    let (brightness, samples) = (16.0f32, 16);
    let dark = SurfelIrradiance {
        samples,
        ..SurfelIrradiance::default()
    };
    let lucky = SurfelIrradiance {
        mean: Vec3::splat(brightness / samples as f32),
        variance: brightness * brightness / samples as f32,
        ..dark
    };
    // Those around each are the same nine, of which it is the nearest.
    let shown = |own: &SurfelIrradiance, around: &[(SurfelIrradiance, f32)]| {
        let mut asked = Asked::default();
        asked.add(own, 1.0 / OWN_PART, 100, true);
        around
            .iter()
            .for_each(|(state, weight)| asked.add(state, *weight, 100, false));
        light(own, 100, &Said::unpack(&asked.said().pack()))
            .irradiance
            .x
    };
    let bright = shown(&lucky, &[(dark, 8.0)]);
    let dim = shown(&dark, &[(dark, 7.0), (lucky, 1.0)]);
    let before = lucky.mean.x;
    assert!(
        (bright + 8.0 * dim - before).abs() < 0.05 * before,
        "{bright} + 8 * {dim}"
    );
    assert!(
        bright < 0.2 * before && dim > 0.1 * before,
        "{bright}, {dim}"
    );
}

/// Surfels in rows and columns on a plane that closes on itself, with the weights of sharing, where one ray in a hundred finds
/// light: what they say is together what they have found, but for 4 %. Where the surfel has no part in the mean, 9 % are lost
/// after two frames.
#[test]
fn rare_light_is_not_lost_by_sharing() {
    const SIDE: u32 = 64;
    const APART: f32 = 0.7;
    let found = |surfel: u32, frames: u32| {
        let mut state = SurfelIrradiance::default();
        for frame in 0..frames {
            let ray = |ray: u32| hash::unit(hash::hash3(surfel, frame, ray)) < 0.01;
            let lit = (0..4).filter(|&k| ray(k)).count() as f32;
            state = estimator::update(&state, Vec3::splat(25.0 * lit), 4, frame, false);
        }
        state
    };
    let wide = SurfelPose {
        radius: REACH as f32,
        normal: Vec3::Y,
        mark: plane::pack(Vec3::Y),
        ..SurfelPose::default()
    };
    for frames in [2, 8, 16] {
        let states: Vec<_> = (0..SIDE * SIDE).map(|i| found(i, frames)).collect();
        let said = |own: u32| {
            let mut asked = Asked::default();
            for (x, y) in (-3..=3i32).flat_map(|y| (-3..=3i32).map(move |x| (x, y))) {
                let d = Vec3::new(x as f32, 0.0, y as f32) * APART;
                let column = (own % SIDE).wrapping_add_signed(x) % SIDE;
                let row = (own / SIDE).wrapping_add_signed(y) % SIDE;
                let state = &states[(row * SIDE + column) as usize];
                let weight = lookup::nearness(d, &wide);
                asked.add(state, weight, frames, (x, y) == (0, 0));
            }
            let said = Said::unpack(&asked.said().pack());
            light(&states[own as usize], frames, &said).irradiance.x
        };
        let before: f32 = states.iter().map(|state| state.mean.x).sum();
        let after: f32 = (0..SIDE * SIDE).map(said).sum();
        assert!(
            (after / before - 1.0).abs() < 0.06,
            "{frames} frames: {after} of {before}"
        );
    }
}

/// In the dark beside bright surfels, many rays that all found little are believed, few are not: the share of what the
/// neighbours say falls faster than the rays grow.
#[test]
fn the_dark_beside_the_bright_stays_dark() {
    let bright = SurfelIrradiance {
        mean: Vec3::ONE,
        samples: 64,
        variance: 4.0,
        ..SurfelIrradiance::default()
    };
    let shown = |samples: u32| {
        let dark = SurfelIrradiance {
            mean: Vec3::splat(0.05),
            samples,
            variance: 0.01,
            ..SurfelIrradiance::default()
        };
        let mut asked = Asked::default();
        asked.add(&dark, 4.0, 0, true);
        (0..4).for_each(|_| asked.add(&bright, 0.5, 0, false));
        light(&dark, 0, &Said::unpack(&asked.said().pack()))
            .irradiance
            .x
    };
    // Pooled, a ray varies by (4 k 0.01 + 2 * 4) / (4 k + 2), where k is 1 up to 8 rays. Half of the dark one's weight of 4, by
    // its rays, and 2 of 64 rays make up the mean, the noise, and what they differ by.
    for (samples, k) in [(4, 1.0f32), (8, 1.0), (64, 8.0), (640, 80.0)] {
        let pooled = (4.0 * k * 0.01 + 8.0) / (4.0 * k + 2.0);
        let (dark, bright) = (2.0 * samples as f32, 2.0 * 64.0);
        let all = dark + bright;
        let mean = (dark * 0.05 + bright) / all;
        let noise = (dark * 0.01 / samples as f32 + bright * 4.0 / 64.0) / all;
        let apart = (dark * 0.05 * 0.05 + bright) / all - mean * mean - noise;
        let spread = apart.max(0.0) + (LEAST_SPREAD * mean).powi(2);
        let rays = pooled / spread;
        let expected = 0.05 + (mean - 0.05) * rays / (rays + samples as f32);
        let found = shown(samples);
        // Packed rays are short by 1/64 at most, and the share by a quarter of that.
        assert!(
            (found - expected).abs() < 1.0 / 256.0,
            "{samples} rays: {found}, not {expected}"
        );
    }
    assert!(shown(4) > 0.9 && shown(640) < 0.06);
}

/// What a surfel's own rays have found does not tell how many it gets.
#[test]
fn the_variance_said_is_that_of_the_others() {
    let state = |mean: f32, variance: f32, samples| SurfelIrradiance {
        mean: Vec3::splat(mean),
        samples,
        variance,
        ..SurfelIrradiance::default()
    };
    let said = |own: &SurfelIrradiance| {
        let mut asked = Asked::default();
        asked.add(own, 1.0, 10, true);
        asked.add(&state(1.0, 6.0, 30), 0.5, 10, false);
        asked.add(&state(4.0, 2.0, 10), 0.5, 10, false);
        asked.said().ray_variance
    };
    // Weighed by their rays, their mean is (30 + 40) / 40; a ray of either counts alike, and varies by 4.
    let expected = 4.0 / (1.75 * 1.75);
    for own in [
        state(0.0, 0.0, 50),
        state(100.0, 1e6, 50),
        state(1.0, 1.0, 5000),
    ] {
        assert!((said(&own) / expected - 1.0).abs() < 1e-6);
    }
    // Where light is going, what it has been counts: twice as bright, a quarter of the relative variance.
    let going = |short: f32| {
        let mut asked = Asked::default();
        let neighbour = SurfelIrradiance {
            short_mean: Vec3::splat(short),
            ..state(1.0, 6.0, 30)
        };
        asked.add(&state(1.0, 6.0, 30), 1.0, 10, true);
        asked.add(&neighbour, 1.0, 10, false);
        asked.said().ray_variance
    };
    assert_eq!((going(0.5), going(2.0)), (6.0, 1.5));
}

/// Every surfel asks once in any period, when it is born, and while it is fresh.
#[test]
fn every_surfel_asks_in_turn() {
    let state = SurfelIrradiance {
        samples: 100,
        ..SurfelIrradiance::default()
    };
    for surfel in [0, 63, 64, 1000] {
        for first in 100..200 {
            let times = (first..first + PERIOD)
                .filter(|&frame| is_due(surfel, &state, 0.0, frame))
                .count();
            assert_eq!(times, 1, "surfel {surfel} from frame {first}");
        }
        assert!((0..FRESH).all(|frame| is_due(surfel, &state, 0.0, frame)));
        assert!((100..200).all(|frame| is_due(surfel, &state, 0.1, frame)));
        assert!((100..200).all(|frame| is_due(surfel, &SurfelIrradiance::default(), 0.0, frame)));
    }
}

/// What is packed is never taken for the word of one that is to ask.
#[test]
fn no_neighbours_are_as_many_as_a_request() {
    let said = Said {
        mean: Vec3::ONE,
        trust: 1.0,
        rays: MOST_WORTH,
        ray_variance: MOST_VARIANCE,
    };
    assert_ne!(said.pack().packed, ASKS.packed);
    assert_ne!(Said::default().pack().packed, ASKS.packed);
}
