//! Light from 2^-40 to 2^40 of what is usual: a moonless night and the inside of a star. tests/furnace.rs holds the box under
//! sun, sky and a point light from 2^-20 to 2^20; here is what lies farther out, punctual lights alone, and all lights with
//! every part of the technique that weighs them.
use super::build::room;
use super::common::all_backends;
use super::measure::{bits, draw, settings};
use super::pictures;
use gibs::passes::frame::Settings;
use gibs::passes::scene::{Environment, LightKind, Scene, Sun};
use gibs::view::View;
use glam::{DVec3, Vec3};

/// The room under a point, a spot and a directional light, with `all` also under its lamp, sun and sky; times `scale`. An
/// eighth of the usual light, because 2^40 of a lamp's 18 W/(m^2 sr) is above what a material may have, 1e13.
fn lit(all: bool, scale: f32) -> (Scene, View) {
    let (mut scene, mut view) = room();
    let scale = scale / 8.0;
    for material in &mut scene.materials {
        material.emission *= if all { scale } else { 0.0 };
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
    let (inner, outer) = (0.3, 0.9);
    add(LightKind::Point);
    add(LightKind::Spot { inner, outer });
    add(LightKind::Directional);
    if all {
        view.sun = Some(Sun {
            direction: DVec3::new(0.2, -0.4, 1.0),
            irradiance: Vec3::new(4.0, 3.0, 2.0) * scale,
        });
        view.environment = Environment::Constant(Vec3::new(0.2, 0.3, 0.5) * scale);
    }
    (scene, view)
}

/// A product with 2^k is exact while it is a normal number, 2^-126 to 2^128. Irradiance that is not zero lies between 2^-23 and
/// 2^4 here, which the test holds; with k = -40 its square, the smallest number that estimators keep, is at least 2^-126, and
/// with k = 40 its square times a million rays below 2^128. The bound is equality of all bits.
#[test]
fn light_scales_exactly_from_2_to_the_minus_40_to_2_to_the_40() {
    let guided = Settings {
        guiding: true,
        clamp: true,
        ..settings()
    };
    for backend in all_backends() {
        let name = backend.name();
        for (kind, all, settings) in [
            ("punctual", false, settings()),
            ("all", true, guided.clone()),
        ] {
            let at = |scale: f32| {
                draw(
                    backend.as_ref(),
                    &lit(all, scale),
                    [48, 27],
                    8,
                    &settings,
                    1,
                )
            };
            let one = at(1.0);
            let lit = one.rgb("E").expect("E").concat();
            let range = 2f32.powi(-23)..2f32.powi(4);
            assert!(
                lit.iter().all(|e| *e == 0.0 || range.contains(e)),
                "{name}: {kind}"
            );
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
