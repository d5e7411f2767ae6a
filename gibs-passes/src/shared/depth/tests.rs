//! Tests of `shared/depth.rs`.
use super::*;
use crate::shared::hash;
use crate::shared::octahedral::hemisphere_decode;

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

const SIDE: u32 = 4;
const TEXELS: usize = (SIDE * SIDE) as usize;
const OPEN: Depth<'_> = of(&[UNKNOWN; TEXELS]);

const fn of(texels: &[u32; TEXELS]) -> Depth<'_> {
    Depth { texels, side: SIDE }
}

fn all(texels: &[u32]) -> impl Iterator<Item = u32> {
    texels.iter().copied()
}

/// A wall at 0.3 of the diameter is at 0.6 of one half as long, and what was open stays open; over one twice as long, nothing
/// is known beyond the half.
#[test]
fn depth_functions_follow_the_diameter() {
    let wall = pack_moments(Vec2::new(0.3, 0.09));
    let open = pack_moments(Vec2::splat(FARTHEST));
    let close = |texel: u32, m: Vec2| (moments(texel) - m).abs().max_element() < 1e-4;
    assert!(close(rescaled(wall, 2.0), Vec2::new(0.6, 0.36)));
    assert!(close(rescaled(open, 2.0), Vec2::ONE));
    assert!(close(rescaled(wall, 0.5), Vec2::new(0.15, 0.0225)));
    assert!(close(rescaled(open, 0.5), Vec2::new(0.5, 0.25)));
    // What no ray has reached stays so, and nothing else looks like it.
    for shrinks in [2.0, 0.5] {
        assert_eq!(rescaled(UNKNOWN, shrinks), UNKNOWN);
        assert_ne!(rescaled(wall, shrinks), UNKNOWN);
        assert_ne!(rescaled(open, shrinks), UNKNOWN);
    }
}

/// A wall at the rim, beyond the radius, is not close; something near in one direction is, and so is everything where a surfel
/// has more than doubled.
#[test]
fn what_is_hemmed_in_is_crowded() {
    // One direction in sixteen, whatever the side.
    for texels in [16, 32, 64] {
        let crowded = |texel: f32, shrinks: f32| {
            let near = pack_moments(Vec2::splat(texel));
            is_crowded((0..texels).map(|t| match t % 16 {
                5 => rescaled(near, shrinks),
                _ => UNKNOWN,
            }))
        };
        assert!(!is_crowded((0..texels).map(|_| UNKNOWN)));
        assert!(!crowded(0.5, 1.0));
        assert!(!crowded(0.26, 1.0));
        assert!(crowded(0.24, 1.0));
        // A surfel of half the size is half as close to it.
        assert!(!crowded(0.24, 2.0));
        // All directions open, up to the radius of before.
        let open = pack_moments(Vec2::splat(FARTHEST));
        let grown = |shrinks| is_crowded((0..texels).map(|_| rescaled(open, shrinks)));
        assert!(!grown(0.51));
        assert!(grown(0.45));
    }
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
        let texels: [u32; TEXELS] = std::array::from_fn(texel);
        assert!(is_open(all(&texels)));
        let unit = |k| hash::unit(random(k));
        let way = Vec3::new(unit(20) - 0.5, unit(21) - 0.5, unit(22) - 0.5).normalize();
        let far = [unit(23), 1.0][case as usize % 2];
        assert_eq!(
            visibility(of(&texels), &pose, way * (far * pose.radius)),
            1.0
        );
        let mut close = texels;
        close[case as usize % TEXELS] = 0x7fff;
        assert!(!is_open(all(&close)));
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
    let texels = [pack_moments(Vec2::new(0.5, 0.25)); 64];
    for side in 1..=8 {
        let texels = &texels[..count(side)];
        for d in [Vec3::Z, Vec3::X, Vec3::NEG_Y, Vec3::new(0.6, 0.0, 0.8)] {
            let found = depth_moments(Depth { texels, side }, d);
            assert!((found - Vec2::new(0.5, 0.25)).abs().max_element() < 2e-5);
        }
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
    let walled = [pack_moments(Vec2::new(0.5, 0.25)); TEXELS];
    let walled = of(&walled);
    for d in [Vec3::Z, Vec3::X, Vec3::new(0.6, 0.0, 0.8)] {
        for far in [0.001, 0.3, 0.999] {
            let at = d * far;
            let seen = visibility(OPEN, &pose, at);
            assert_eq!(seen, openness(OPEN, &pose, at), "{at}");
            assert_eq!(seen, 1.0, "{at}");
            let seen = visibility(walled, &pose, at);
            assert_eq!(seen, openness(walled, &pose, at), "{at}");
            assert_eq!(seen, if far < 0.5 { 1.0 } else { 0.0 }, "{at}");
        }
        for far in [1.2, 3.0, 1e6] {
            let at = d * far;
            assert_eq!(visibility(OPEN, &pose, at), 0.0, "{at}");
            assert_eq!(openness(OPEN, &pose, at), 1.0, "{at}");
            assert_eq!(openness(walled, &pose, at), 0.0, "{at}");
        }
    }
}

/// In the middle of a texel, a lookup finds that texel alone; each surfel has its own.
#[test]
fn every_texel_is_found_where_its_rays_go() {
    for side in 2..=8 {
        let each = count(side);
        let texels: Vec<u32> = (0..3 * each as u32).map(|i| i * 100).collect();
        let depths = Depths::new(&texels, side);
        for surfel in 0..3 {
            for texel in 0..each as u32 {
                let at = Vec2::new((texel % side) as f32, (texel / side) as f32) + 0.5;
                let direction = hemisphere_decode(at / side as f32);
                let uv = hemisphere_encode(direction);
                assert_eq!(index(uv.y, side) * side + index(uv.x, side), texel);
                let found = depth_moments(depths.get(surfel).expect("there"), direction).x;
                let expected = moments(texels[surfel * each + texel as usize]).x;
                assert!(
                    (found - expected).abs() < 1e-3,
                    "side {side}, texel {texel}"
                );
            }
        }
        assert!(depths.get(3).is_none() && Depths::new(&[], side).get(0).is_none());
    }
}

/// What no ray has reached is far as surfaces go, however close it is guessed to be; what one has reached counts, though it has no
/// second moment to speak of, and stays what it is when the surfel grows.
#[test]
fn guesses_are_no_walls() {
    let near = pack_moments(Vec2::new(0.002, 0.0).max(KNOWN));
    assert!(is_known(near) && is_crowded([near; 16].into_iter()));
    assert!(!is_known(guess(5)) && !is_crowded([guess(5); 16].into_iter()));
    assert!(!is_crowded([UNKNOWN; 16].into_iter()));
    assert_eq!(guess(RADIUS_STEPS), UNKNOWN);
    for shrinks in [0.01, 0.5, 1.0, 3.0] {
        assert!(is_known(rescaled(near, shrinks)), "{shrinks}");
        assert!(!is_known(rescaled(guess(5), shrinks)), "{shrinks}");
    }
}
