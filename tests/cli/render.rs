//! `gibs render`, `gibs reference` and `gibs compare`.
use crate::program::*;
use gibs::picture::Picture;
use serde_json::Value;
use std::path::Path;

#[test]
fn debug_views_are_listed_refused_and_written() {
    let help = succeed(&["render", "--help"]);
    for view in ["surfels", "coverage", "cell-heat", "depth-function"] {
        assert!(help.contains(&format!("- {view}:")), "{view}: {help}");
    }
    let folder = Folder::new("debug");
    let (exr, png) = (folder.path("a.exr"), folder.path("a.png"));
    refused(
        &["render", "cornell", "--debug", "surfel", "--out", &exr],
        &["'surfel'", "surfels, coverage", "transform-id", "guide"],
    );
    refused(
        &["render", "cornell", "--debug", "guide", "--out", &exr],
        &["`guide`", "`guiding=on`"],
    );
    refused(
        &["graph", "cornell", "--set", "debug=probes"],
        &["`probes`", "surfels, coverage"],
    );
    assert!(folder.names().is_empty(), "{:?}", folder.names());

    let seen = render(&exr, &["--debug", "radius"]);
    assert_eq!(seen.status.code(), Some(0), "{}", stderr(&seen));
    let line = "debug view radius, pixels: 0 (black) to 16 (pale yellow); here";
    assert!(stdout(&seen).contains(line), "{}", stdout(&seen));
    assert_eq!(folder.names(), ["a.exr", "a.png"]);
    let picture = Picture::read_exr(Path::new(&exr)).unwrap();
    let radii = picture.scalar("debug.radius").unwrap();
    assert!(radii.iter().any(|r| *r > 0.5) && picture.has("E.R"));
    let beside = std::fs::read(&png).unwrap();
    let alone = render(&png, &["--debug", "radius", "--json"]);
    let summary: Value = serde_json::from_str(&stdout(&alone)).unwrap();
    assert_eq!(summary["debug"]["view"], "radius");
    assert_eq!(summary["debug"]["scale"]["heat"], 16.0);
    assert_eq!(std::fs::read(&png).unwrap(), beside);
    let graph = succeed(&["graph", "cornell", "--set", "debug=grid"]);
    assert!(graph.contains("debug/surface"), "{graph}");
    assert!(!succeed(&["graph", "cornell"]).contains("debug/"));
}

#[test]
fn a_render_writes_its_channels_a_preview_and_a_summary() {
    let folder = Folder::new("render");
    let out = folder.path("box.exr");
    let output = render(&out, &["--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let summary: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(summary["backend"], "cpu");
    assert_eq!(summary["size"], serde_json::json!([64, 64]));
    assert_eq!(summary["frames"], 2);
    assert_eq!(summary["out"], out.as_str());
    assert!(summary["surfels"].as_u64().unwrap() > 0, "{summary}");
    assert!(summary["bytes"].as_u64().unwrap() > 0, "{summary}");

    assert_eq!(folder.names(), ["box.exr", "box.png"]);
    let picture = Picture::read_exr(Path::new(&out)).unwrap();
    assert_eq!([picture.width, picture.height], [64, 64]);
    for channel in [
        "R",
        "G",
        "B",
        "E.R",
        "direct.R",
        "indirect.G",
        "albedo.B",
        "normal.X",
        "position.Y",
        "depth.Z",
        "mask.A",
    ] {
        let values = picture.scalar(channel).unwrap();
        assert!(values.iter().all(|v| v.is_finite()), "{channel}");
    }
    assert!(picture.scalar("E.R").unwrap().iter().any(|&v| v > 0.0));
    let preview = image::image_dimensions(folder.path("box.png")).unwrap();
    assert_eq!(preview, (64, 64));
}

#[test]
fn a_render_without_rays_says_what_that_means() {
    let folder = Folder::new("no-rays");
    let output = render(&folder.path("box.exr"), &["--rays", "0"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stderr(&output).contains("indirect light is zero"));
    let output = render(&folder.path("box.exr"), &[]);
    assert!(!stderr(&output).contains("indirect light is zero"));
}

#[test]
fn a_pipe_sees_no_progress_bar() {
    let folder = Folder::new("pipe");
    let output = render(&folder.path("box.png"), &[]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    for text in [stdout(&output), stderr(&output)] {
        let odd = text.chars().find(|c| c.is_control() && *c != '\n');
        assert_eq!(odd, None, "{text:?}");
        assert!(!text.contains('█') && !text.contains('░'), "{text:?}");
    }
    assert!(stdout(&output).contains("2 frames of 64x64"));
    assert_eq!(folder.names(), ["box.png"]);
}

#[test]
fn the_same_seed_gives_the_same_bits() {
    let folder = Folder::new("seed");
    let picture = |name: &str, seed: &str| {
        let out = folder.path(name);
        let output = render(&out, &["--seed", seed]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        Picture::read_exr(Path::new(&out)).unwrap()
    };
    let (first, again, other) = (
        picture("a.exr", "1"),
        picture("b.exr", "1"),
        picture("c.exr", "2"),
    );
    let bits = |p: &Picture, channel: &str| -> Vec<u32> {
        let values = p.scalar(channel).unwrap();
        values.iter().map(|v| v.to_bits()).collect()
    };
    for channel in first.channels.keys() {
        assert_eq!(bits(&first, channel), bits(&again, channel), "{channel}");
    }
    assert_ne!(bits(&first, "E.R"), bits(&other, "E.R"));
}

#[test]
fn a_reference_says_how_certain_it_is_and_judges_a_render() {
    let folder = Folder::new("reference");
    let truth = folder.path("truth.exr");
    let args = [
        "reference",
        "cornell",
        "--backend",
        "cpu",
        "--size",
        "16x16",
        "--spp",
        "4",
        "--out",
        &truth,
        "--json",
    ];
    let certainty = json(&args);
    assert_eq!(certainty["samples"], 4);
    assert!(
        certainty["standard_error"].as_f64().unwrap() > 0.0,
        "{certainty}"
    );
    let picture = Picture::read_exr(Path::new(&truth)).unwrap();
    assert!(picture.scalar("E.G").unwrap().iter().any(|&v| v > 0.0));

    // Our picture has four times the size, so cells of 4x4 pixels are averaged.
    let ours = folder.path("ours.exr");
    let output = render(&ours, &[]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let heat = folder.path("heat.png");
    let report = json(&["compare", &ours, &truth, "--out", &heat, "--json"]);
    assert_eq!(report["averaged"], 4);
    assert!(report["metrics"]["rel_mse"].as_f64().unwrap() > 0.0);
    assert_eq!(image::image_dimensions(&heat).unwrap(), (16, 16));
}

#[test]
fn a_picture_has_no_error_against_itself() {
    let folder = Folder::new("self");
    let out = folder.path("box.exr");
    let output = render(&out, &[]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    for channel in ["E", "RGB", "indirect"] {
        let report = json(&["compare", &out, &out, "--channel", channel, "--json"]);
        for metric in [
            "rel_mse",
            "rmse",
            "mape",
            "bias",
            "p99",
            "block_error",
            "flip",
        ] {
            assert_eq!(report["metrics"][metric], 0.0, "{channel} {metric}");
        }
    }
    refused(
        &["compare", &folder.path("none.exr"), &out],
        &["none.exr", "no such file"],
    );
    refused(
        &["compare", &out, &folder.path("box.png")],
        &["box.png", "not an OpenEXR file"],
    );
    refused(
        &["compare", &out, &out, "--channel", "velocity"],
        &["velocity", "E.R"],
    );
}
