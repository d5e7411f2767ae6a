//! Closed white boxes: albedo a and emission e give radiance e / (1 - a) everywhere, and irradiance pi times that.
mod common;
#[path = "common/wall.rs"]
#[allow(dead_code, reason = "others look at more of it")]
mod wall;

use common::{all_backends, cpu, mean, render, settings};
use gibs::builtin;
use gibs::passes::frame::Settings;
use gibs::passes::scene::{Environment, Light, LightKind, LocalTransform, Node, Scene, Sun};
use gibs::reference::{ReferenceOptions, reference};
use gibs::view::View;
use glam::{DAffine3, DVec3, Vec3};

const ALBEDOS: [f32; 3] = [0.2, 0.5, 0.8];

/// Of 64 x 64 pixels with 64 samples, the mean's standard error is below 0.2 % at albedo 0.8.
#[test]
fn the_reference_has_the_closed_form_within_one_percent() {
    for backend in all_backends() {
        for albedo in ALBEDOS {
            let (scene, view) = builtin::furnace(albedo, 1.0);
            let options = ReferenceOptions {
                size: [64, 64],
                samples: 64,
                seed: 1,
                emitters: true,
            };
            let (picture, _) =
                reference(backend.as_ref(), &scene, &view, &options, |_, _| {}).expect("renders");
            let radiance = mean(&picture, "");
            let want = 1.0 / (1.0 - f64::from(albedo));
            println!(
                "{}: albedo {albedo}: reference {radiance:.4}, closed form {want:.4}",
                backend.name()
            );
            assert!(
                (radiance / want - 1.0).abs() < 0.01,
                "{}: albedo {albedo}: {radiance}",
                backend.name()
            );
        }
    }
}

#[test]
fn surfels_have_the_closed_form_within_three_percent() {
    for backend in all_backends() {
        for albedo in ALBEDOS {
            let picture = render(
                backend.as_ref(),
                &builtin::furnace(albedo, 1.0),
                [64, 64],
                96,
                &settings(10_000),
                1,
            );
            let radiance = mean(&picture, "");
            let want = 1.0 / (1.0 - f64::from(albedo));
            println!(
                "{}: albedo {albedo}: surfels {radiance:.4}, closed form {want:.4}",
                backend.name()
            );
            assert!(
                (radiance / want - 1.0).abs() < 0.03,
                "{}: albedo {albedo}: {radiance}",
                backend.name()
            );
        }
    }
}

/// Paths that end at once, where no surfel is, take the light of the surfel that they began at: in a room that looks alike
/// everywhere, nothing is missing.
#[test]
fn paths_that_end_have_the_closed_form_too() {
    let albedo = 0.5;
    let settings = Settings {
        continuations: 0,
        ..settings(10_000)
    };
    let scene = builtin::furnace(albedo, 1.0);
    let radiance = mean(
        &render(cpu().as_ref(), &scene, [64, 64], 96, &settings, 1),
        "",
    );
    let want = 1.0 / (1.0 - f64::from(albedo));
    println!("albedo {albedo}: surfels {radiance:.4}, closed form {want:.4}");
    assert!((radiance / want - 1.0).abs() < 0.03, "{radiance}");
    let settings = Settings {
        fallback: false,
        ..settings
    };
    let without = mean(
        &render(cpu().as_ref(), &scene, [64, 64], 96, &settings, 1),
        "",
    );
    println!("without the fallback {without:.4}");
    assert!(without < 0.9 * want, "{without}: nothing would show");
}

/// The Cornell box, open to a sky, under a sun and with a point light in it; all light times `scale`.
fn lit(scale: f32) -> (Scene, View) {
    let (mut scene, mut view) = builtin::by_name("cornell").expect("built in");
    for material in &mut scene.materials {
        material.emission *= scale;
    }
    let node = scene.nodes.len() as u32;
    scene.nodes.push(Node {
        local: LocalTransform::Affine(DAffine3::from_translation(DVec3::new(2.8, 3.0, 1.0))),
        ..Node::default()
    });
    scene.lights.push(Light {
        node,
        kind: LightKind::Point,
        intensity: Vec3::new(3.0, 2.0, 1.0) * scale,
    });
    view.sun = Some(Sun {
        direction: DVec3::new(0.2, -0.4, 1.0),
        irradiance: Vec3::new(4.0, 3.0, 2.0) * scale,
    });
    view.environment = Environment::Constant(Vec3::new(0.2, 0.3, 0.5) * scale);
    (scene, view)
}

/// Multiplying every light by a power of two multiplies the result by exactly that: guided or not, and where surfels are wide,
/// so that some have hardly any weight, and dim ones lie beside bright ones.
#[test]
fn light_scales_exactly() {
    let guided = Settings {
        guiding: true,
        ..settings(2_000)
    };
    let wide = Settings {
        radius: 8.0,
        clamp: true,
        ..settings(5_000)
    };
    for backend in all_backends() {
        for (settings, side, frames) in [
            (&settings(2_000), 32, 12),
            (&guided, 32, 12),
            (&wide, 48, 24),
        ] {
            let at = |scale: f32| {
                let picture = render(
                    backend.as_ref(),
                    &lit(scale),
                    [side; 2],
                    frames,
                    settings,
                    1,
                );
                picture.rgb("E").expect("E").concat()
            };
            let one = at(1.0);
            assert!(one.iter().any(|e| *e > 0.1));
            for power in [-20, -1, 20] {
                let scale = 2f32.powi(power);
                let many = at(scale);
                let differ = one.iter().zip(&many).filter(|(a, b)| *a * scale != **b);
                let name = backend.name();
                assert_eq!(differ.count(), 0, "{name}: 2^{power}, {settings:?}");
            }
        }
    }
}

/// As above, in the box without sun and sky, where most of what a surfel sees at first is black.
#[test]
fn a_lamp_scales_exactly() {
    let lamp = |scale: f32| {
        let (mut scene, view) = builtin::by_name("cornell").expect("built in");
        for material in &mut scene.materials {
            material.emission *= scale;
        }
        (scene, view)
    };
    let backend = cpu();
    for (radius, surfels) in [(0.0, 1000), (4.0, 8192), (8.0, 8192)] {
        let settings = Settings {
            radius,
            surfels,
            ..settings(5_000)
        };
        let at = |scale: f32| {
            let picture = render(backend.as_ref(), &lamp(scale), [48, 48], 24, &settings, 0);
            picture.rgb("E").expect("E").concat()
        };
        let one = at(1.0);
        for power in [-20, -10, -1, 10] {
            let scale = 2f32.powi(power);
            let many = at(scale);
            let differ = one.iter().zip(&many).filter(|(a, b)| *a * scale != **b);
            assert_eq!(
                differ.count(),
                0,
                "2^{power}, radius {radius}, {surfels} surfels"
            );
        }
    }
}

/// As above, where a wall keeps all light out but what leaks, which gets fainter from surfel to surfel.
#[test]
fn what_leaks_scales_exactly() {
    for backend in all_backends() {
        let at = |scale: f32| {
            let scene = wall::wall_from_above(scale);
            let picture = render(
                backend.as_ref(),
                &scene,
                [121, 67],
                14,
                &settings(25_000),
                0,
            );
            picture.rgb("E").expect("E").concat()
        };
        let one = at(1.0);
        for power in [-20, -3, -1, 10] {
            let scale = 2f32.powi(power);
            let many = at(scale);
            let differ = one.iter().zip(&many).filter(|(a, b)| *a * scale != **b);
            let name = backend.name();
            assert_eq!(differ.count(), 0, "{name}: 2^{power}");
        }
    }
}
