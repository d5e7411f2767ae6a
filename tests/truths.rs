//! The reference and surfels against pictures of an independent renderer, where they lie beside the project.
mod common;

use common::{cpu, scenes};
use gibs::compare::{CompareOptions, compare, noise_floor};
use gibs::gltf_import;
use gibs::passes::frame::Settings;
use gibs::picture::Picture;
use gibs::reference::{ReferenceOptions, reference};
use gibs::view::View;

/// Block error within 2 % plus the noise of the truth and our own, bias within 1 %. Both noises are those of two
/// halves: the truth comes with its own, ours are two runs with `samples` per pixel, whose mean is compared.
/// `docs/accuracy.md` has the block errors at 1500 samples, which take hours on all views.
fn agrees(scene: &str, samples: u32, views: &[&str]) {
    let Some(scenes) = scenes() else {
        eprintln!("not run: there are no truths beside the project");
        return;
    };
    let folder = scenes.join(scene);
    let imported = gltf_import::load(&folder.join(format!("{scene}.gltf"))).expect("loads");
    let read = |name: &str| Picture::read_exr(&folder.join(name)).expect("reads");
    let options = CompareOptions::default();
    for name in views {
        let view = View::load(folder.join(format!("view-{name}.json"))).expect("loads");
        let half = |seed| {
            let options = ReferenceOptions {
                size: view.resolution,
                samples,
                seed,
                emitters: true,
            };
            reference(cpu().as_ref(), &imported.scene, &view, &options, |_, _| {})
                .expect("renders")
                .0
        };
        let (one, other) = (half(5), half(6));
        let mut both = one.clone();
        let planes = |p: &Picture| {
            p.rgb(&options.layer)
                .expect("the layer")
                .map(<[f32]>::to_vec)
        };
        let (a, b) = (planes(&one), planes(&other));
        let mean = [0, 1, 2].map(|c| {
            let pairs = a[c].iter().zip(&b[c]);
            pairs.map(|(x, y)| 0.5 * (x + y)).collect::<Vec<f32>>()
        });
        both.set_rgb(&options.layer, mean).expect("as before");

        let truth = read(&format!("truth-{name}.exr"));
        let halves = [
            read(&format!("truth-{name}-halfA.exr")),
            read(&format!("truth-{name}-halfB.exr")),
        ];
        let noise = noise_floor(&halves[0], &halves[1], &truth, &options).expect("comparable");
        let own = noise_floor(&one, &other, &truth, &options).expect("comparable");
        let report = compare(&both, &truth, &options).expect("comparable");
        let (block, bias) = (report.metrics.block_error, report.metrics.bias);
        println!(
            "{scene} {name}: block error {block:.4} (noise {:.4}, own {:.4}), bias {bias:.5}",
            noise.block_error, own.block_error
        );
        assert!(
            block <= 0.02 + noise.block_error + own.block_error,
            "{scene} {name}: block error {block}"
        );
        assert!(bias.abs() <= 0.01, "{scene} {name}: bias {bias}");
    }
}

/// Surfels after 256 frames with default settings: block error within `block`, bias within 1 %. The truth's noise is left in. Measured are
/// 1.0 % on the Cornell box and 1.7 % on Sponza, where 4 % and 7 % are the aim, and biases of 0.3 %.
fn surfels_agree(scene: &str, name: &str, block: f64) {
    let Some(scenes) = scenes() else {
        eprintln!("not run: there are no truths beside the project");
        return;
    };
    let folder = scenes.join(scene);
    let imported = gltf_import::load(&folder.join(format!("{scene}.gltf"))).expect("loads");
    let view = View::load(folder.join(format!("view-{name}.json"))).expect("loads");
    let truth = Picture::read_exr(&folder.join(format!("truth-{name}.exr"))).expect("reads");
    let settings = Settings::default();
    let loaded = (imported.scene, view);
    let size = loaded.1.resolution;
    let ours = common::render(cpu().as_ref(), &loaded, size, 256, &settings, 0);
    let report = compare(&ours, &truth, &CompareOptions::default()).expect("comparable");
    let found = report.metrics;
    println!(
        "{scene} {name}: block error {:.4}, bias {:.5}",
        found.block_error, found.bias
    );
    assert!(
        found.block_error <= block,
        "{scene} {name}: {}",
        found.block_error
    );
    assert!(found.bias.abs() <= 0.01, "{scene} {name}: {}", found.bias);
}

#[test]
fn surfels_agree_on_the_cornell_box() {
    surfels_agree("cornell", "a", 0.02);
}

#[test]
fn surfels_agree_on_sponza() {
    surfels_agree("sponza", "a", 0.03);
}

#[test]
fn the_reference_agrees_on_the_cornell_box() {
    agrees("cornell", 96, &["a", "b"]);
}

#[test]
fn the_reference_agrees_on_sponza() {
    agrees("sponza", 192, &["a", "b"]);
}

#[test]
fn the_reference_agrees_on_sponza_lit_by_emissive_boxes() {
    agrees("sponza-emissive", 256, &["a", "b"]);
}

#[test]
fn the_reference_agrees_on_skinned_characters() {
    agrees("skinned-room", 256, &["a", "b"]);
}
