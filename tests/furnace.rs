//! Closed white boxes: albedo a and emission e give radiance e / (1 - a) everywhere, and irradiance pi times that.
mod common;

use common::{all_backends, mean, render, settings};
use gibs::builtin;
use gibs::reference::{ReferenceOptions, reference};

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

/// Multiplying every light by a power of two multiplies the result by exactly that.
#[test]
fn light_scales_exactly() {
    let backend = common::cpu();
    let at = |emission: f32| {
        render(
            backend.as_ref(),
            &builtin::furnace(0.5, emission),
            [32, 32],
            16,
            &settings(4_000),
            1,
        )
    };
    let (one, many) = (at(1.0), at(4096.0));
    let (one, many) = (one.rgb("E").expect("E"), many.rgb("E").expect("E"));
    for (a, b) in one
        .iter()
        .flat_map(|p| p.iter())
        .zip(many.iter().flat_map(|p| p.iter()))
    {
        assert_eq!(a * 4096.0, *b);
    }
}
