//! Tests of `shared/depth.rs`.
use super::*;
use crate::shared::hash;

#[test]
fn chebyshev_is_one_up_to_the_mean_and_falls_beyond() {
    let m = Vec2::new(0.4, 0.17);
    assert_eq!(chebyshev(m, 0.4), 1.0);
    // Variance 0.01, half a standard deviation beyond: bound 4/5, after the floor 1/2, cubed 1/8.
    assert!((chebyshev(m, 0.45) - 1.0 / 8.0).abs() < 1e-4);
    assert_eq!(chebyshev(m, 0.9), 0.0);
    // Zero variance never divides by zero.
    assert!(chebyshev(Vec2::new(0.5, 0.25), 0.5 + 1e-6).is_finite());
}

/// A wall at 0.3 of the diameter is at 0.6 of one half as long, and what was open stays open; over one twice as long, nothing
/// is known beyond the half.
#[test]
fn depth_functions_follow_the_diameter() {
    let mut depth = SurfelDepth::OPEN;
    depth.texels[0] = pack_moments(Vec2::new(0.3, 0.09));
    depth.texels[1] = pack_moments(Vec2::splat(FARTHEST));
    let close = |texel: u32, m: Vec2| (moments(texel) - m).abs().max_element() < 1e-4;
    let shrunk = rescaled(&depth, 2.0);
    assert!(close(shrunk.texels[0], Vec2::new(0.6, 0.36)));
    assert!(close(shrunk.texels[1], Vec2::ONE));
    let grown = rescaled(&depth, 0.5);
    assert!(close(grown.texels[0], Vec2::new(0.15, 0.0225)));
    assert!(close(grown.texels[1], Vec2::new(0.5, 0.25)));
    // What no ray has reached stays so, and nothing else looks like it.
    for rescaled in [shrunk, grown] {
        let unknown = rescaled.texels.map(|texel| texel == UNKNOWN);
        assert_eq!(unknown.iter().filter(|&&u| u).count(), 14);
    }
}

/// A wall at the rim, beyond the radius, is not close; something near in one direction is, and so is everything where a surfel
/// has more than doubled.
#[test]
fn what_is_hemmed_in_is_crowded() {
    let with = |texel: f32| {
        let mut depth = SurfelDepth::OPEN;
        depth.texels[5] = pack_moments(Vec2::splat(texel));
        depth
    };
    assert!(!is_crowded(&SurfelDepth::OPEN));
    assert!(!is_crowded(&with(0.5)));
    assert!(!is_crowded(&with(0.26)));
    assert!(is_crowded(&with(0.24)));
    // A surfel of half the size is half as close to it.
    assert!(!is_crowded(&rescaled(&with(0.24), 2.0)));
    // All directions open, up to the radius of before.
    let mut open = SurfelDepth::OPEN;
    open.texels.fill(pack_moments(Vec2::splat(FARTHEST)));
    assert!(!is_crowded(&rescaled(&open, 0.51)));
    assert!(is_crowded(&rescaled(&open, 0.45)));
}

/// One whose directions all are open up to the radius lets everything within it through, wherever that is; a step less in one
/// direction, and it may hide something.
#[test]
fn what_is_open_hides_nothing_within_the_radius() {
    let pose = SurfelPose {
        radius: 0.37,
        normal: Vec3::new(0.48, -0.6, 0.64),
        ..SurfelPose::default()
    };
    for case in 0..2000 {
        let random = |k: u32| hash::hash2(case, k);
        let texel = |t: usize| (0x8000 + random(t as u32) % 0x8000) | random(100 + t as u32) << 16;
        let depth = SurfelDepth {
            texels: std::array::from_fn(texel),
        };
        assert!(is_open(&depth));
        let unit = |k| hash::unit(random(k));
        let way = Vec3::new(unit(20) - 0.5, unit(21) - 0.5, unit(22) - 0.5).normalize();
        let far = [unit(23), 1.0][case as usize % 2];
        assert_eq!(visibility(&depth, &pose, way * (far * pose.radius)), 1.0);
        let mut close = depth;
        close.texels[case as usize % 16] = 0x7fff;
        assert!(!is_open(&close));
    }
}

#[test]
fn moments_survive_packing_at_their_extremes() {
    for m in [Vec2::ZERO, Vec2::ONE, Vec2::new(0.25, 0.75)] {
        assert!((moments(pack_moments(m)) - m).abs().max_element() < 1.0 / 65_535.0);
    }
}

#[test]
fn a_uniform_depth_function_is_uniform() {
    let depth = SurfelDepth {
        texels: [pack_moments(Vec2::new(0.5, 0.25)); 16],
    };
    for d in [Vec3::Z, Vec3::X, Vec3::NEG_Y, Vec3::new(0.6, 0.0, 0.8)] {
        assert!(
            (depth_moments(&depth, d) - Vec2::new(0.5, 0.25))
                .abs()
                .max_element()
                < 2e-5
        );
    }
}

/// Beyond the diameter a depth function knows nothing: visibility ends there, openness stays what it is at the diameter. A wall
/// before that ends both.
#[test]
fn openness_goes_on_beyond_the_diameter() {
    let pose = SurfelPose {
        position: Vec3::ZERO,
        radius: 0.5,
        normal: Vec3::Z,
        mark: 0,
    };
    let walled = SurfelDepth {
        texels: [pack_moments(Vec2::new(0.5, 0.25)); 16],
    };
    for d in [Vec3::Z, Vec3::X, Vec3::new(0.6, 0.0, 0.8)] {
        for far in [0.001, 0.3, 0.999] {
            let at = d * far;
            let seen = visibility(&SurfelDepth::OPEN, &pose, at);
            assert_eq!(seen, openness(&SurfelDepth::OPEN, &pose, at), "{at}");
            assert_eq!(seen, 1.0, "{at}");
            let seen = visibility(&walled, &pose, at);
            assert_eq!(seen, openness(&walled, &pose, at), "{at}");
            assert_eq!(seen, if far < 0.5 { 1.0 } else { 0.0 }, "{at}");
        }
        for far in [1.2, 3.0, 1e6] {
            let at = d * far;
            assert_eq!(visibility(&SurfelDepth::OPEN, &pose, at), 0.0, "{at}");
            assert_eq!(openness(&SurfelDepth::OPEN, &pose, at), 1.0, "{at}");
            assert_eq!(openness(&walled, &pose, at), 0.0, "{at}");
        }
    }
}
