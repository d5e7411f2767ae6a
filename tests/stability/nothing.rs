//! Scenes in which there is nothing to see, or nothing to see by.
use super::build::{Build, room};
use super::common::all_backends;
use super::measure::{assert_finite, draw, go_on, settings};
use super::pictures;
use gibs::Renderer;
use gibs::passes::frame::Settings;
use gibs::passes::scene::{Environment, Light, Material, Mesh, Node};
use glam::Vec3;

/// A scene without anything, with a node that draws nothing, and with a mesh of no triangles shows the sky at every pixel,
/// exactly, has no surface, and says that there is nothing to draw.
#[test]
fn an_empty_scene_is_its_sky() {
    let empty = || Build::new("empty", [0.0; 3], [0.0, 0.0, -1.0], 1.0);
    let mut with_node = empty();
    with_node.scene.nodes.push(Node::default());
    let mut with_mesh = empty();
    with_mesh.scene.meshes.push(Mesh::default());
    with_mesh.scene.nodes.push(Node {
        meshes: vec![0],
        ..Node::default()
    });
    let sky = Vec3::new(0.25, 0.5, 2.0);
    for (what, mut build) in [
        ("nothing", empty()),
        ("a node", with_node),
        ("a mesh without triangles", with_mesh),
    ] {
        build.view.environment = Environment::Constant(sky);
        let (scene, view) = build.done();
        for backend in all_backends() {
            let name = backend.name();
            let mut renderer =
                Renderer::new(backend.as_ref(), &scene, &view, [16, 9], &settings(), 0)
                    .unwrap_or_else(|e| panic!("{name}: {what}: {e}"));
            let picture = go_on(&mut renderer, 4, name);
            let color = picture.rgb("").expect("the picture");
            for (plane, sky) in color.iter().zip(sky.to_array()) {
                assert!(plane.iter().all(|x| *x == sky), "{name}: {what}");
            }
            let mask = picture.scalar("mask.A").expect("a mask");
            assert!(mask.iter().all(|m| *m == 0.0), "{name}: {what}");
            let counters = renderer.counters().expect("reads");
            assert_eq!(counters.live, 0, "{name}: {what}");
            let warned = renderer
                .warnings()
                .iter()
                .any(|w| w.contains("no triangles"));
            assert!(warned, "{name}: {what}: {:?}", renderer.warnings());
            println!("{name}: {what}: the sky at every pixel, exactly");
        }
    }
}

/// Without light every term is a product with zero: E, direct light and the picture are exactly zero, with every part of the
/// technique on, whatever the albedo.
#[test]
fn without_light_it_is_black() {
    let settings = Settings {
        guiding: true,
        clamp: true,
        hit_births: 64,
        ..settings()
    };
    let (mut scene, view) = room();
    scene.lights.clear();
    for material in &mut scene.materials {
        material.emission = Vec3::ZERO;
        material.base_color = Vec3::ONE;
    }
    let scene = (scene, view);
    for backend in all_backends() {
        let name = backend.name();
        let picture = draw(backend.as_ref(), &scene, [48, 27], 16, &settings, 0);
        for layer in ["E", "direct", "indirect", ""] {
            let planes = picture.rgb(layer).expect("the layer");
            assert!(planes.concat().iter().all(|x| *x == 0.0), "{name}: {layer}");
        }
        println!("{name}: without light: E, direct light and the picture are exactly 0");
        pictures::irradiance("no-light", name, &picture);
    }
}

/// Lamps and emissive triangles of zero among others change no bit: nothing is drawn for them, whatever stands before and
/// behind them in the lists that light is drawn from. There are more lamps than are sampled at a point.
#[test]
fn lights_of_zero_among_others_change_nothing() {
    let (mut scene, view) = room();
    let lamp = scene.lights.first().cloned().expect("the room has a lamp");
    scene.lights = vec![lamp; 3];
    let mut with = scene.clone();
    let dark = Light {
        intensity: Vec3::ZERO,
        ..scene.lights[0].clone()
    };
    with.lights = vec![dark; 9];
    for (place, light) in [0, 4, 8].into_iter().zip(&scene.lights) {
        with.lights[place] = light.clone();
    }
    for backend in all_backends() {
        let name = backend.name();
        let [without, with] = [&scene, &with].map(|scene| {
            let scene = (scene.clone(), view.clone());
            draw(backend.as_ref(), &scene, [32, 18], 8, &settings(), 0)
        });
        for layer in ["E", "direct"] {
            let [a, b] = [&without, &with].map(|p| p.rgb(layer).expect("the layer").concat());
            assert!(a.iter().any(|x| *x > 0.0), "{name}: {layer}");
            assert_eq!(a, b, "{name}: {layer}");
        }
        println!("{name}: six lamps of zero among three others change no bit");
    }
}

/// Light of zero is no light, and a lamp of zero power is none: a warning says so, and the picture is finite and black.
#[test]
fn lights_of_zero_are_none() {
    let (mut scene, view) = room();
    scene
        .lights
        .iter_mut()
        .for_each(|l| l.intensity = Vec3::ZERO);
    scene.materials.iter_mut().for_each(|m| {
        *m = Material {
            emission: Vec3::ZERO,
            ..m.clone()
        }
    });
    for backend in all_backends() {
        let name = backend.name();
        let mut renderer = Renderer::new(backend.as_ref(), &scene, &view, [16, 9], &settings(), 0)
            .expect("prepares");
        let warned = renderer
            .warnings()
            .iter()
            .any(|w| w.contains("the picture is black"));
        assert!(warned, "{name}: {:?}", renderer.warnings());
        renderer.frame().expect("renders");
        let picture = renderer.picture().expect("a picture");
        assert_finite(&picture, name);
        let color = picture.rgb("").expect("the picture").concat();
        assert!(color.iter().all(|x| *x == 0.0), "{name}");
        println!("{name}: lights of zero: named and black");
    }
}
