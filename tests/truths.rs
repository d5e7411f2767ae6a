//! The reference against pictures of an independent renderer, where they lie beside the project.
mod common;

use common::cpu;
use gibs::compare::{CompareOptions, compare, noise_floor};
use gibs::gltf_import;
use gibs::picture::Picture;
use gibs::reference::{ReferenceOptions, reference};
use gibs::view::View;
use std::path::{Path, PathBuf};

fn scenes() -> Option<PathBuf> {
    let folder = std::env::var_os("GIBS_SHARED").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared"),
        PathBuf::from,
    );
    Some(folder.join("scenes")).filter(|f| f.is_dir())
}

/// Block error within 2 % plus the truth's own noise, bias within 1 %, as far as 192 samples per pixel show it: their
/// own block noise, 0.9 % on this view, adds in squares.
#[test]
fn the_reference_agrees_on_the_cornell_box() {
    let Some(scenes) = scenes() else {
        eprintln!("not run: there are no truths beside the project");
        return;
    };
    let folder = scenes.join("cornell");
    let imported = gltf_import::load(&folder.join("cornell.gltf")).expect("loads");
    let read = |name: &str| Picture::read_exr(&folder.join(name)).expect("reads");
    for name in ["a", "b"] {
        let view = View::load(folder.join(format!("view-{name}.json"))).expect("loads");
        let options = ReferenceOptions {
            size: view.resolution,
            samples: 192,
            seed: 5,
        };
        let (picture, _) = reference(cpu().as_ref(), &imported.scene, &view, &options, |_, _| {})
            .expect("renders");
        let truth = read(&format!("truth-{name}.exr"));
        let halves = [
            read(&format!("truth-{name}-halfA.exr")),
            read(&format!("truth-{name}-halfB.exr")),
        ];
        let noise = noise_floor(&halves[0], &halves[1], &truth, &CompareOptions::default())
            .expect("comparable");
        let report = compare(&picture, &truth, &CompareOptions::default()).expect("comparable");
        let (block, bias) = (report.metrics.block_error, report.metrics.bias);
        println!(
            "cornell {name}: block error {block:.4} (noise {:.4}), bias {bias:.5}",
            noise.block_error
        );
        assert!(
            block <= 0.02 + noise.block_error,
            "cornell {name}: block error {block}"
        );
        assert!(bias.abs() <= 0.01, "cornell {name}: bias {bias}");
    }
}
