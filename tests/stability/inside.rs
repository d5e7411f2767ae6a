//! A camera inside a solid, and pictures smaller than any tile.
use super::build::{Build, room};
use super::common::{all_backends, cpu};
use super::measure::{U, assert_finite, draw, go_on, levels, settings};
use super::pictures;
use gibs::passes::frame::Settings;
use gibs::passes::scene::{LightKind, Scene, Sun};
use gibs::reference::{ReferenceOptions, reference};
use gibs::view::View;
use gibs::{Renderer, builtin};
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

/// A solid box of 2 m on a lit floor, seen from its middle: surfaces have two sides.
fn boxed() -> (Scene, View) {
    let mut scene = Build::new("inside", [0.0, 1.0, 0.0], [1.0, 0.8, 0.3], 1.2);
    let grey = scene.paint(0.8, 0.0);
    scene.floor(grey, [0.0; 3], 10.0);
    scene.cuboid(
        grey,
        Vec3::new(-1.0, 0.0, -1.0),
        Vec3::new(1.0, 2.0, 1.0),
        false,
    );
    scene.light(LightKind::Point, [0.0, 3.0, 0.0], 1000.0);
    scene.view.sun = Some(Sun {
        direction: DVec3::new(0.3, -1.0, 0.2),
        irradiance: Vec3::splat(1000.0),
    });
    scene.done()
}

/// No light gets into a closed box, so that direct light and E are exactly zero inside, where surfels know nothing of the sides
/// that are lit: a surfel's normal faces who saw it.
#[test]
fn inside_a_solid_it_is_dark() {
    for backend in all_backends() {
        let name = backend.name();
        let picture = draw(backend.as_ref(), &boxed(), [48, 27], 24, &settings(), 0);
        for layer in ["E", "direct"] {
            let planes = picture.rgb(layer).expect("the layer").concat();
            assert!(planes.iter().all(|x| *x == 0.0), "{name}: {layer}");
        }
        println!("{name}: inside a solid: E and direct light are exactly 0");
        pictures::irradiance("inside", name, &picture);
    }
}

/// Surfels alone, of rays over the lobe: with albedo 0 each of them brings the light of the walls, exactly.
fn alone() -> Settings {
    Settings {
        emitters: false,
        rays: 1024,
        ..settings()
    }
}

/// An eye in the plane of a wall, on an edge and in a corner of the room: rays start where they hit, and which side of a surface
/// is seen is chance where the eye is in it; behind it is nothing. So at albedo 0 no pixel has more than E = `pi e`, within the
/// roundings of `white_walls`, and none less than 0. With bounces every value is finite and none below zero.
#[test]
fn eyes_on_surfaces_see_no_more_than_there_is() {
    const DRAWN: u32 = 8;
    let bound = 2.0 * (f64::from(DRAWN) + 1024.0) * U;
    for backend in all_backends() {
        let name = backend.name();
        for eye in [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0]] {
            let draw = |albedo, settings: &Settings| {
                let (scene, mut view) = builtin::furnace(albedo, 1.0);
                view.camera.position = DVec3::from(eye);
                view.camera.target = DVec3::ZERO;
                let scene = (scene, view);
                let picture = draw(backend.as_ref(), &scene, [37, 23], DRAWN, settings, 0);
                levels(&picture, "E")
            };
            let black = draw(0.0, &alone());
            let most = black.iter().fold(0f64, |most, e| most.max(e / PI - 1.0));
            println!("{name}: an eye at {eye:?}: E at most {most:.2e} above (bound {bound:.2e})");
            assert!(most <= bound, "{name}: {eye:?}: {most}");
            assert!(black.iter().all(|e| *e >= 0.0), "{name}: {eye:?}");
            let white = draw(0.5, &settings());
            assert!(white.iter().all(|e| *e >= 0.0), "{name}: {eye:?}");
        }
    }
}

const SIZES: [[u32; 2]; 5] = [[1, 1], [1, 7], [7, 1], [37, 23], [3, 129]];

/// At albedo 0 every pixel of a picture of any size has E = `pi e`, within the roundings of `white_walls`, also where a run
/// goes on from one size to the next. In the room all values are finite, and so are those of the reference.
#[test]
fn odd_sizes_have_every_pixel_right() {
    const DRAWN: u32 = 16;
    let (furnace, view) = builtin::furnace(0.0, 1.0);
    for backend in all_backends() {
        let name = backend.name();
        let mut renderer = Renderer::new(backend.as_ref(), &furnace, &view, [2, 2], &alone(), 0)
            .expect("prepares");
        for (size, frames) in SIZES.into_iter().zip((DRAWN..).step_by(DRAWN as usize)) {
            renderer.resize(size).expect("another size");
            let black = go_on(&mut renderer, DRAWN, name);
            let worst = levels(&black, "E")
                .into_iter()
                .fold(0f64, |w, e| w.max((e / PI - 1.0).abs()));
            let bound = 2.0 * (f64::from(frames) + 1024.0) * U;
            println!("{name}: {size:?}: E is off by {worst:.2e} (bound {bound:.2e})");
            assert!(worst <= bound, "{name}: {size:?}: {worst}");
        }
        for size in [[1, 1], [37, 23]] {
            draw(backend.as_ref(), &room(), size, 4, &settings(), 0);
        }
    }
    for size in SIZES {
        let options = ReferenceOptions {
            size,
            samples: 4,
            seed: 0,
            emitters: true,
        };
        let (scene, view) = room();
        let (picture, _) =
            reference(cpu().as_ref(), &scene, &view, &options, |_, _| {}).expect("renders");
        assert_finite(&picture, "the reference");
    }
}
