//! A scene and its camera a thousand kilometres from the world's origin. In `f32`, places there are 6 cm apart.
use super::build::{move_by, room};
use super::common::all_backends;
use super::measure::{
    FRAMES, Noise, SIZE, assert_same_direct, assert_same_light, bits, draw, relative, settings,
};
use super::{measure, pictures};
use gibs::passes::scene::Scene;
use gibs::view::View;
use glam::DVec3;

fn at(offset: DVec3) -> (Scene, View) {
    let (mut scene, mut view) = room();
    move_by(&mut scene, offset);
    view.camera.position += offset;
    view.camera.target += offset;
    (scene, view)
}

/// 1e6 m is 62 500 steps of the floating origin's lattice of 16 m, and every translation of the room is a short binary number:
/// in `f64` each sum with 1e6 is exact, so that all numbers relative to the floating origin are those at the world's origin.
/// The bound is equality of all bits.
#[test]
fn on_the_lattice_no_bit_changes() {
    for backend in all_backends() {
        let name = backend.name();
        let drawn = |offset| draw(backend.as_ref(), &at(offset), SIZE, FRAMES, &settings(), 0);
        let here = measure::room(backend.as_ref());
        let there = drawn(DVec3::new(1e6, -1e6, 1e6));
        for layer in ["E", "direct"] {
            assert!(bits(&here, layer) == bits(&there, layer), "{name}: {layer}");
        }
        println!("{name}: 1e6 m on the lattice: every bit of E and direct light is the same");
    }
}

/// Between the lattice's points the floating origin lies up to 8 m beside the eye, and coordinates have other roundings.
///
/// Direct light is held to what roundings of numbers below 32 m leave, as [`assert_same_direct`] derives.
///
/// Indirect light: other roundings decide otherwise about a birth here and there, and what follows is another draw. The bound
/// is that of two draws, [`Noise`].
#[test]
fn off_the_lattice_what_f32_leaves_is_left() {
    let noise = Noise::of_room();
    for backend in all_backends() {
        let name = backend.name();
        let drawn = |offset| draw(backend.as_ref(), &at(offset), SIZE, FRAMES, &settings(), 0);
        let here = measure::room(backend.as_ref());
        let there = drawn(DVec3::new(1e6 + 5.3, -1e6 - 7.1, 1e6 + 3.7));
        let what = format!("{name}: 1e6 m off the lattice");
        assert_same_direct(&here, &there, 32.0, 0.0, &what);
        assert_same_light(&here, &there, &noise, &what);
        pictures::errors("far-away", name, &here, &relative(&here, &there), 0.5);
    }
}
