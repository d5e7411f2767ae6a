//! Light from 2^-40 to 2^40 of what is usual: a moonless night and the inside of a star. tests/furnace.rs holds the box under sun,
//! sky and a point light from 2^-20 to 2^20; here is what lies farther out, its lamp, punctual lights, sun and sky apart and together.
use super::build::room;
use super::common::all_backends;
use super::measure::{bits, draw, settings};
use super::pictures;
use gibs::passes::frame::Settings;
use gibs::passes::scene::{Environment, LightKind, Scene, Sun};
use gibs::view::View;
use glam::{DVec3, Vec3};

/// The room under its lamp, under a point, a spot and a directional light, under sun and sky, or under all, times `scale`. An eighth of the usual light, because 2^40 of a lamp's 18
/// W/(m^2 sr) is above what a material may have, 1e13.
fn lit(kind: &str, scale: f32) -> (Scene, View) {
    let (mut scene, mut view) = room();
    let scale = scale / 8.0;
    let has = |name: &str| kind == name || kind == "all";
    for material in &mut scene.materials {
        material.emission *= if has("lamp") { scale } else { 0.0 };
    }
    let intensity = scene.lights[0].intensity * scale;
    let node = scene.lights[0].node;
    scene.lights.clear();
    let mut add = |kind| {
        scene.lights.push(gibs::passes::scene::Light {
            node,
            kind,
            intensity,
        });
    };
    if has("punctual") {
        let (inner, outer) = (0.3, 0.9);
        add(LightKind::Point);
        add(LightKind::Spot { inner, outer });
        add(LightKind::Directional);
    }
    if has("outside") {
        view.sun = Some(Sun {
            direction: DVec3::new(0.2, -0.4, 1.0),
            irradiance: Vec3::new(4.0, 3.0, 2.0) * scale,
        });
    }
    if has("outside") {
        view.environment = Environment::Constant(Vec3::new(0.2, 0.3, 0.5) * scale);
    }
    (scene, view)
}

/// A product with 2^k is exact while it is a normal number. Irradiance is between 2^-24 and 2^4 here, so that with k = -40 its
/// square, the smallest number that estimators keep, stays above 2^-128 and with k = 40 its square times a million rays below
/// 2^128. The bound is equality of all bits.
#[test]
fn light_scales_exactly_from_2_to_the_minus_40_to_2_to_the_40() {
    let guided = Settings {
        guiding: true,
        clamp: true,
        ..settings()
    };
    for backend in all_backends() {
        let name = backend.name();
        for (kind, settings) in [
            ("lamp", settings()),
            ("punctual", settings()),
            ("all", guided.clone()),
        ] {
            let at = |scale: f32| {
                draw(
                    backend.as_ref(),
                    &lit(kind, scale),
                    [48, 27],
                    8,
                    &settings,
                    1,
                )
            };
            let one = at(1.0);
            for power in [-40, 40] {
                let scale = 2f32.powi(power);
                let many = at(scale);
                for layer in ["E", "direct"] {
                    let scaled = one.rgb(layer).expect("the layer").concat();
                    let scaled: Vec<u32> = scaled.iter().map(|x| (x * scale).to_bits()).collect();
                    let other = bits(&many, layer);
                    let differ = scaled.iter().zip(&other).filter(|(a, b)| a != b).count();
                    assert_eq!(differ, 0, "{name}: {kind} at 2^{power}: values of {layer}");
                }
            }
            println!("{name}: {kind} times 2^-40 and 2^40: every bit as at 2^0");
            pictures::irradiance(&format!("light-powers-{kind}"), name, &one);
        }
    }
}
