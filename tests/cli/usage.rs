//! Bad usage and bad input, and what is listed.
use crate::program::*;

#[test]
fn help_and_version_are_no_failure() {
    let help = succeed(&["--help"]);
    for command in [
        "render",
        "reference",
        "compare",
        "graph",
        "profile",
        "guiding",
        "bench",
        "settings",
        "devices",
    ] {
        assert!(help.contains(command), "{command} is not in: {help}");
    }
    assert!(succeed(&["--version"]).contains(env!("CARGO_PKG_VERSION")));
    assert_eq!(gibs(&[]).status.code(), Some(2), "a command is needed");
    assert_eq!(gibs(&["bake"]).status.code(), Some(2));
}

#[test]
fn scenes_that_are_not_there_are_named_with_those_that_are() {
    refused(
        &["render", "sponge", "--backend", "cpu"],
        &["`sponge`", ".gltf", "cornell", "atrium"],
    );
    refused(&["graph", "sponge"], &["`sponge`", "cornell"]);
    refused(&["reference", "missing.gltf"], &["missing.gltf", "check"]);
}

#[test]
fn broken_scene_files_are_named() {
    let folder = Folder::new("broken");
    let broken = folder.write("broken.gltf", "{ \"asset\": ");
    refused(&["graph", &broken], &["broken.gltf"]);
    let not_a_scene = folder.write("truncated.glb", "glTF");
    refused(&["graph", &not_a_scene], &["truncated.glb"]);
    let empty = folder.write("old.gltf", "{ \"asset\": { \"version\": \"1.0\" } }");
    refused(&["graph", &empty], &["old.gltf"]);
}

#[test]
fn bad_sizes_say_what_is_taken() {
    for size in ["64", "64x", "ax64", "64x-1"] {
        refused(
            &["graph", "cornell", "--size", size],
            &[size, "width and height", "960x540"],
        );
    }
    let folder = Folder::new("size");
    let out = folder.path("a.exr");
    for size in ["0x64", "64x9000"] {
        refused(
            &[
                "render",
                "cornell",
                "--backend",
                "cpu",
                "--size",
                size,
                "--out",
                &out,
            ],
            &[size, "1 to 8192"],
        );
    }
    assert!(folder.names().is_empty(), "{:?}", folder.names());
    refused(
        &["bench", "cornell", "--size", "0x5"],
        &["0x5", "1 to 8192"],
    );
}

/// A minus does not make an option of a number.
#[test]
fn negative_numbers_are_refused_with_the_range() {
    for (command, option) in [
        ("render", "--frames"),
        ("profile", "--runs"),
        ("bench", "--seeds"),
    ] {
        refused(&[command, "cornell", option, "-1"], &[option, "-1", "1..="]);
    }
}

#[test]
fn bad_backends_and_settings_list_what_there_is() {
    refused(
        &["render", "cornell", "--backend", "metal"],
        &["`metal`", "auto, cpu, wgpu or vulkan"],
    );
    refused(
        &["graph", "cornell", "--set", "radius"],
        &["--set", "`radius`", "KEY=VALUE"],
    );
    refused(
        &["graph", "cornell", "--set", "radios=4"],
        &["`radios`", "gibs settings"],
    );
    refused(
        &["graph", "cornell", "--set", "half-resolution=off"],
        &["`half-resolution`", "`half_resolution`"],
    );
    refused(
        &["graph", "cornell", "--set", "rays=-1"],
        &["`rays`", "`-1`", "0 to 4000000"],
    );
    refused(
        &["graph", "cornell", "--set", "depth=perhaps"],
        &["`depth`", "on or off"],
    );
    refused(
        &["graph", "cornell", "--without", "depth,gravity"],
        &["--without", "`gravity`", "depth"],
    );
    refused(
        &["graph", "cornell", "--set", "grid_side=3"],
        &["`grid_side`", "`3`", "from 4 to 64"],
    );
    refused(
        &["render", "cornell", "--frames", "0"],
        &["--frames", "'0'"],
    );
}

/// `stress` and `roam` warn of settings that leave no light, as `render` does, and every command of an option that changes nothing.
#[test]
fn what_makes_no_difference_or_no_light_is_said() {
    let says = |args: &[&str], part: &str| {
        let output = gibs(args);
        let message = stderr(&output);
        assert!(output.status.success(), "{args:?}: {message}");
        assert!(message.contains(part), "{args:?}: {message}");
    };
    let off = "`--without clamp` changes nothing";
    says(&["graph", "cornell", "--without", "clamp,sharing"], off);
    let small = [
        "cornell",
        "--size",
        "16x9",
        "--frames",
        "2",
        "--backend",
        "cpu",
    ];
    for command in ["stress", "roam"] {
        let with = |more: &'static [&str]| [&[command], &small[..], more].concat();
        says(&with(&["--rays", "0"]), "without rays");
        says(&with(&["--set", "surfels=0"]), "without surfels");
    }
}

/// Which of the two would win is nothing to guess.
#[test]
fn two_options_about_one_setting_are_refused() {
    refused(
        &[
            "graph",
            "cornell",
            "--without",
            "clamp,sharing",
            "--set",
            "sharing=on",
        ],
        &["`sharing`", "`--without sharing`"],
    );
    refused(
        &[
            "graph",
            "cornell",
            "--without",
            "continuation",
            "--set",
            "continuations=2",
        ],
        &["`continuations`", "`--without continuation`"],
    );
    refused(
        &["render", "cornell", "--rays", "100", "--set", "rays=200"],
        &["`rays`", "`--rays`"],
    );
    refused(
        &["stress", "cornell", "--rays", "20,30", "--set", "rays=10"],
        &["`rays`", "`--rays`"],
    );
    refused(
        &["graph", "cornell", "--set", "rays=3", "--set", "rays=5"],
        &["`rays`", "`--set rays=3`"],
    );
    refused(
        &[
            "render",
            "cornell",
            "--debug",
            "coverage",
            "--set",
            "debug=radius",
        ],
        &["`debug`", "`--debug`"],
    );
    refused(
        &["guiding", "sun", "--rays", "7", "--rays-per-frame", "8"],
        &["--rays", "`7`", "at least the 8"],
    );
}

#[test]
fn settings_files_are_held_to_the_same_rules() {
    let folder = Folder::new("settings");
    let graph = |file: &str| {
        let path = folder.path(file);
        gibs(&["graph", "cornell", "--settings", &path])
    };
    let good = "rays = 500\ndepth = false\nclamp = \"on\"\nsorting = 1\ncoverage = 2\ndebug = \"coverage\"\n";
    folder.write("good.toml", good);
    assert_eq!(graph("good.toml").status.code(), Some(0));
    for (file, text, part) in [
        ("key.toml", "rayz = 500", "rayz"),
        ("range.toml", "radius = 1000.0", "radius"),
        ("side.toml", "grid_side = 3", "grid_side"),
        ("kind.toml", "depth = 3", "on or off"),
        ("text.toml", "rays = true", "from 0 to"),
        ("array.toml", "rays = [1]", "from 0 to"),
        ("syntax.toml", "rays =", "line 1"),
    ] {
        let path = folder.write(file, text);
        refused(&["graph", "cornell", "--settings", &path], &[file, part]);
    }
    refused(
        &["graph", "cornell", "--settings", &folder.path("none.toml")],
        &["none.toml"],
    );
}

#[test]
fn view_files_that_cannot_be_used_are_named() {
    let folder = Folder::new("view");
    let missing = folder.path("none.json");
    refused(
        &["graph", "cornell", "--view", &missing],
        &["none.json", "check that the path is right"],
    );
    let broken = folder.write("broken.json", "{ \"camera\": 3 }");
    refused(
        &["graph", "cornell", "--view", &broken],
        &["broken.json", "line"],
    );
    refused(&["graph", &broken], &["broken.json", "--view"]);
}

#[test]
fn files_that_cannot_be_written_are_known_before_any_work() {
    let folder = Folder::new("unwritable");
    let nowhere = folder.path("missing/a.exr");
    refused(
        &["render", "cornell", "--backend", "cpu", "--out", &nowhere],
        &["a.exr", "does not exist"],
    );
    refused(
        &[
            "reference",
            "cornell",
            "--backend",
            "cpu",
            "--out",
            &nowhere,
        ],
        &["a.exr", "does not exist"],
    );
    let strange = folder.path("a.bmp");
    refused(
        &["render", "cornell", "--backend", "cpu", "--out", &strange],
        &["a.bmp", ".exr", ".png"],
    );
    assert!(folder.names().is_empty(), "{:?}", folder.names());
}

#[test]
fn settings_are_listed_with_range_and_meaning() {
    let all = json(&["settings", "--json"]);
    let all = all.as_array().unwrap();
    assert!(!all.is_empty());
    for setting in all {
        let number = |key: &str| setting[key].as_f64().unwrap();
        assert!(
            number("least") <= number("default") && number("default") <= number("most"),
            "{setting}"
        );
        assert!(!setting["about"].as_str().unwrap().is_empty(), "{setting}");
    }
    let text = succeed(&["settings"]);
    for setting in all {
        let name = setting["name"].as_str().unwrap();
        assert!(
            text.lines().any(|line| line.starts_with(name)),
            "{name} is not in: {text}"
        );
    }
    let line = |name: &str| text.lines().find(|line| line.starts_with(name));
    let words = |name: &str| line(name).map(|l| l.split_whitespace().take(5).collect::<Vec<_>>());
    assert_eq!(
        words("depth "),
        Some(vec!["depth", "on", "off", "or", "on"])
    );
    assert_eq!(
        words("guiding"),
        Some(vec!["guiding", "off", "off", "or", "on"])
    );
}

#[test]
fn devices_always_include_the_processor() {
    let all = json(&["devices", "--json"]);
    let cpu = all
        .as_array()
        .unwrap()
        .iter()
        .find(|e| e["backend"] == "cpu");
    let devices = cpu.unwrap()["devices"].as_array().unwrap();
    assert_eq!(devices[0]["kind"], "cpu");
    assert!(succeed(&["devices"]).contains("auto picks"));
}
