//! Two boxes that a clip moves through the Cornell box.
use super::cornell;
use super::shapes::bevelled;
use crate::view::View;
use gibs_passes::scene::{Animation, Channel, Interpolation, Keyframes, NodeId, Scene};
use glam::{DQuat, DVec3, Vec3};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Length of the clip in seconds; it ends as it begins.
const PERIOD: f32 = 4.0;

/// The Cornell box with one box that turns while it rises and sinks, and one that goes round in a circle. The view shows
/// the first moment of clip 0.
pub(super) fn moving() -> (Scene, View) {
    let (mut a, white) = cornell::walls("moving");
    let blue = a.paint("blue", [0.12, 0.22, 0.60]);
    let tall = a.mesh(
        "tall box",
        white,
        &bevelled(Vec3::new(-0.7, -1.4, -0.7), Vec3::new(0.7, 1.4, 0.7), 0.03),
    );
    let small = a.mesh(
        "small box",
        blue,
        &bevelled(Vec3::splat(-0.5), Vec3::splat(0.5), 0.03),
    );
    let tall = a.place("tall box", &[tall], [3.6, 1.9, 3.6], 0.0);
    let small = a.place("small box", &[small], [2.1, 0.8, 1.9], 0.0);

    let channel = |node: NodeId, steps: u16, keyframes: fn(f64) -> (DVec3, DQuat), turn: bool| {
        let phases = (0..=steps).map(|i| f64::from(i) / f64::from(steps));
        let values: Vec<(DVec3, DQuat)> = phases.clone().map(keyframes).collect();
        Channel {
            node,
            times: phases.map(|phase| phase as f32 * PERIOD).collect(),
            keyframes: match turn {
                true => Keyframes::Rotation(values.iter().map(|v| v.1).collect()),
                false => Keyframes::Translation(values.iter().map(|v| v.0).collect()),
            },
            interpolation: Interpolation::Linear,
        }
    };
    // Quarter turns, as a rotation between two keyframes takes the shorter way.
    let tall_path = |phase: f64| {
        let height = 1.9 + 0.4 * (phase * TAU).sin();
        (
            DVec3::new(3.6, height, 3.6),
            DQuat::from_rotation_y(phase * TAU + FRAC_PI_2 / 6.0),
        )
    };
    let small_path = |phase: f64| {
        let (sin, cos) = (phase * TAU).sin_cos();
        (
            DVec3::new(1.6 + 0.7 * cos, 0.8, 1.7 + 0.7 * sin),
            DQuat::IDENTITY,
        )
    };
    a.scene.animations.push(Animation {
        name: "round and round".to_owned(),
        channels: vec![
            channel(tall, 16, tall_path, false),
            channel(tall, 16, tall_path, true),
            channel(small, 32, small_path, false),
        ],
    });
    let mut view = cornell::camera();
    view.animation = vec![(0, 0.0)];
    (a.scene, view)
}
