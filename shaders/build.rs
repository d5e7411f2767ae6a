//! Finds the kernels and modules, validates them, and writes the constants that name them.
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

#[path = "src/compose/mod.rs"]
#[allow(dead_code, reason = "the build script needs a part of it")]
mod compose;
#[path = "src/validate.rs"]
#[allow(dead_code, reason = "the build script needs a part of it")]
mod validate;

/// A WGSL file of this crate.
struct Source {
    /// Path as imports write it, without `package::`.
    path: String,
    /// Path relative to the crate, with `/`.
    file: String,
    text: String,
}

fn main() {
    for input in [
        "stages",
        "modules",
        "src/compose",
        "src/validate.rs",
        "build.rs",
    ] {
        println!("cargo::rerun-if-changed={input}");
    }
    if let Err(problems) = build() {
        for line in problems.iter().flat_map(|p| p.lines()) {
            println!("cargo::error={line}");
        }
    }
}

fn build() -> Result<(), Vec<String>> {
    let stages = find("stages").map_err(|e| vec![e])?;
    let modules = find("modules").map_err(|e| vec![e])?;
    let files: Vec<compose::File<'_>> = modules.iter().map(Source::file).collect();
    let mut problems: Vec<String> = stages
        .iter()
        .chain(&modules)
        .filter_map(name_problem)
        .collect();
    for stage in &stages {
        if stage.path.contains("::") {
            problems.push(format!(
                "shaders/{}: stages lie in `stages/` itself, not in a folder of it",
                stage.file
            ));
        }
        problems.extend(validate_variants(&stage.file(), &files).err());
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    let out = env::var_os("OUT_DIR").ok_or_else(|| vec!["cargo sets no OUT_DIR".to_owned()])?;
    let out = Path::new(&out).join("kernels.rs");
    fs::write(&out, constants(&stages, &modules))
        .map_err(|e| vec![format!("{}: {e}", out.display())])
}

impl Source {
    fn file(&self) -> compose::File<'_> {
        compose::File {
            path: &self.path,
            name: format!("shaders/{}", self.file).into(),
            text: &self.text,
        }
    }
}

/// Validates a stage without features, and once with each feature that it or what it imports mentions.
fn validate_variants(
    stage: &compose::File<'_>,
    modules: &[compose::File<'_>],
) -> Result<(), String> {
    let mut known = vec![None];
    let mut next = 0;
    while let Some(feature) = known.get(next).cloned() {
        let features: Vec<&str> = feature.as_deref().into_iter().collect();
        let context = |e: &dyn std::fmt::Display| match &feature {
            Some(feature) => format!("{e}\n  (with feature {feature})"),
            None => e.to_string(),
        };
        let target = compose::Target::Naga;
        let composed =
            compose::compose(stage, modules, &features, target).map_err(|e| context(&e))?;
        validate::validate(&composed, validate::capabilities(&features)).map_err(|e| {
            let file = if e.place.is_none() {
                format!("{}: ", stage.name)
            } else {
                String::new()
            };
            format!("{file}{}", context(&e))
        })?;
        for feature in composed.features().map(|f| Some(f.to_owned())) {
            if !known.contains(&feature) {
                known.push(feature);
            }
        }
        next += 1;
    }
    Ok(())
}

fn name_problem(source: &Source) -> Option<String> {
    let fits = |part: &str| {
        part.starts_with(|c: char| c.is_ascii_lowercase())
            && part
                .chars()
                .all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
    };
    let bad = source.path.split("::").find(|part| !fits(part))?;
    Some(format!(
        "shaders/{}: the name `{bad}` must start with a small letter and have only those, digits and `_`",
        source.file
    ))
}

/// All `.wgsl` files below a folder, sorted. A folder that does not exist has none.
fn find(folder: &str) -> Result<Vec<Source>, String> {
    let mut files = Vec::new();
    collect(Path::new(folder), &mut files).map_err(|e| format!("shaders/{folder}: {e}"))?;
    files.sort();
    files
        .into_iter()
        .map(|file| {
            let text = fs::read_to_string(&file)
                .map_err(|e| format!("shaders/{}: {e}", file.display()))?;
            let file = file.to_string_lossy().replace('\\', "/");
            let path = file
                .trim_start_matches(folder)
                .trim_start_matches('/')
                .trim_end_matches(".wgsl");
            Ok(Source {
                path: path.replace('/', "::"),
                file: file.clone(),
                text,
            })
        })
        .collect()
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
    if !folder.exists() {
        return Ok(());
    }
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            collect(&path, files)?;
        } else if path.extension().is_some_and(|e| e == "wgsl") {
            files.push(path);
        }
    }
    Ok(())
}

/// Rust source of `MODULES` and `stages`.
fn constants(stages: &[Source], modules: &[Source]) -> String {
    let include =
        |file: &str| format!("include_str!(concat!(env!(\"CARGO_MANIFEST_DIR\"), \"/{file}\"))");
    let mut out = String::from(
        "/// Modules that kernels may import: path without `package::`, and text.\n\
         pub const MODULES: &[(&str, &str)] = &[\n",
    );
    for Source { path, file, .. } in modules {
        let _ = writeln!(out, "    ({path:?}, {}),", include(file));
    }
    out.push_str("];\n\n/// The kernels of the stages, one per file.\npub mod stages {\n");
    for Source { path, file, text } in stages {
        let (name, text_of) = (path.to_uppercase(), include(file));
        let summary = text
            .lines()
            .next()
            .and_then(|line| line.strip_prefix("//"))
            .unwrap_or_default();
        let _ = writeln!(
            out,
            "    #[doc = {:?}]\n    pub const {name}: gibs_graph::WgslSource = gibs_graph::WgslSource {{\n        \
             name: {path:?},\n        text: {text_of},\n        modules: super::MODULES,\n        features: &[],\n    }};",
            format!(
                "`{file}`. {}",
                summary.trim_start_matches(['/', '!']).trim()
            ),
        );
    }
    out.push_str("}\n");
    out
}
