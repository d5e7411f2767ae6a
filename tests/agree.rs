//! One graph, three backends, the same picture.
mod common;

use common::{all_backends, render, settings};
use gibs::compare::{CompareOptions, compare};
use gibs::passes::frame::Settings;
use gibs::picture::{FINAL_IMAGE, Picture};
use gibs::{Renderer, builtin};

fn flip(a: &Picture, b: &Picture) -> f64 {
    let options = CompareOptions {
        layer: FINAL_IMAGE.into(),
        ..CompareOptions::default()
    };
    let report = compare(a, b, &options).expect("comparable");
    assert!(report.passed(), "{report}");
    report.metrics.flip
}

/// FLIP between any two backends after 64 frames stays below 0.002, a bound far below the difference between two
/// seeds, which is printed beside it.
fn agree(name: &str, size: [u32; 2], settings: &Settings) {
    let scene = builtin::by_name(name).expect("built in");
    let pictures: Vec<(String, Picture)> = all_backends()
        .iter()
        .map(|b| {
            (
                b.name().to_string(),
                render(b.as_ref(), &scene, size, 64, settings, 0),
            )
        })
        .collect();
    let backend = common::cpu();
    let other_seed = render(backend.as_ref(), &scene, size, 64, settings, 1);
    let seeds = flip(&other_seed, &pictures.last().expect("the CPU backend").1);
    println!("{name}: FLIP between two seeds {seeds:.5}");
    assert!(
        seeds > 0.002,
        "two seeds differ by {seeds}: the bound on backends would mean nothing"
    );
    for (i, (a_name, a)) in pictures.iter().enumerate() {
        for (b_name, b) in &pictures[..i] {
            let difference = flip(a, b);
            println!("{name}: FLIP between {a_name} and {b_name} {difference:.5}");
            assert!(
                difference <= 0.002,
                "{name}: {a_name} and {b_name} differ by {difference}"
            );
        }
    }
}

#[test]
fn backends_agree_on_the_cornell_box() {
    agree("cornell", [96, 96], &settings(8_000));
}

/// The order of sorted rays comes from keys and ranks of its own.
#[test]
fn backends_agree_on_sorted_rays() {
    let settings = Settings {
        sorting: true,
        ..settings(8_000)
    };
    agree("cornell", [96, 96], &settings);
}

/// Textures, cut-outs, instances, sun and sky.
#[test]
fn backends_agree_on_the_atrium() {
    agree("atrium", [96, 54], &settings(8_000));
}

/// A camera that backs away lets every surfel grow, and its depth function with it; one that comes near, the reverse.
#[test]
fn backends_agree_while_surfels_grow_and_shrink() {
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    let pictures = all_backends().into_iter().map(|backend| {
        let settings = settings(8_000);
        let mut renderer = Renderer::new(backend.as_ref(), &scene, &view, [96, 96], &settings, 0)
            .unwrap_or_else(|e| panic!("{}: {e}", backend.name()));
        for frame in 0..32_u32 {
            let mut camera = view.camera;
            let back = 1.0 + 0.5 * f64::from(16 - frame.abs_diff(16)) / 16.0;
            camera.position = camera.target + (camera.position - camera.target) * back;
            renderer.set_camera(camera);
            renderer.frame().expect("renders");
        }
        (
            backend.name().to_string(),
            renderer.picture().expect("renders"),
        )
    });
    let pictures: Vec<(String, Picture)> = pictures.collect();
    let (_, ours) = pictures.last().expect("the CPU backend");
    for (name, picture) in &pictures {
        let difference = flip(picture, ours);
        println!("FLIP between {name} and the last backend {difference:.5}");
        assert!(difference <= 0.002, "{name}: {difference}");
    }
}
