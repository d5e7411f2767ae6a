use super::*;

fn run(
    root: &str,
    modules: &[(&str, &str)],
    features: &[&str],
    target: Target,
) -> Result<Composed, ComposeError> {
    let modules: Vec<File<'_>> = modules
        .iter()
        .map(|(path, text)| File::new(path, text))
        .collect();
    compose(&File::new("root", root), &modules, features, target)
}

fn text(root: &str, modules: &[(&str, &str)], features: &[&str]) -> String {
    run(root, modules, features, Target::Naga)
        .unwrap()
        .text()
        .to_owned()
}

/// The error, as `file:line:column` and message.
fn error(root: &str, modules: &[(&str, &str)]) -> (String, String) {
    let error = run(root, modules, &[], Target::Naga).unwrap_err();
    (error.place.to_string(), error.problem.to_string())
}

#[test]
fn a_module_comes_once_and_before_its_users() {
    let modules = [
        ("a", "import package::deep::c::c;\nfn a() { c(); }"),
        (
            "b",
            "import package::{a::a, deep::{c::c}};\nfn b() { a(); c(); }",
        ),
        ("deep::c", "fn c() {}"),
        ("unused", "fn unused( {"),
    ];
    let root = "import package::b::{b,};\nimport package::a::a;\nfn main() { a(); b(); }";
    let expected = "// deep/c.wgsl\nfn c() {}\n// a.wgsl\nfn a() { c(); }\n// b.wgsl\nfn b() { a(); c(); }\n\
                    // root.wgsl\nfn main() { a(); b(); }\n";
    assert_eq!(text(root, &modules, &[]), expected);
}

#[test]
fn conditions_choose_declarations_and_imports() {
    let modules = [("soft", "fn trace() {}"), ("hard", "fn trace() {}")];
    let root = "@if(RAY_QUERY) import package::hard::trace;\n@else import package::soft::trace;\n\
                @if(A && !B) const which = 1;\n@elif(A || C) const which = 2;\n@else const which = 3;\n\
                fn main() { trace(); }";
    let of = |features: &[&str]| {
        let text = text(root, &modules, features);
        let module = ["soft", "hard"]
            .into_iter()
            .filter(|m| text.contains(&format!("// {m}.wgsl")))
            .collect::<Vec<_>>();
        let which = (1..=3)
            .filter(|n| text.contains(&format!("which = {n};")))
            .collect::<Vec<_>>();
        assert!(!text.contains('@'), "{text}");
        (module, which)
    };
    assert_eq!(of(&[]), (vec!["soft"], vec![3]));
    assert_eq!(of(&["RAY_QUERY", "A"]), (vec!["hard"], vec![1]));
    assert_eq!(of(&["A", "B"]), (vec!["soft"], vec![2]));
    assert_eq!(of(&["C"]), (vec!["soft"], vec![2]));
    let features = run(root, &modules, &[], Target::Naga).unwrap();
    assert_eq!(
        features.features().collect::<Vec<_>>(),
        ["A", "B", "C", "RAY_QUERY"]
    );
}

#[test]
fn a_condition_may_stand_among_other_attributes() {
    let root = "@group(0) @if(!(A && true) || false) @binding(0) var<storage, read> x: array<u32>;";
    assert_eq!(
        text(root, &[], &[])
            .lines()
            .nth(1)
            .unwrap()
            .split_whitespace()
            .collect::<Vec<_>>()
            .join(" "),
        "@group(0) @binding(0) var<storage, read> x: array<u32>;"
    );
    assert_eq!(text(root, &[], &["A"]), "// root.wgsl\n");
}

#[test]
fn directives_are_hoisted_once_and_chosen_by_target() {
    let modules = [(
        "m",
        "enable f16, subgroups;\nenable wgpu_ray_query;\nfn m() {}",
    )];
    let root = "enable subgroups;\nimport package::m::m;\ndiagnostic(off, derivative_uniformity);\nenable f16;\n\
                @if(X) enable never;\nfn main() { m(); }";
    let directives = |target| {
        let composed = run(root, &modules, &[], target).unwrap();
        let lines = composed
            .text()
            .lines()
            .take_while(|l| !l.starts_with("//"))
            .map(str::to_owned);
        let lines: Vec<String> = lines.collect();
        assert_eq!(composed.text().matches("enable").count(), lines.len() - 1);
        lines
    };
    assert_eq!(
        directives(Target::Naga),
        [
            "enable f16;",
            "enable wgpu_ray_query;",
            "diagnostic(off,derivative_uniformity);"
        ]
    );
    assert_eq!(
        directives(Target::Browser),
        [
            "enable f16;",
            "enable subgroups;",
            "diagnostic(off,derivative_uniformity);"
        ]
    );
}

#[test]
fn comments_hide_what_they_hold() {
    let root = "/* import package::no::no; /* } */ @if(X) */ // import package::no::no;\n\
                fn main() { // }\n /* } /* */ */ let x = 1u; }\nconst y = 2; // @else\n";
    assert!(text(root, &[], &[]).ends_with("const y = 2; // @else\n"));
}

#[test]
fn lines_and_columns_lead_back_to_the_file() {
    let module = "// about\n\n@if(OFF)\nfn off() {}\n@else fn on() { oops; }\n";
    let root = "import package::m::on;\r\n\r\n\r\nfn main() { on(); ä; wrong; }";
    let composed = run(root, &[("m", module)], &[], Target::Naga).unwrap();
    let place = |word: &str| composed.place(composed.text().find(word).unwrap());
    assert_eq!(place("oops").to_string(), "m.wgsl:5:17");
    assert_eq!(place("wrong").to_string(), "root.wgsl:4:22");
    assert_eq!(place("// root").to_string(), "root.wgsl:1:1");
    assert_eq!(composed.place(usize::MAX).line, 4);
    assert_eq!(
        place("wrong").snippet(),
        format!(
            "  4 | fn main() {{ on(); ä; wrong; }}\n    | {}^",
            " ".repeat(21)
        )
    );
    let composed = run("\n  enable f16, nonsense;", &[], &[], Target::Naga).unwrap();
    assert_eq!(
        composed
            .place(composed.text().find("nonsense").unwrap())
            .to_string(),
        "root.wgsl:2:15"
    );
}

#[test]
fn a_module_may_use_what_the_root_declares() {
    let modules = [("trace", "fn trace() -> u32 { return nodes[0]; }")];
    let root = "import package::trace::trace;\nvar<private> nodes: array<u32, 4>;\nfn main() { let x = trace(); }";
    assert!(run(root, &modules, &[], Target::Naga).is_ok());
}

#[test]
fn names_that_mean_something_else_need_no_import() {
    let modules = [(
        "m",
        "fn hash() {}\nfn m() {}\nfn read() {}\nfn local_invocation_id() {}",
    )];
    let root = "import package::m::m;\nstruct S { hash: u32 }\nvar<storage, read> x: S;\n\
                fn main(@builtin(local_invocation_id) id: vec3<u32>, s: S) { let hash = s.hash; m(); let y = hash; }";
    assert!(run(root, &modules, &[], Target::Naga).is_ok());
}

#[test]
fn a_module_may_have_the_name_of_the_root() {
    let modules = [("root", "fn f() {}")];
    assert!(
        run(
            "import package::root::f;\nfn main() { f(); }",
            &modules,
            &[],
            Target::Naga
        )
        .is_ok()
    );
}

#[test]
fn every_error_says_where_and_what() {
    let m: &[(&str, &str)] = &[
        ("m", "fn f() {}\nfn g() {}"),
        ("deep::n", "fn f() {}\n@if(X) fn h() {}"),
    ];
    let cases: &[(&str, &str, &str)] = &[
        (
            "fn main() {}\n /* a /* b */",
            "root.wgsl:2:2",
            "never closed",
        ),
        ("fn main() { (", "root.wgsl:1:11", "`{` is never closed"),
        (
            "fn main",
            "root.wgsl:1:8",
            "expected `{`, found the end of the file",
        ),
        ("fn main() }", "root.wgsl:1:11", "expected `{`, found `}`"),
        (
            "let x = 1;",
            "root.wgsl:1:1",
            "expected an import, a directive or a declaration, found `let`",
        ),
        ("var<private x", "root.wgsl:1:14", "expected `>`"),
        ("const x = (1]; const", "root.wgsl:1:21", "expected a name"),
        ("const x = 1 }", "root.wgsl:1:13", "expected `;`"),
        ("@group(0)", "root.wgsl:1:10", "expected an import"),
        (
            "fn main() {}\nimport package::m::f;",
            "root.wgsl:2:1",
            "`import` must stand at the top",
        ),
        (
            "const a = 1;\nenable f16;",
            "root.wgsl:2:1",
            "`enable` must stand at the top",
        ),
        (
            "import super::m::f;",
            "root.wgsl:1:8",
            "starts with `package::`, not with `super`",
        ),
        (
            "import package::m::f as k;",
            "root.wgsl:1:22",
            "remove `as`",
        ),
        (
            "import package::m::*;",
            "root.wgsl:1:20",
            "write `import package::module::{a, b};`",
        ),
        (
            "import package::m;",
            "root.wgsl:1:17",
            "`package::m` is a module; name what you need",
        ),
        (
            "import package::deep::n;",
            "root.wgsl:1:23",
            "`package::deep::n` is a module",
        ),
        (
            "import package::m::{f g};",
            "root.wgsl:1:23",
            "expected `,` or `}`, found `g`",
        ),
        (
            "import package::m::f fn",
            "root.wgsl:1:22",
            "expected `::` or `;`, found `fn`",
        ),
        (
            "import package::k::f;",
            "root.wgsl:1:20",
            "no module `package::k`; there are m, deep::n",
        ),
        (
            "import package::m::k;",
            "root.wgsl:1:20",
            "`package::m` declares no `k`; it declares f, g",
        ),
        (
            "import package::deep::n::h;",
            "root.wgsl:1:26",
            "declares no `h`; it declares f",
        ),
        (
            "import package::m::f;\nfn f() {}",
            "root.wgsl:2:4",
            "`f` is also declared at m.wgsl:1:4",
        ),
        (
            "import package::{m::f, deep::n::f};",
            "deep/n.wgsl:1:4",
            "also declared at m.wgsl:1:4",
        ),
        (
            "struct a {}\nalias a = u32;",
            "root.wgsl:2:7",
            "also declared at root.wgsl:1:8",
        ),
        (
            "import package::m::f;\nfn main() { g(); }",
            "root.wgsl:2:13",
            "add `import package::m::g;`",
        ),
        ("@else fn main() {}", "root.wgsl:1:1", "`@else` must follow"),
        (
            "@if(A) fn a() {}\nfn b() {}\n@elif(B) fn c() {}",
            "root.wgsl:3:1",
            "`@elif` must follow",
        ),
        (
            "@if(A) fn a() {}\n@else fn b() {}\n@else fn c() {}",
            "root.wgsl:3:1",
            "`@else` must follow",
        ),
        (
            "@if(A) @if(B) fn a() {}",
            "root.wgsl:1:9",
            "join them with `&&`",
        ),
        (
            "fn a() { @if(A) { } }",
            "root.wgsl:1:10",
            "`@if` is allowed before",
        ),
        (
            "struct A { @else a: u32 }",
            "root.wgsl:1:12",
            "`@else` is allowed before",
        ),
        (
            "@if A fn a() {}",
            "root.wgsl:1:5",
            "expected `(` and a condition",
        ),
        (
            "@if(A & B) fn a() {}",
            "root.wgsl:1:7",
            "expected `&&`, `||` or `)`, found `&`",
        ),
        ("@if() fn a() {}", "root.wgsl:1:5", "expected a feature"),
    ];
    for (root, place, message) in cases {
        let (at, what) = error(root, m);
        assert_eq!(at, *place, "{root}: {what}");
        assert!(what.contains(message), "{root}: {what}");
    }
}

#[test]
fn a_circle_names_its_files() {
    let modules = [
        ("a", "import package::b::b;\nfn a() {}"),
        ("b", "import package::a::a;\nfn b() {}"),
    ];
    let (place, message) = error("import package::a::a;\nfn main() {}", &modules);
    assert_eq!(place, "b.wgsl:1:20");
    assert!(message.ends_with("a.wgsl -> b.wgsl -> a.wgsl"), "{message}");
}

#[test]
fn an_error_shows_the_line() {
    let error = run("import package::m;", &[], &[], Target::Naga)
        .unwrap_err()
        .to_string();
    assert!(error.starts_with("root.wgsl:1:17: "), "{error}");
    assert!(
        error.ends_with("\n  1 | import package::m;\n    |                 ^"),
        "{error}"
    );
}

/// Any cut of a file is an error or composes; nothing panics and places stay within the file.
#[test]
fn cut_files_do_not_panic() {
    let whole = "enable f16, x;\n@if(A && (!B || true)) import package::{m::{f, g}, deep::n::h};\n/* ä /* */ */\n\
                 @else import package::m::f;\n@group(0) @binding(0) var<storage, read> b: array<u32>;\n\
                 fn main(@builtin(x) id: u32) -> u32 { return b[id] << 1u; } // end\nconst_assert true;;\n";
    let modules = [("m", "fn f() {}\nfn g() {}")];
    for end in (0..=whole.len()).filter(|end| whole.is_char_boundary(*end)) {
        for start in [0, 15, 40, 90].into_iter().filter(|start| *start <= end) {
            let Some(part) = whole.get(start..end) else {
                continue;
            };
            if let Err(error) = run(part, &modules, &[], Target::Naga) {
                assert!(
                    error.place.line <= part.lines().count().max(1) as u32 + 1,
                    "{part}: {error}"
                );
            }
        }
    }
    let deep = format!("@if({}A", "(!".repeat(100_000));
    assert!(run(&deep, &[], &[], Target::Naga).is_err());
    let deep = format!("import package::a::{}", "{".repeat(100_000));
    assert!(run(&deep, &[], &[], Target::Naga).is_err());
}
