//! Triangles that lie in each other, and triangles a million times as long as wide.
use super::build::room;
use super::common::all_backends;
use super::measure::{
    FRAMES, Noise, SIZE, assert_same_light, bits, draw, levels, mean, relative, settings,
};
use super::{measure, pictures};
use gibs::builtin;
use gibs::passes::frame::Settings;
use gibs::passes::scene::Scene;
use gibs::view::View;
use std::f64::consts::PI;

/// The room with every triangle that `chosen` chooses by its material's emission there twice, as the same corners in another
/// order.
fn doubled(chosen: impl Fn(bool) -> bool) -> (Scene, View) {
    let (mut scene, view) = room();
    for mesh in &mut scene.meshes {
        let shines = scene.materials[mesh.material as usize].emission.x > 0.0;
        if chosen(shines) {
            let twins: Vec<[u32; 3]> = mesh.triangles.iter().map(|&[a, b, c]| [b, c, a]).collect();
            mesh.triangles.extend(twins);
        }
    }
    (scene, view)
}

/// Of two triangles at one distance the first is hit, and it says the same. Which of the two is found at equal distances may
/// depend on rounding: the twins' corners come in another order, so that their distances differ by roundings. The light is that
/// of the single triangles but for chance, [`Noise`].
#[test]
fn walls_that_are_there_twice_are_walls() {
    let noise = Noise::of_room();
    for backend in all_backends() {
        let name = backend.name();
        let one = measure::room(backend.as_ref());
        let two = draw(
            backend.as_ref(),
            &doubled(|shines| !shines),
            SIZE,
            FRAMES,
            &settings(),
            0,
        );
        assert_same_light(&one, &two, &noise, &format!("{name}: walls twice"));
        pictures::errors("walls-twice", name, &one, &relative(&one, &two), 0.5);
    }
}

/// A lamp that is there twice still shines once: a ray finds one of the two. Sampling by power must not take it for twice the
/// power, or points of it would be drawn twice as often as their weight says, and E come out up to twice too bright.
#[test]
fn lamps_that_are_there_twice_shine_once() {
    let noise = Noise::of_room();
    for backend in all_backends() {
        let name = backend.name();
        let one = measure::room(backend.as_ref());
        let two = draw(
            backend.as_ref(),
            &doubled(|shines| shines),
            SIZE,
            FRAMES,
            &settings(),
            0,
        );
        assert_same_light(&one, &two, &noise, &format!("{name}: lamp twice"));
        pictures::errors("lamp-twice", name, &one, &relative(&one, &two), 0.5);
    }
}

/// The furnace, each triangle cut in three by two points of an edge that are 2e-6 of it apart: the middle one is a sliver of
/// aspect 1e6 from there to the opposite corner. All points are in the planes of the walls.
fn slivered(albedo: f32) -> (Scene, View) {
    let (mut scene, view) = builtin::furnace(albedo, 1.0);
    let mesh = &mut scene.meshes[0];
    mesh.normals.clear();
    mesh.uvs.clear();
    let whole = std::mem::take(&mut mesh.triangles);
    for [a, b, c] in whole {
        let [from, to] = [a, b].map(|v| mesh.positions[v as usize]);
        let first = mesh.positions.len() as u32;
        for t in [0.3f32, 0.300_001] {
            mesh.positions.push(from + (to - from) * t);
        }
        let (p, q) = (first, first + 1);
        mesh.triangles.extend([[a, p, c], [p, q, c], [q, b, c]]);
    }
    (scene, view)
}

/// What is lost between triangles: an edge is found by products of vectors of up to 3.5 m in some 12 roundings, so that it is
/// uncertain by `12 U * 3.5 m`; the room of 24 m^2 has some 100 m of them, half of which may gape, which lets a share of
/// `100 * 12 U * 3.5 / 24 = 1e-5` of rays out. Of the 1.3e5 rays of 32 frames that is 1.3, and with five standard deviations of
/// their number 7. At albedo 0, E is `pi e` but for those: a mean within `7 / 1.3e5 = 5.4e-5`.
///
/// At albedo 0.5, E is that of whole walls but for chance. With emitters sampled, slivers are drawn by their power.
#[test]
fn slivers_have_the_light_of_whole_walls() {
    let settings = |emitters| Settings {
        emitters,
        ..settings()
    };
    for backend in all_backends() {
        let name = backend.name();
        let black = draw(
            backend.as_ref(),
            &slivered(0.0),
            SIZE,
            FRAMES,
            &settings(false),
            0,
        );
        let off: Vec<f64> = levels(&black, "E").iter().map(|e| e / PI - 1.0).collect();
        let worst = off.iter().fold(0f64, |a, &b| a.max(b.abs()));
        println!(
            "{name}: slivers of aspect 1e6, albedo 0: mean of E {:+.2e} (bound 5.4e-5), pixels at most {worst:.2e}",
            mean(&off)
        );
        assert!(mean(&off).abs() <= 5.4e-5, "{name}: {}", mean(&off));
        pictures::errors("slivers", name, &black, &off, 1e-3);
    }
    let whole = builtin::furnace(0.5, 1.0);
    let noise = Noise::of(&whole, SIZE, FRAMES, &settings(true));
    for backend in all_backends() {
        let name = backend.name();
        let one = draw(backend.as_ref(), &whole, SIZE, FRAMES, &settings(true), 0);
        let cut = draw(
            backend.as_ref(),
            &slivered(0.5),
            SIZE,
            FRAMES,
            &settings(true),
            0,
        );
        assert_same_light(&one, &cut, &noise, &format!("{name}: slivers, albedo 0.5"));
    }
}

/// With the same corners in the same order, twins have the same distances to the bit, and the first of the two is hit, always.
#[test]
fn exact_twins_change_no_bit_of_direct_light() {
    let (mut scene, view) = room();
    for mesh in &mut scene.meshes {
        let twins = mesh.triangles.clone();
        mesh.triangles.extend(twins);
    }
    let twice = (scene, view);
    for backend in all_backends() {
        let name = backend.name();
        let one = draw(backend.as_ref(), &room(), SIZE, 4, &settings(), 0);
        let two = draw(backend.as_ref(), &twice, SIZE, 4, &settings(), 0);
        for layer in ["direct", "albedo", "emission"] {
            assert!(bits(&one, layer) == bits(&two, layer), "{name}: {layer}");
        }
        println!("{name}: exact twins: every bit of direct light, albedo and emission is the same");
    }
}
