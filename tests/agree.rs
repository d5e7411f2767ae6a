//! One graph, three backends, the same picture.
mod common;

use common::{all_backends, render, settings};
use gibs::builtin;
use gibs::compare::{CompareOptions, compare};
use gibs::picture::{FINAL_IMAGE, Picture};

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
fn agree(name: &str, size: [u32; 2]) {
    let scene = builtin::by_name(name).expect("built in");
    let settings = settings(8_000);
    let pictures: Vec<(String, Picture)> = all_backends()
        .iter()
        .map(|b| {
            (
                b.name().to_string(),
                render(b.as_ref(), &scene, size, 64, &settings, 0),
            )
        })
        .collect();
    let backend = common::cpu();
    let other_seed = render(backend.as_ref(), &scene, size, 64, &settings, 1);
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
    agree("cornell", [96, 96]);
}

/// Textures, cut-outs, instances, sun and sky.
#[test]
fn backends_agree_on_the_atrium() {
    agree("atrium", [96, 54]);
}
