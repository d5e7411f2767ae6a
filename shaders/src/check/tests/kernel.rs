//! One kernel with a port of every kind, and every way for it to disagree.
use super::{GOOD, Good, check};
use gibs_graph::Stage;

/// What is wrong with a text for the ports of `Good`, as `port: message`.
fn problems(text: String) -> Vec<String> {
    check(text, &Good::ports())
}

#[test]
fn a_kernel_that_agrees_passes() {
    assert_eq!(problems(GOOD.into()), [""; 0]);
}

/// Each change of the text gives exactly the problems listed.
#[test]
fn every_mismatch_is_reported() {
    let cases: &[(&str, &str, &[&str])] = &[
        // Names.
        (
            "before",
            "after",
            &[
                "before: good.wgsl: there is no global `before`",
                ": good.wgsl:5:23: no port is called `after`",
            ],
        ),
        (
            "rays",
            "tree",
            &[
                "rays: good.wgsl: there is no global `rays`",
                "port `tree` is not seen by devices",
            ],
        ),
        (
            "target_",
            "target_2",
            &[
                "target: good.wgsl: there is no global `target_`",
                "no port is called `target_2`",
            ],
        ),
        // Use.
        (
            " * before[i].x",
            "",
            &["before: good.wgsl:5:23: declared but not used by `main`"],
        ),
        (
            "    helper(id.x);",
            "",
            &[
                "rays: good.wgsl:4:23: only its length is used",
                "before: good.wgsl:5:23: declared but not used",
                "both: good.wgsl:7:23: declared but not used",
            ],
        ),
        (
            "target_[id.x] =",
            "target_[id.x] +=",
            &["target: good.wgsl:6:23: declared `write`, but also read"],
        ),
        (
            "both[i] +=",
            "both[i] =",
            &["both: good.wgsl:7:23: over-declared: never read"],
        ),
        (
            "both[i] +=",
            "var x = both[i] +",
            &["both: good.wgsl:7:23: over-declared: never written"],
        ),
        (
            "atomicAdd(&counts[0], u32(view.t_min))",
            "atomicLoad(&counts[u32(view.t_min)])",
            &["counts: good.wgsl:8:23: over-declared: never written"],
        ),
        (
            "u32(view.t_min)",
            "1u",
            &["view: good.wgsl:3:23: declared but not used"],
        ),
        // Declared access.
        (
            "read> before",
            "read_write> before",
            &[
                "before: good.wgsl:5:23: declared `var<storage, read_write>`, but the port needs `var<storage, read>`",
            ],
        ),
        (
            "var<uniform> view: Ray;",
            "var<storage, read> view: Ray;",
            &[
                "view: good.wgsl:3:23: declared `var<storage, read>`, but the port needs `var<uniform>`",
            ],
        ),
        // Types.
        (
            "array<vec2<f32>>",
            "array<vec4<f32>>",
            &["before: good.wgsl:5:23: `vec2<f32>` in Rust, `vec4<f32>` in WGSL"],
        ),
        (
            "array<vec2<f32>>",
            "array<vec2<f32>, 9>",
            &["before: good.wgsl:5:23: needs the type `array<vec2<f32>>`"],
        ),
        (
            "struct Ray { origin: vec3<f32>, t_min: f32 }",
            "struct Ray { t_min: f32, origin: vec3<f32> }",
            &[
                "view: good.wgsl:3:23: struct `Ray` has 16 bytes in Rust, 32 in WGSL",
                "view: good.wgsl:3:23: member `origin` is at byte 0 in Rust, 16 in WGSL",
                "view: good.wgsl:3:23: member `t_min` is at byte 12 in Rust, 0 in WGSL",
                "rays: good.wgsl:4:23: struct `Pair` has 96 bytes in Rust, 112 in WGSL",
                "rays: good.wgsl:4:23: `ray`: struct `Ray` has 16 bytes in Rust, 32 in WGSL",
                "rays: good.wgsl:4:23: member `ray.origin` is at byte 0 in Rust, 16 in WGSL",
                "rays: good.wgsl:4:23: member `ray.t_min` is at byte 12 in Rust, 0 in WGSL",
                "rays: good.wgsl:4:23: member `frame` is at byte 16 in Rust, 32 in WGSL",
                "rays: good.wgsl:4:23: member `list` is at byte 80 in Rust, 96 in WGSL",
            ],
        ),
        (
            "Pair",
            "Couple",
            &["rays: good.wgsl:4:23: struct `Pair` in Rust, `Couple` in WGSL"],
        ),
        (
            "list:",
            "items:",
            &[
                "rays: good.wgsl:4:23: member `list` is missing in WGSL",
                "rays: good.wgsl:4:23: member `items` is missing in Rust",
            ],
        ),
        (
            "list: array<u32, 4>",
            "list: array<u32, 3>",
            &["`list`: 4 elements in Rust, 3 in WGSL"],
        ),
        (
            "list: array<u32, 4>",
            "list: array<f32, 4>",
            &["`list[]`: `u32` in Rust, `f32` in WGSL"],
        ),
        (
            "list: array<u32, 4>",
            "list: vec4<u32>",
            &["`list`: `array<u32, 4>` in Rust, `vec4<u32>` in WGSL"],
        ),
        (
            "frame: mat4x4<f32>",
            "frame: mat4x3<f32>",
            &["`frame[]`: `vec4<f32>` in Rust, `vec3<f32>` in WGSL"],
        ),
        // Sizes and bindings.
        (
            "@workgroup_size(64)",
            "@workgroup_size(32, 2)",
            &[": good.wgsl: `@workgroup_size` is [32, 2, 1], but the stage declares [64, 1, 1]"],
        ),
        (
            "@binding(5)",
            "@binding(7)",
            &[": good.wgsl:8:23: `counts` has binding 7, but 5 comes next"],
        ),
        (
            "@group(0) @binding(5)",
            "@group(1) @binding(0)",
            &[": good.wgsl:8:23: `counts` is in group 1"],
        ),
        // What does not compile.
        (
            "fn helper",
            "fn helper(",
            &[": good.wgsl:9:10: `(` is never closed"],
        ),
        (
            "rays[i].ray",
            "rays[i].rat",
            &[": good: good.wgsl:9:40: invalid field accessor `rat`"],
        ),
    ];
    let mut wrong = String::new();
    for (from, to, expected) in cases {
        let text = GOOD.replace(from, to);
        assert_ne!(text, GOOD, "{from}");
        let found = problems(text);
        let agree = |(found, expected): (&String, &&str)| found.contains(expected);
        if found.len() != expected.len() || !found.iter().zip(*expected).all(agree) {
            wrong += &format!("{from} -> {to}: {found:#?}\n");
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}
