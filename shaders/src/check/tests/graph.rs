//! What WebGPU does not guarantee, and the check as a part of compiling a graph.
use super::check;
use crate::Compiler;
use gibs_graph::{Access, Layout, Port, Scalar};

/// A kernel with so many buffers of a kind, and its ports.
fn many(count: u32, space: &str, access: Access) -> Vec<String> {
    const NAMES: [&str; 13] = [
        "a", "b", "c", "d", "e", "f", "g", "h", "i", "j", "k", "l", "m",
    ];
    let names = &NAMES[..count as usize];
    let ty = if access == Access::Uniform {
        "vec4<u32>"
    } else {
        "array<vec4<u32>>"
    };
    let mut text = String::new();
    for (binding, name) in names.iter().enumerate() {
        text += &format!("@group(0) @binding({binding}) var<{space}> {name}: {ty};\n");
    }
    let sum = names
        .iter()
        .map(|name| format!("_ = {name}[0];"))
        .collect::<String>();
    text += &format!("@compute @workgroup_size(64) fn main() {{ {sum} }}");
    let port = |&name| Port::new(name, access, Layout::Vector(Scalar::U32, 4), None, false);
    check(text, &names.iter().map(port).collect::<Vec<_>>())
}

#[test]
fn what_webgpu_does_not_guarantee_is_refused() {
    assert_eq!(many(8, "storage", Access::Read), [""; 0]);
    assert!(many(9, "storage", Access::Read)[0].contains("9 storage buffers; at most 8"));
    assert_eq!(many(12, "uniform", Access::Uniform), [""; 0]);
    assert!(many(13, "uniform", Access::Uniform)[0].contains("13 uniforms; at most 12"));
    let shared = |bytes: u32| {
        let text = format!(
            "var<workgroup> s: array<u32, {}>;\n@compute @workgroup_size(64) fn main() {{ s[0] = 1u; }}",
            bytes / 4
        );
        check(text, &[])
    };
    assert_eq!(shared(16384), [""; 0]);
    assert!(shared(16388)[0].contains("16400 bytes of workgroup memory; at most 16384"));
    let large = check("@compute @workgroup_size(16, 32) fn main() {}".into(), &[]);
    assert!(
        large[1].contains("a workgroup of [16, 32, 1] is too large"),
        "{large:?}"
    );
    let deep = check(
        "@compute @workgroup_size(1, 1, 65) fn main() {}".into(),
        &[],
    );
    assert!(deep[1].contains("64 along z"), "{deep:?}");
}

#[test]
fn a_graph_is_compiled_with_it() {
    let mut graph = gibs_graph::Graph::new("graph");
    let source = graph.input::<u32>("source", 4);
    let target = graph.transient::<u32>("target", 4);
    let made = graph.add::<copy::Copy>(
        "copy",
        copy::Inputs {
            source: &source,
            target,
        },
        gibs_graph::Dispatch::Elements(4),
    );
    graph.output("target", &made.target);
    let errors = graph
        .compile(Some(&Compiler::new()))
        .unwrap_err()
        .to_string();
    assert!(
        errors
            .contains("stage `copy`, port `source`: copy.wgsl:1:23: `u32` in Rust, `i32` in WGSL"),
        "{errors}"
    );
    assert_eq!(errors.matches("stage `copy`").count(), 2, "{errors}");
}

mod copy {
    gibs_graph::stage! {
        /// Its text has numbers of the wrong kind, and of the wrong workgroup size.
        pub stage Copy {
            wgsl: gibs_graph::WgslSource {
                name: "copy",
                text: "@group(0) @binding(0) var<storage, read> source: array<i32>;
                    @group(0) @binding(1) var<storage, read_write> target_: array<u32>;
                    @compute @workgroup_size(32) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
                        target_[id.x] = u32(source[id.x]);
                    }",
                modules: &[],
                features: &[],
            },
            workgroup: [64, 1, 1],
            ports: { read source: u32, write target: u32 },
            cpu: kernel,
            wide: None,
        }
    }

    fn kernel(_: &Views<'_>, _: gibs_graph::Workgroup) {}
}
