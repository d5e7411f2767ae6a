use super::*;
use gibs_graph::{ImageFormat, Stage, WgslSource};

gibs_graph::element! {
    /// Sixteen bytes.
    pub struct Ray {
        /// Start.
        origin: glam::Vec3,
        /// Least distance.
        t_min: f32,
    }
    /// A struct within a struct.
    pub struct Pair {
        /// One.
        ray: Ray,
        /// Four columns.
        frame: [glam::Vec4; 4],
        /// Numbers.
        list: [u32; 4],
    }
}

const GOOD: &str = "struct Ray { origin: vec3<f32>, t_min: f32 }
struct Pair { ray: Ray, frame: mat4x4<f32>, list: array<u32, 4> }
@group(0) @binding(0) var<uniform> view: Ray;
@group(0) @binding(1) var<storage, read> rays: array<Pair>;
@group(0) @binding(2) var<storage, read> before: array<vec2<f32>>;
@group(0) @binding(3) var<storage, read_write> target_: array<u32>;
@group(0) @binding(4) var<storage, read_write> both: array<f32>;
@group(0) @binding(5) var<storage, read_write> counts: array<atomic<u32>>;
fn helper(i: u32) { both[i] += rays[i].ray.t_min * before[i].x; }
@compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&rays) { return; }
    helper(id.x);
    target_[id.x] = atomicAdd(&counts[0], u32(view.t_min));
}
";

mod good {
    use super::{Pair, Ray};

    gibs_graph::stage! {
        /// Has a port of every kind.
        pub stage Good {
            wgsl: gibs_graph::WgslSource { name: "good", text: super::GOOD, modules: &[], features: &[] },
            workgroup: [64, 1, 1],
            ports: {
                uniform view: Ray,
                read rays: Pair,
                previous before: glam::Vec2,
                write target: u32,
                read_write both: f32,
                atomic counts: u32,
                host_only tree: u32,
            },
            cpu: kernel,
            wide: None,
        }
    }

    fn kernel(_: &Views<'_>, _: gibs_graph::Workgroup) {}
}
use good::Good;

/// What is wrong with a text for the ports of `Good`, as `port: message`.
fn problems(text: String) -> Vec<String> {
    check(text, &Good::ports())
}

fn check(text: String, ports: &[Port]) -> Vec<String> {
    let wgsl = WgslSource {
        text: text.leak(),
        ..Good::kernel().wgsl
    };
    let found = Compiler::new().check(
        "stage",
        &KernelSource {
            wgsl,
            ..Good::kernel()
        },
        ports,
        &[],
    );
    let describe = |error| match error {
        GraphError::Shader {
            stage,
            port,
            message,
        } => {
            assert_eq!(stage, "stage");
            format!("{}: {message}", port.unwrap_or_default())
        }
        other => panic!("{other}"),
    };
    found
        .err()
        .unwrap_or_default()
        .into_iter()
        .map(describe)
        .collect()
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

fn port(access: Access, element: Layout) -> Port {
    Port::new("x", access, element, None, false)
}

const U32: Layout = Layout::Scalar(Scalar::U32);

/// Texts with one global `x` and what is wrong with them for a port; nothing else is.
#[test]
fn every_kind_of_global_is_held_against_its_port() {
    let vec3 = || Layout::Vector(Scalar::F32, 3);
    let list = || Layout::Struct {
        name: "S".into(),
        size: 16,
        fields: Vec::new(),
    };
    let (load, store, add) = ("_ = x[0];", "x[0] = 1u;", "atomicAdd(&x[0], 1u);");
    let image = "var x: texture_2d<f32>;";
    let cases: &[(Port, &str, &str, &[&str])] = &[
        (
            port(Access::Read, U32),
            "var<storage, read> x: array<u32>;",
            load,
            &[],
        ),
        (
            port(Access::Read, U32),
            "var<storage> x: array<u32>;",
            "let p = &x; _ = (*p)[0];",
            &[],
        ),
        (
            port(Access::Read, U32),
            "var<storage> x: array<u32>;",
            "_ = &x;",
            &["only its length is used"],
        ),
        (
            port(Access::Write, U32),
            "var<storage, read_write> x: array<u32>;",
            store,
            &[],
        ),
        (
            port(Access::Write, U32),
            "var<storage, read_write> x: array<u32>;",
            "let p = &x; (*p)[0]++;",
            &["declared `write`, but also read"],
        ),
        (
            port(Access::Write, U32),
            "var<storage, read> x: array<u32>;",
            load,
            &["port needs `var<storage, read_write>`"],
        ),
        (
            port(Access::Atomic, U32),
            "var<storage, read_write> x: array<atomic<u32>>;",
            add,
            &[],
        ),
        (
            port(Access::Atomic, U32),
            "var<storage, read_write> x: array<atomic<u32>>;",
            "atomicStore(&x[0], 1u);",
            &[],
        ),
        (
            port(Access::Atomic, U32),
            "var<storage, read_write> x: array<atomic<i32>>;",
            "atomicAdd(&x[0], 1i);",
            &["`u32` in Rust, `i32` in WGSL"],
        ),
        (
            port(Access::Atomic, U32),
            "var<storage, read_write> x: array<u32>;",
            store,
            &["needs the type `array<atomic"],
        ),
        (
            port(Access::Write, U32),
            "var<storage, read_write> x: array<atomic<u32>>;",
            "atomicStore(&x[0], 1u);",
            &["declare the port `atomic`"],
        ),
        (
            port(Access::Atomic, list()),
            "struct S { a: atomic<u32> } @group(0) @binding(0) var<storage, read_write> x: array<S>;",
            "atomicAdd(&x[0].a, 1u);",
            &[
                "needs the type `array<atomic<u32>>`",
                "member `a`: atomics within a struct or an array are not supported",
            ],
        ),
        (
            port(Access::Read, vec3()),
            "var<storage, read> x: array<vec3<f32>>;",
            load,
            &["elements are 12 bytes apart in Rust, 16 in WGSL; pad `vec3<f32>` to 16 bytes"],
        ),
        (
            port(Access::Read, U32),
            image,
            "_ = textureLoad(x, vec2<u32>(), 0);",
            &["declared `var _: texture_2d<f32>`, but the port needs `var<storage, read>`"],
        ),
        (
            port(Access::Read, list()),
            "struct S { a: array<u32> } @group(0) @binding(0) var<storage> x: S;",
            "_ = x.a[0];",
            &["needs the type `array<S>`"],
        ),
        (
            port(Access::Uniform, Layout::Vector(Scalar::F32, 4)),
            "var<uniform> x: vec4<f32>;",
            load,
            &[],
        ),
        (
            port(Access::Uniform, Layout::Vector(Scalar::F32, 4)),
            "var<uniform> x: vec4<u32>;",
            load,
            &["`vec4<f32>` in Rust, `vec4<u32>` in WGSL"],
        ),
        (
            port(Access::Uniform, U32),
            "var<storage, read> x: array<u32>;",
            load,
            &["the port needs `var<uniform>`", "needs the type `u32`"],
        ),
        (
            port(Access::HostOnly, U32),
            "var<storage, read> x: array<u32>;",
            load,
            &["port `x` is not seen by devices"],
        ),
        (
            port(Access::Indirect, U32),
            "var<storage, read> x: array<u32>;",
            load,
            &["port `x` is not seen by devices"],
        ),
    ];
    let mut wrong = String::new();
    for (port, global, body, expected) in cases {
        let slot = if global.starts_with("struct") {
            ""
        } else {
            "@group(0) @binding(0) "
        };
        let text = format!("{slot}{global}\n@compute @workgroup_size(64) fn main() {{ {body} }}");
        let found = check(text, std::slice::from_ref(port));
        let agree = |(found, expected): (&String, &&str)| found.contains(expected);
        if found.len() != expected.len() || !found.iter().zip(*expected).all(agree) {
            wrong += &format!("{:?} {global} {body}: {found:#?}\n", port.access);
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

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

/// A kernel with one image `x`, held against a port of a format.
fn image(ty: &str, body: &str, format: ImageFormat) -> Vec<String> {
    let text = format!(
        "@group(0) @binding(0) var x: {ty};\n@compute @workgroup_size(64) fn main() {{ {body} }}"
    );
    let access = if format.is_stored() {
        Access::Stored
    } else {
        Access::Sampled
    };
    let port = Port::new("x", access, format.value(), Some(format), false);
    check(text, &[port])
}

#[test]
fn images_are_held_against_their_ports() {
    let load = "_ = textureLoad(x, vec2(0u), 0);";
    let store = "textureStore(x, vec2(0u), vec4(0.0));";
    let stored = |format: &str| format!("texture_storage_2d<{format}, write>");
    let good = [
        ("texture_2d<f32>".to_string(), load, ImageFormat::Float),
        ("texture_2d<u32>".into(), load, ImageFormat::Uint),
        (stored("rgba16float"), store, ImageFormat::Rgba16Float),
        (stored("rgba32float"), store, ImageFormat::Rgba32Float),
        (stored("rgba8unorm"), store, ImageFormat::Rgba8Unorm),
    ];
    for (ty, body, format) in &good {
        assert_eq!(image(ty, body, *format), [""; 0], "{ty}");
        for (_, _, other) in good.iter().filter(|(_, _, other)| other != format) {
            let found = image(ty, body, *other);
            assert!(
                found[0].contains("but the port needs"),
                "{ty} for {other:?}: {found:?}"
            );
        }
    }
    let unused = image("texture_2d<f32>", "", ImageFormat::Float);
    assert!(unused[0].contains("not used by `main`"), "{unused:?}");
    let array = image(
        "texture_2d_array<f32>",
        "_ = textureLoad(x, vec2(0u), 0, 0);",
        ImageFormat::Float,
    );
    assert!(array[0].contains("no port can be this"), "{array:?}");
}

/// A kernel for an optional port `x`, with and without it.
#[test]
fn optional_ports_are_parts_of_the_kernel() {
    let text = |condition: &str| {
        format!(
            "@group(0) @binding(0) var<storage, read> a: array<u32>;
             {condition} @group(0) @binding(1) var<storage, read> x: array<u32>;
             @group(0) @binding(2) var<storage, read_write> b: array<u32>;
             {condition} fn first() -> u32 {{ return x[0]; }}
             @if(!x) fn first() -> u32 {{ return 0u; }}
             @compute @workgroup_size(64) fn main() {{ b[0] = a[0] + first(); }}"
        )
    };
    let port = |name, access, optional| Port::new(name, access, U32, None, optional);
    let a = port("a", Access::Read, false);
    let x = port("x", Access::Read, true);
    let b = port("b", Access::Write, false);
    let check = |text: String, ports: &[Port], absent: &[Port]| {
        let wgsl = WgslSource {
            name: "optional",
            text: text.leak(),
            modules: &[],
            features: &[],
        };
        let kernel = KernelSource {
            wgsl,
            ..Good::kernel()
        };
        match Compiler::new().check("stage", &kernel, ports, absent) {
            Ok(()) => Vec::new(),
            Err(found) => found.iter().map(ToString::to_string).collect(),
        }
    };
    let all = [a.clone(), x.clone(), b.clone()];
    let without = [a, b];
    let conditional = text("@if(x)");
    assert_eq!(check(conditional.clone(), &all, &[]), Vec::<String>::new());
    let left_out = check(conditional.clone(), &without, std::slice::from_ref(&x));
    assert_eq!(left_out, Vec::<String>::new());
    // The gap is an optional port's only where there is one.
    let gap = check(conditional, &without, &[]);
    assert!(
        gap.len() == 1 && gap[0].contains("leave no gaps"),
        "{gap:#?}"
    );
    let always = check(
        text("").replace("@if(!x) fn first() -> u32 { return 0u; }", ""),
        &without,
        &[x],
    );
    assert!(
        always.len() == 1 && always[0].contains("put `@if(x)` before the global"),
        "{always:#?}"
    );
}
