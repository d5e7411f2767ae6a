//! Composition of modules that are sound: what comes out is sound WGSL.
use crate::watch::{cases, watched};
use gibs::shaders::compose::{File, Target, compose};
use naga::valid::{Capabilities, ValidationFlags, Validator};
use proptest::collection::vec;
use proptest::prelude::*;
use std::fmt::Write;

/// Features that conditions name.
const FEATURES: [&str; 3] = ["A", "B", "C"];

/// A declaration: what it is, whether it hangs on a condition, and picks of what it uses.
type Declaration = (u8, u8, [u8; 2]);

/// Declares `name`, whose value is a `u32` however the conditions come out. `uses` are names of the same kind.
fn declare(out: &mut String, name: &str, (kind, condition, picks): Declaration, uses: &[String]) {
    let value = |i: usize| match uses.get(usize::from(picks[i]) % (uses.len() + 1)) {
        Some(used) => format!("{used}(x)"),
        None => format!("{}u", picks[i]),
    };
    let (a, b) = (value(0), value(1));
    let body = |value: &str| match kind % 4 {
        0 => format!("fn {name}(x: u32) -> u32 {{ return {value} + x; }}"),
        // Locals, blocks and comments that look like something else.
        1 => format!(
            "fn {name}(x: u32) -> u32 {{ var y = {value}; /* }} @if(A) /* {{ */ */ {{ y += x; }} // import {{\n return y; }}"
        ),
        2 => format!(
            "fn {name}(x: u32) -> u32 {{ if x > 3u {{ return {value}; }} else {{ return x; }} }}"
        ),
        _ => format!(
            "@must_use /* fn */ fn {name}(x: u32) -> u32 {{ let s = vec2<u32>({value}, x); return s.x + s.y; }}"
        ),
    };
    let feature = FEATURES[usize::from(condition / 8) % 3];
    let chain = match condition % 8 {
        0 => format!("@if({feature}) {}\n@else {}", body(&a), body(&b)),
        1 => format!(
            "@if(!{feature} && true)\n{}\n@elif(false) fn {name}() {{}}\n@else {}",
            body(&a),
            body(&b)
        ),
        2 => format!(
            "@if({feature} || (A && !B)) {} @elif({feature}) fn {name}() {{}} @else {}",
            body(&a),
            body(&b)
        ),
        3 => format!("@if(false) const {name} = 1;\n{}", body(&a)),
        _ => body(&a),
    };
    writeln!(out, "{chain}").expect("memory takes it");
}

/// Imports of `names` out of modules `m0`, `m1::inner` and so on, in one of their spellings.
fn imports(out: &mut String, names: &[(usize, String)], spelling: u8) {
    let path = |module: usize| {
        if module.is_multiple_of(2) {
            format!("m{module}")
        } else {
            format!("m{module}::inner")
        }
    };
    match spelling % 3 {
        0 => names.iter().for_each(|(module, name)| {
            writeln!(out, "import package::{}::{name};", path(*module)).expect("memory takes it");
        }),
        1 if !names.is_empty() => {
            let list: Vec<String> = names
                .iter()
                .map(|(module, name)| format!("{}::{name}", path(*module)))
                .collect();
            writeln!(out, "import package::{{ {} }};", list.join(", ")).expect("memory takes it");
        }
        _ => names.iter().for_each(|(module, name)| {
            writeln!(
                out,
                "@if(true) import package::{}::{{{name},}}; // {name}",
                path(*module)
            )
            .expect("memory takes it");
        }),
    }
}

proptest! {
    #![proptest_config(cases(500))]

    #[test]
    fn sound_modules_compose_to_sound_wgsl(
        modules in vec((vec(any::<Declaration>(), 1..4), vec((any::<u8>(), any::<u8>()), 0..4), any::<u8>()), 1..6),
        features in [any::<bool>(), any::<bool>(), any::<bool>()],
        enables in any::<u8>(),
    ) {
        let mut declared: Vec<Vec<String>> = Vec::new();
        let mut texts = Vec::new();
        for (m, (declarations, picks, spelling)) in modules.iter().enumerate() {
            let mut used: Vec<(usize, String)> = picks
                .iter()
                .filter(|_| m > 0)
                .map(|(module, name)| {
                    let module = usize::from(*module) % m;
                    let names = &declared[module];
                    (module, names[usize::from(*name) % names.len()].clone())
                })
                .collect();
            used.sort();
            used.dedup();
            let mut text = String::new();
            if (enables >> (m % 8)) & 1 == 1 {
                text += "enable subgroups;\n@if(A) requires readonly_and_readwrite_storage_textures;\n";
            }
            imports(&mut text, &used, *spelling);
            let mut known: Vec<String> = used.into_iter().map(|(_, name)| name).collect();
            let mut here = Vec::new();
            for (d, declaration) in declarations.iter().enumerate() {
                let name = format!("f{m}_{d}");
                declare(&mut text, &name, *declaration, &known);
                known.push(name.clone());
                here.push(name);
            }
            declared.push(here);
            texts.push(text);
        }
        let last = texts.len() - 1;
        let call = declared[last].last().expect("it declares something").clone();
        texts[last] += &format!(
            "@group(0) @binding(0) var<storage, read_write> out: array<u32>;\n\
             @compute @workgroup_size(1) fn main() {{ out[0] = {call}(1u); }}\n"
        );
        let path = |m: usize| if m.is_multiple_of(2) { format!("m{m}") } else { format!("m{m}::inner") };
        let paths: Vec<String> = (0..last).map(path).collect();
        let files: Vec<File<'_>> = paths.iter().zip(&texts).map(|(path, text)| File::new(path, text)).collect();
        let given: Vec<&str> = FEATURES.into_iter().zip(features).filter(|(_, on)| *on).map(|(name, _)| name).collect();
        watched(|| {
            let made = compose(&File::new("root", &texts[last]), &files, &given, Target::Naga);
            let made = made.unwrap_or_else(|e| panic!("{e}\n{}", texts.join("\n----\n")));
            let text = made.text();
            let module = naga::front::wgsl::parse_str(text);
            let module = module.unwrap_or_else(|e| panic!("{}\n{}", e.emit_to_string(text), texts.join("\n----\n")));
            let mut validator = Validator::new(ValidationFlags::all(), Capabilities::all());
            let valid = validator.validate(&module);
            prop_assert!(valid.is_ok(), "{:?}\n{}", valid.err(), text);
            prop_assert_eq!(module.entry_points.len(), 1);
            // What is composed is plain: composing it again changes nothing but the heads of files.
            let again = compose(&File::new("root", text), &[], &[], Target::Naga).expect("it is plain");
            prop_assert!(again.text().contains("fn main()"));
            prop_assert_eq!(again.features().count(), 0);
            Ok(())
        })?;
    }
}
