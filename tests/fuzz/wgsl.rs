//! Composition of WGSL: sources of any kind.
use crate::edits::{byte_edits, edit_bytes};
use crate::watch::{cases, watched};
use gibs::shaders::compose::{File, Target, compose};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;

/// Pieces that files are made of; some open what nothing closes.
const PIECES: &[&str] = &[
    "import",
    "package",
    "::",
    "a",
    "b",
    "c::d",
    "{",
    "}",
    "(",
    ")",
    "[",
    "]",
    ",",
    ";",
    "*",
    "as",
    "@",
    "@if",
    "@elif",
    "@else",
    "@if(A)",
    "@elif(!B)",
    "@if(A && B || !(C))",
    "@if(true)",
    "@if((((",
    "!!!!",
    "&&",
    "||",
    "A",
    "B",
    "fn",
    "fn f() {}",
    "fn g(x: u32) -> u32 { return x; }",
    "struct S { x: u32 }",
    "const c = 1u;",
    "override o: u32;",
    "alias T = u32;",
    "var<private> v: u32;",
    "var<",
    ">",
    "=",
    "enable f16;",
    "enable subgroups, f16;",
    "requires x;",
    "diagnostic(off, derivative_uniformity);",
    "const_assert true;",
    "/*",
    "*/",
    "/**/",
    "/* /* */",
    "//",
    "\n",
    "\r",
    "\u{2028}",
    "\u{85}",
    "\t",
    "import package::a::f;",
    "import package::b::{S, g};",
    "import package::c::d::{c, v,};",
    "import package::{a::f, b::{g}};",
    "import other::x;",
    "@must_use",
    "@group(0)",
    "\"",
    "'",
    "0x1fu",
    "1e5",
    "\u{0}",
    "é",
    "𝕏",
    "\u{feff}",
    "_",
    "main",
    "@compute @workgroup_size(1) fn main() {}",
];

fn source() -> impl Strategy<Value = String> {
    let piece = prop_oneof![20 => select(PIECES).prop_map(str::to_owned), 1 => "\\PC{0,6}", 1 => any::<char>().prop_map(String::from)];
    vec((piece, any::<bool>()), 0..40).prop_map(|pieces| {
        pieces
            .into_iter()
            .map(|(piece, space)| if space { piece + " " } else { piece })
            .collect()
    })
}

fn features() -> impl Strategy<Value = Vec<&'static str>> {
    vec(select(vec!["A", "B", "C", ""]), 0..3)
}

/// Composes; every place that is asked for is one of a file, and so is that of an error.
fn composed(root: &str, modules: &[&str; 3], features: &[&str], target: Target) {
    let paths = ["a", "b", "c::d"];
    let modules: Vec<File<'_>> = paths
        .iter()
        .zip(modules)
        .map(|(path, text)| File::new(path, text))
        .collect();
    match compose(&File::new("root", root), &modules, features, target) {
        Ok(made) => {
            let text = made.text();
            for offset in
                (0..text.len())
                    .step_by(7)
                    .chain([0, text.len(), text.len() + 1, usize::MAX])
            {
                let place = made.place(offset);
                assert!(place.line >= 1 && place.column >= 1);
                assert!(!place.snippet().is_empty());
            }
            assert!(made.features().all(|feature| !feature.is_empty()));
        }
        Err(error) => {
            let text = error.to_string();
            assert!(text.contains(".wgsl:"), "{text}");
        }
    }
}

proptest! {
    #![proptest_config(cases(4000))]

    #[test]
    fn any_source_is_composed_or_refused(
        root in source(),
        modules in [source(), source(), source()],
        features in features(),
        browser: bool,
    ) {
        let target = if browser { Target::Browser } else { Target::Naga };
        watched(|| composed(&root, &modules.each_ref().map(String::as_str), &features, target));
    }

    #[test]
    fn a_damaged_kernel_is_composed_or_refused(which: prop::sample::Index, edits in byte_edits()) {
        let stages = gibs::passes::stages::all();
        let wgsl = which.get(&stages).kernel.wgsl;
        let mut bytes = wgsl.text.as_bytes().to_vec();
        edit_bytes(&mut bytes, &edits);
        let text = String::from_utf8_lossy(&bytes);
        let modules: Vec<File<'_>> = wgsl.modules.iter().map(|(path, text)| File::new(path, text)).collect();
        watched(|| {
            if let Err(error) = compose(&File::new(wgsl.name, &text), &modules, wgsl.features, Target::Naga) {
                prop_assert!(error.to_string().contains(".wgsl:"));
            }
            Ok(())
        })?;
    }
}

/// Operands of `&&` and `||` nest no deeper than their parentheses, however many there are.
#[test]
fn a_condition_of_a_million_features_is_read() {
    for operator in [" && ", " || "] {
        let condition = vec!["A"; 1_000_000].join(operator);
        let text = format!("@if({condition}) const a = 1u;\nconst b = 2u;");
        let made =
            compose(&File::new("root", &text), &[], &["A"], Target::Naga).expect("it is sound");
        assert!(made.text().contains("const a"));
        assert_eq!(made.features().collect::<Vec<_>>(), ["A"]);
    }
}

#[test]
fn deep_nesting_is_refused() {
    let deep = |open: &str| open.repeat(100_000);
    for text in [
        format!("@if({}A) const a = 1u;", deep("(")),
        format!("@if({}A) const a = 1u;", deep("!")),
        format!("import package::{}", deep("{")),
        format!("import package::{}", deep("{a::")),
    ] {
        let error =
            compose(&File::new("root", &text), &[], &[], Target::Naga).expect_err("it is too deep");
        assert!(
            error.to_string().contains("less nesting"),
            "{}",
            error.problem
        );
    }
    // Bodies are only counted, so these may be as deep as they like.
    let text = format!("fn f() {{ {}{} }}", deep("{"), "}".repeat(100_000));
    compose(&File::new("root", &text), &[], &[], Target::Naga).expect("it is sound");
}
