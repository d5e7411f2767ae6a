use super::*;

const DOUBLE: &str = "import package::math::twice;
@group(0) @binding(0) var<storage, read> source: array<u32>;
@group(0) @binding(1) var<storage, read_write> target_: array<u32>;
@compute @workgroup_size(64, 2) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < arrayLength(&source) { target_[id.x] = twice(source[id.x]); }
}";
const MATH: &[(&str, &str)] = &[("math", "fn twice(x: u32) -> u32 {\n    return 2u * x;\n}\n")];

fn source(
    text: &'static str,
    modules: &'static [(&str, &str)],
    features: &'static [&'static str],
) -> WgslSource {
    WgslSource {
        name: "double",
        text,
        modules,
        features,
    }
}

fn error(text: &'static str) -> String {
    Compiler::new()
        .compile(&source(text, MATH, &[]), &[])
        .unwrap_err()
        .to_string()
}

#[test]
fn a_kernel_tells_its_text_bindings_and_size() {
    let kernel = Compiler::new()
        .compile(&source(DOUBLE, MATH, &[]), &[])
        .unwrap();
    assert!(kernel.wgsl().contains("fn twice"));
    assert!(!kernel.wgsl().contains("import"));
    assert_eq!(kernel.workgroup_size(), [64, 2, 1]);
    let bindings = ["source", "target_", "target", "other"].map(|port| kernel.binding(port));
    assert_eq!(bindings, [Some(0), Some(1), Some(1), None]);
}

/// wgpu numbers what it binds from 0, whatever its numbers in WGSL; where it is given SPIR-V, that has to do the same.
#[test]
fn bindings_of_spirv_have_no_gaps() {
    const DECORATE: u32 = 71;
    const BINDING: u32 = 33;
    let gaps = "@group(0) @binding(7) var<storage, read_write> target_: array<u32>;
@group(0) @binding(2) var<storage, read> source: array<u32>;
@group(0) @binding(11) var<uniform> scale: u32;
@compute @workgroup_size(1) fn main() { target_[0] = scale * source[0]; }";
    let kernel = Compiler::new()
        .compile(&source(gaps, &[], &[]), &[])
        .unwrap();
    let of = |port| (kernel.binding(port), kernel.spirv_binding(port));
    assert_eq!(of("source"), (Some(2), Some(0)));
    assert_eq!(of("target"), (Some(7), Some(1)));
    assert_eq!(of("scale"), (Some(11), Some(2)));
    assert_eq!(of("other"), (None, None));
    let words = kernel.spirv(SPIRV).unwrap();
    let code = instructions(&words);
    let decorated = code
        .iter()
        .filter(|(op, args)| *op == DECORATE && args[1] == BINDING);
    let mut bindings: Vec<_> = decorated.map(|(_, args)| args[2]).collect();
    bindings.sort_unstable();
    assert_eq!(bindings, [0, 1, 2]);
}

#[test]
fn what_is_compiled_is_remembered_by_text_and_features() {
    let compiler = Compiler::new();
    let first = compiler.compile(&source(DOUBLE, MATH, &[]), &[]).unwrap();
    let second = compiler.compile(&source(DOUBLE, MATH, &[]), &[]).unwrap();
    assert!(Arc::ptr_eq(&first.inner, &second.inner));
    let other = compiler
        .compile(&source(DOUBLE, MATH, &["F"]), &[])
        .unwrap();
    assert!(!Arc::ptr_eq(&first.inner, &other.inner));
    let other = compiler
        .compile(
            &source("@compute @workgroup_size(1) fn main() {}", MATH, &[]),
            &[],
        )
        .unwrap();
    assert_eq!(other.workgroup_size(), [1, 1, 1]);
}

/// Instructions of a SPIR-V module: opcode and operands.
fn instructions(words: &[u32]) -> Vec<(u32, &[u32])> {
    let mut found = Vec::new();
    let mut rest = &words[5..];
    while let [first, ..] = rest {
        let len = (first >> 16) as usize;
        found.push((first & 0xffff, &rest[1..len]));
        rest = &rest[len..];
    }
    found
}

#[test]
fn spirv_has_the_version_entry_point_and_bindings() {
    const ENTRY_POINT: u32 = 15;
    const EXECUTION_MODE: u32 = 16;
    const DECORATE: u32 = 71;
    let kernel = Compiler::new()
        .compile(&source(DOUBLE, MATH, &[]), &[])
        .unwrap();
    for version in [(1, 3), (1, 4), (1, 6)] {
        let words = kernel.spirv(version).unwrap();
        assert_eq!(words[0], 0x0723_0203);
        assert_eq!(
            words[1],
            u32::from(version.0) << 16 | u32::from(version.1) << 8
        );
        let code = instructions(&words);
        let entries: Vec<_> = code.iter().filter(|(op, _)| *op == ENTRY_POINT).collect();
        assert_eq!(entries.len(), 1);
        // GLCompute, then the id, then the name.
        assert_eq!(
            (entries[0].1[0], entries[0].1[2]),
            (5, u32::from_le_bytes(*b"main"))
        );
        let size = code
            .iter()
            .find(|(op, args)| *op == EXECUTION_MODE && args[1] == 17)
            .unwrap();
        assert_eq!(size.1[2..], [64, 2, 1]);
        let decorations = |kind: u32| -> Vec<(u32, u32)> {
            let all = code
                .iter()
                .filter(|(op, args)| *op == DECORATE && args[1] == kind);
            all.map(|(_, args)| (args[0], args[2])).collect()
        };
        let (bindings, sets) = (decorations(33), decorations(34));
        assert_eq!(bindings.iter().map(|b| b.1).collect::<Vec<_>>(), [0, 1]);
        assert_eq!(sets.iter().map(|s| s.1).collect::<Vec<_>>(), [0, 0]);
        assert_eq!(
            bindings.iter().map(|b| b.0).collect::<Vec<_>>(),
            sets.iter().map(|s| s.0).collect::<Vec<_>>()
        );
    }
}

#[test]
fn overrides_take_their_defaults() {
    let text = "override size = 32;\n@compute @workgroup_size(size * 2) fn main() {}";
    let kernel = Compiler::new()
        .compile(&source(text, &[], &[]), &[])
        .unwrap();
    assert_eq!(kernel.workgroup_size(), [64, 1, 1]);
    assert!(kernel.spirv((1, 4)).is_ok());
    let error = error("override size: u32;\n@compute @workgroup_size(size) fn main() {}");
    assert!(
        error.contains("give every `override` a default value"),
        "{error}"
    );
}

/// naga's bounds checks that clamp coordinates make vectors of unsigned integers from signed ones.
#[test]
fn constant_vectors_are_of_their_parts() {
    const VECTOR: u32 = 23;
    const CONSTANT: u32 = 43;
    const COMPOSITE: u32 = 44;
    let load = "@group(0) @binding(0) var seen: texture_2d<f32>;
@group(0) @binding(1) var shown: texture_storage_2d<rgba16float, write>;
@compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) at: vec3<u32>) {
    textureStore(shown, at.xy, textureLoad(seen, at.xy, 0) + textureLoad(seen, vec2<i32>(at.yx), 0));
}";
    let kernel = Compiler::new()
        .compile(&source(load, &[], &[]), &[])
        .unwrap();
    let words = kernel.spirv((1, 4)).unwrap();
    let code = instructions(&words);
    let of = |kind: u32| code.iter().filter(move |(op, _)| *op == kind);
    for (_, composite) in of(COMPOSITE) {
        let Some((_, vector)) = of(VECTOR).find(|(_, args)| args[0] == composite[0]) else {
            continue;
        };
        for part in &composite[2..] {
            let constant = of(CONSTANT).find(|(_, args)| args[1] == *part);
            assert!(constant.is_none_or(|(_, args)| args[0] == vector[1]));
        }
    }
}

#[test]
fn features_ask_for_more_than_webgpu() {
    const RAYS: &str = "@if(RAY_QUERY) enable wgpu_ray_query;
@if(RAY_QUERY) @group(0) @binding(0) var scene: acceleration_structure;
@if(RAY_QUERY) @compute @workgroup_size(1) fn main() {
    var query: ray_query;
    rayQueryInitialize(&query, scene, RayDesc(0u, 0xffu, 0.0, 1.0, vec3<f32>(), vec3<f32>(1.0)));
    while rayQueryProceed(&query) {}
}
@else @compute @workgroup_size(1) fn main() {}";
    let compiler = Compiler::new();
    assert_eq!(
        compiler
            .compile(&source(RAYS, &[], &[]), &[])
            .unwrap()
            .binding("scene"),
        None
    );
    let kernel = compiler
        .compile(&source(RAYS, &[], &["RAY_QUERY"]), &[])
        .unwrap();
    assert_eq!(kernel.binding("scene"), Some(0));
    assert!(kernel.spirv((1, 4)).is_ok());
    let always = "enable wgpu_ray_query;\n@group(0) @binding(0) var scene: acceleration_structure;
@compute @workgroup_size(1) fn main() { _ = &scene; }";
    assert!(compiler.compile(&source(always, &[], &[]), &[]).is_err());
    let half = "enable f16;\n@compute @workgroup_size(1) fn main() { var x = 1h; }";
    assert!(compiler.compile(&source(half, &[], &[]), &[]).is_err());
    assert!(compiler.compile(&source(half, &[], &["F16"]), &[]).is_ok());
    let group =
        "enable subgroups;\n@compute @workgroup_size(1) fn main() { var x = subgroupAdd(1u); }";
    assert!(compiler.compile(&source(group, &[], &[]), &[]).is_err());
    assert!(
        compiler
            .compile(&source(group, &[], &["SUBGROUPS"]), &[])
            .is_ok()
    );
    let pack = "@compute @workgroup_size(1) fn main() { var x = pack2x16float(vec2<f32>(1.0)); }";
    assert!(compiler.compile(&source(pack, &[], &[]), &[]).is_ok());
}

#[test]
fn errors_of_naga_name_the_original_file() {
    let in_root = error("import package::math::twice;\n\nfn main() {\n    let x = twice(1.5);\n}");
    assert!(
        in_root.starts_with("double: double.wgsl:4:19: "),
        "{in_root}"
    );
    assert!(in_root.contains("4 |     let x = twice(1.5);"), "{in_root}");
    const BROKEN: &[(&str, &str)] =
        &[("deep::broken", "// x\nfn f() -> u32 {\n    return 1u +;\n}")];
    let text =
        "import package::deep::broken::f;\n@compute @workgroup_size(1) fn main() { _ = f(); }";
    let in_module = Compiler::new()
        .compile(&source(text, BROKEN, &[]), &[])
        .unwrap_err()
        .to_string();
    assert!(
        in_module.starts_with("double: deep/broken.wgsl:3:16: "),
        "{in_module}"
    );
    let invalid = error(
        "var<workgroup> a: u32;\n@compute @workgroup_size(1) fn main() {\n    loop { workgroupBarrier(); continuing { return; } }\n}",
    );
    assert!(invalid.contains("double.wgsl:3:"), "{invalid}");
    let unknown = error("  enable nonsense;\n@compute @workgroup_size(1) fn main() {}");
    assert!(
        unknown.starts_with("double: double.wgsl:1:10: "),
        "{unknown}"
    );
    let imports = error("import package::math::thrice;\nfn main() {}");
    assert!(imports.starts_with("double.wgsl:1:23: "), "{imports}");
}

#[test]
fn validation_errors_name_place_and_cause() {
    let error = error(
        "@group(0) @binding(0) var<uniform> u: array<f32, 4>;\n@compute @workgroup_size(1) fn main() {\n    _ = u[0];\n}",
    );
    assert!(error.starts_with("double: double.wgsl:1:"), "{error}");
    assert!(error.contains("note: "), "{error}");
}

#[test]
fn there_is_one_entry_point() {
    let none = error("fn f() {}");
    assert!(none.contains("found none"), "{none}");
    let two = error(
        "@compute @workgroup_size(1) fn main() {}\n@compute @workgroup_size(1) fn other() {}",
    );
    assert!(two.contains("found main, other"), "{two}");
    let name = error("@compute @workgroup_size(1) fn start() {}");
    assert!(name.contains("found start"), "{name}");
}
