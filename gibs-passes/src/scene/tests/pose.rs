use super::node;
use crate::scene::{Animation, Channel, Interpolation, Keyframes, LocalTransform, Sample, Scene};
use glam::{DAffine3, DQuat, DVec3};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// A few roundings of numbers near one.
const ROUNDING: f64 = 1e-14;

fn channel(times: &[f32], keyframes: Keyframes, interpolation: Interpolation) -> Channel {
    Channel {
        node: 0,
        times: times.to_vec(),
        keyframes,
        interpolation,
    }
}

fn translation(channel: &Channel, time: f64) -> DVec3 {
    match channel.sample(time) {
        Some(Sample::Translation(v)) => v,
        other => panic!("{other:?}"),
    }
}

fn rotation(channel: &Channel, time: f64) -> DQuat {
    match channel.sample(time) {
        Some(Sample::Rotation(q)) => q,
        other => panic!("{other:?}"),
    }
}

fn same_rotation(a: DQuat, b: DQuat) -> bool {
    (a.dot(b).abs() - 1.0).abs() < ROUNDING
}

#[test]
fn linear_holds_its_ends_and_meets_its_keyframes() {
    let values = vec![DVec3::X, DVec3::Y, DVec3::ZERO];
    let c = channel(
        &[1.0, 2.0, 4.0],
        Keyframes::Translation(values),
        Interpolation::Linear,
    );
    for (time, expected) in [
        (f64::NEG_INFINITY, DVec3::X),
        (f64::NAN, DVec3::X),
        (0.0, DVec3::X),
        (1.0, DVec3::X),
        (1.25, DVec3::new(0.75, 0.25, 0.0)),
        (2.0, DVec3::Y),
        (3.0, DVec3::Y * 0.5),
        (4.0, DVec3::ZERO),
        (f64::INFINITY, DVec3::ZERO),
    ] {
        assert_eq!(translation(&c, time), expected, "at {time}");
    }
}

#[test]
fn step_holds_until_the_next_keyframe() {
    let c = channel(
        &[0.0, 1.0],
        Keyframes::Translation(vec![DVec3::X, DVec3::Y]),
        Interpolation::Step,
    );
    assert_eq!(translation(&c, 0.999), DVec3::X);
    assert_eq!(translation(&c, 1.0), DVec3::Y);
}

#[test]
fn equal_times_jump_to_the_later_value() {
    let values = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Y];
    let c = channel(
        &[0.0, 1.0, 1.0, 2.0],
        Keyframes::Translation(values),
        Interpolation::Linear,
    );
    assert_eq!(translation(&c, 0.5), DVec3::X * 0.5);
    assert_eq!(translation(&c, 1.0), DVec3::Y);
}

#[test]
fn rotations_turn_evenly_along_the_shorter_arc() {
    let half = DQuat::from_rotation_y(FRAC_PI_2);
    for end in [half, -half] {
        let c = channel(
            &[0.0, 2.0],
            Keyframes::Rotation(vec![DQuat::IDENTITY, end]),
            Interpolation::Linear,
        );
        for eighth in 0..=8 {
            let s = f64::from(eighth) / 8.0;
            let expected = DQuat::from_rotation_y(FRAC_PI_2 * s);
            assert!(
                same_rotation(rotation(&c, 2.0 * s), expected),
                "at {s}, end {end}"
            );
        }
    }
}

#[test]
fn nearly_equal_and_opposite_rotations_stay_unit() {
    let tiny = DQuat::from_rotation_x(1e-9);
    let turned = DQuat::from_rotation_x(PI);
    for end in [
        DQuat::IDENTITY,
        tiny,
        turned,
        DQuat::from_rotation_x(PI - 1e-9),
    ] {
        let c = channel(
            &[0.0, 1.0],
            Keyframes::Rotation(vec![DQuat::IDENTITY, end]),
            Interpolation::Linear,
        );
        let middle = rotation(&c, 0.5);
        assert!((middle.length() - 1.0).abs() < ROUNDING, "{middle}");
    }
    let c = channel(
        &[0.0, 1.0],
        Keyframes::Rotation(vec![DQuat::IDENTITY, tiny]),
        Interpolation::Linear,
    );
    assert!((rotation(&c, 0.5).x - 0.25e-9).abs() < 1e-23);
}

/// A Hermite spline reproduces every cubic whose values and derivatives it is given.
#[test]
fn cubic_splines_reproduce_a_cubic() {
    let f = |t: f64| DVec3::new(t * t * t, t * t - t, 2.0 - t);
    let derivative = |t: f64| DVec3::new(3.0 * t * t, 2.0 * t - 1.0, -1.0);
    let times = [0.5f32, 1.0, 3.0];
    let values = times
        .iter()
        .flat_map(|&t| [derivative(t.into()), f(t.into()), derivative(t.into())])
        .collect();
    let c = channel(
        &times,
        Keyframes::Translation(values),
        Interpolation::CubicSpline,
    );
    for step in 0..=20 {
        let t = 0.5 + 2.5 * f64::from(step) / 20.0;
        // Values reach 27, hence the wider tolerance.
        assert!((translation(&c, t) - f(t)).length() < 1e-13, "at {t}");
    }
    assert_eq!(translation(&c, 9.0), f(3.0));
}

/// With flat tangents the spline passes through the smooth step, made unit.
#[test]
fn cubic_spline_rotations_are_unit() {
    let (a, b, none) = (
        DQuat::IDENTITY,
        DQuat::from_rotation_z(FRAC_PI_2),
        DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0),
    );
    let values = vec![none, a, none, none, b, none];
    let c = channel(
        &[0.0, 1.0],
        Keyframes::Rotation(values),
        Interpolation::CubicSpline,
    );
    assert!(same_rotation(
        rotation(&c, 0.5),
        DQuat::from_rotation_z(FRAC_PI_4)
    ));
    let quarter = rotation(&c, 0.25);
    let weight = 3.0 / 16.0 - 2.0 / 64.0;
    let expected = (a * (1.0 - weight) + b * weight).normalize();
    assert!(same_rotation(quarter, expected));
}

#[test]
fn a_channel_without_enough_values_has_no_sample() {
    let empty = channel(&[], Keyframes::Scale(Vec::new()), Interpolation::Linear);
    assert_eq!(empty.sample(0.0), None);
    let short = channel(
        &[0.0, 1.0],
        Keyframes::Scale(vec![DVec3::ONE]),
        Interpolation::CubicSpline,
    );
    assert_eq!(short.sample(0.5), None);
}

#[test]
fn hierarchies_multiply_from_the_root() {
    let mut scene = Scene::default();
    let mut root = node(None, DVec3::X);
    root.local = LocalTransform::Parts {
        translation: DVec3::X,
        rotation: DQuat::from_rotation_z(FRAC_PI_2),
        scale: DVec3::new(2.0, -1.0, 1.0),
    };
    let child = DAffine3::from_translation(DVec3::new(1.0, 1.0, 0.0));
    let mut second = node(Some(0), DVec3::ZERO);
    second.local = LocalTransform::Affine(child);
    scene.nodes = vec![root, second, node(None, DVec3::Z)];
    let pose = scene.pose(&[]);
    // (1, 1) scaled to (2, -1), turned to (1, 2), moved to (2, 2).
    let origin = pose.world[1].translation;
    assert!(
        (origin - DVec3::new(2.0, 2.0, 0.0)).length() < ROUNDING,
        "{origin}"
    );
    assert!(pose.world[1].matrix3.determinant() < 0.0);
    assert_eq!(pose.world[2].translation, DVec3::Z);
}

#[test]
fn clips_apply_in_order_and_only_to_their_property() {
    let mut scene = Scene {
        nodes: vec![node(None, DVec3::ZERO), node(Some(0), DVec3::Z)],
        ..Scene::default()
    };
    let clip = |values: Vec<DVec3>| Animation {
        name: String::new(),
        channels: vec![channel(
            &[0.0, 1.0],
            Keyframes::Translation(values),
            Interpolation::Linear,
        )],
    };
    scene.animations = vec![
        clip(vec![DVec3::ZERO, DVec3::X]),
        clip(vec![DVec3::Y, DVec3::Y]),
    ];
    let at = |clips: &[(usize, f64)]| scene.pose(clips).world[1].translation;
    assert_eq!(at(&[]), DVec3::Z);
    assert_eq!(at(&[(0, 0.25), (9, 1.0)]), DVec3::new(0.25, 0.0, 1.0));
    assert_eq!(at(&[(0, 0.25), (1, 0.0)]), DVec3::new(0.0, 1.0, 1.0));
    assert_eq!(at(&[(1, 0.0), (0, 0.25)]), DVec3::new(0.25, 0.0, 1.0));
}

#[test]
fn a_clip_keeps_the_other_parts_of_a_fixed_map() {
    let fixed = DAffine3::from_scale_rotation_translation(
        DVec3::new(1.0, 2.0, 3.0),
        DQuat::from_rotation_x(0.3),
        DVec3::Y,
    );
    let mut moved = node(None, DVec3::ZERO);
    moved.local = LocalTransform::Affine(fixed);
    let mut flat = node(None, DVec3::ZERO);
    flat.local = LocalTransform::Affine(DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0)));
    let mut channels = vec![
        channel(
            &[0.0],
            Keyframes::Translation(vec![DVec3::X]),
            Interpolation::Step
        );
        2
    ];
    channels[1].node = 1;
    let scene = Scene {
        nodes: vec![moved, flat],
        animations: vec![Animation {
            name: String::new(),
            channels,
        }],
        ..Scene::default()
    };
    let pose = scene.pose(&[(0, 0.0)]);
    assert_eq!(pose.world[0].translation, DVec3::X);
    assert!(pose.world[0].matrix3.abs_diff_eq(fixed.matrix3, ROUNDING));
    assert!(pose.world[1].is_finite());
    assert_eq!(pose.world[1].matrix3.y_axis, DVec3::ZERO);
}
