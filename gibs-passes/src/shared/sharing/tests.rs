//! Tests of `shared/sharing.rs`.
use super::*;
use crate::shared::hash;

#[test]
fn packing_keeps_trust_and_rays() {
    for i in 0..10_000u32 {
        let unit = |k| hash::unit(hash::hash2(i, k));
        let said = Said {
            mean: Vec3::new(unit(0), unit(1), unit(2)),
            trust: 1.0 - unit(4),
            rays: 10f32.powf(16.0 * unit(5) - 8.0),
        };
        let back = Said::unpack(&said.pack());
        assert_eq!(back.mean, said.mean);
        assert!(back.trust > 0.0 && (back.trust - said.trust).abs() <= 1.0 / TRUST_STEPS);
        assert!((back.rays / said.rays - 1.0).abs() < 1.0 / 65_536.0);
        assert_eq!(Said::unpack(&back.pack()), back);
    }
    let none = Said::default();
    assert_eq!(Said::unpack(&none.pack()), none);
    let least = Said {
        trust: 1e-9,
        ..none
    };
    assert!(Said::unpack(&least.pack()).trust > 0.0);
}

/// Two neighbours with the same mean and a variance of a ray of 1: of 100 rays each, their mean has the noise of 200. The
/// least spread makes it less by 0.0009.
#[test]
fn the_guess_counts_by_its_variance() {
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
    let rays = 1.0 / (1.0 / 200.0 + LEAST_SPREAD * LEAST_SPREAD);
    assert!((said.rays / rays - 1.0).abs() < 1e-4, "{}", said.rays);
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

/// Where all around is black, a surfel that happened on light believes it little.
#[test]
fn black_neighbours_are_believed() {
    let black = SurfelIrradiance {
        samples: 100,
        ..SurfelIrradiance::default()
    };
    let lucky = SurfelIrradiance {
        mean: Vec3::ONE,
        samples: 4,
        variance: 4.0,
        ..SurfelIrradiance::default()
    };
    let mut asked = Asked::default();
    asked.add(&lucky, 1.0, 0, true);
    (0..8).for_each(|_| asked.add(&black, 1.0, 100, false));
    let said = Said::unpack(&asked.said().pack());
    assert!(light(&lucky, 0, &said).irradiance.x < 0.01);
}

/// Every surfel asks once in a period, when it is born, and while it is fresh.
#[test]
fn every_surfel_asks_in_turn() {
    let state = SurfelIrradiance {
        samples: 100,
        ..SurfelIrradiance::default()
    };
    for surfel in [0, 63, 64, 1000] {
        let times = (100..200)
            .filter(|&frame| is_due(surfel, &state, 0.0, frame))
            .count();
        assert_eq!(times, 25);
        assert!((0..FRESH).all(|frame| is_due(surfel, &state, 0.0, frame)));
        assert!((100..200).all(|frame| is_due(surfel, &state, 0.1, frame)));
        assert!((100..200).all(|frame| is_due(surfel, &SurfelIrradiance::default(), 0.0, frame)));
    }
}
