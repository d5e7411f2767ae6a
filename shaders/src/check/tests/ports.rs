//! Single globals against single ports: buffers, images, and ports that are optional.
use super::{Good, check};
use crate::Compiler;
use gibs_graph::{
    Access, ImageFormat, KernelSource, Layout, Port, Scalar, ShaderCompiler, Stage, WgslSource,
};

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
