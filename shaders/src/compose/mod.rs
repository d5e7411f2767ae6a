//! Composition: from a WGSL file and the modules that it imports to one plain WGSL text.
//!
//! The syntax is a subset of WESL, so that its tools can read the same files:
//!
//! ```text
//! import package::hash::pcg;
//! import package::{math::sh::{evaluate, project}, random::next};
//! @if(RAY_QUERY) import package::trace_hardware::trace;
//! @else import package::trace_software::trace;
//! ```
//!
//! - The last segment of an import is a declaration, the ones before it are the path of the module (`math::sh`).
//!   Imports and directives stand at the top of a file.
//! - A module is included once and as a whole, after everything that it imports; the file itself comes last. Nothing is
//!   renamed, so two declarations of one name are an error, and so are cycles.
//! - `@if(..)`, `@elif(..)` and `@else` before an import, a directive or a declaration keep or drop it. Conditions are
//!   made of feature names, `true`, `false`, `!`, `&&`, `||` and parentheses; a feature that is not given is false.
//! - `enable`, `requires` and `diagnostic` directives are hoisted and de-duplicated; an `enable` that the target does
//!   not know is left out.
//! - A declaration of a module may be used where it is imported. What the file itself declares may be used in every
//!   module: WGSL cannot pass a storage buffer to a function, so a module that reads one names the stage's global.
//!
//! This part knows no graph and no shader tool: the build script uses it, too.
mod condition;
mod emit;
mod error;
mod import;
mod order;
mod place;
mod scope;
mod token;
mod unit;

pub use emit::Composed;
pub use error::{ComposeError, Problem};
pub use place::Place;

use std::borrow::Cow;

/// A WGSL file.
#[derive(Clone, Debug)]
pub struct File<'a> {
    /// Path without `package::`, for example `math::sh`.
    pub path: &'a str,
    /// How messages call the file.
    pub name: Cow<'a, str>,
    /// Its text.
    pub text: &'a str,
}

impl<'a> File<'a> {
    /// A file that messages call by its path, `math/sh.wgsl`.
    pub fn new(path: &'a str, text: &'a str) -> Self {
        File {
            path,
            name: format!("{}.wgsl", path.replace("::", "/")).into(),
            text,
        }
    }
}

/// Who reads the composed text; decides which `enable` lines it gets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Target {
    /// naga, which wgpu uses, too. It has subgroup functions but rejects `enable subgroups;`.
    Naga,
    /// A browser's WebGPU, which knows no `wgpu_` extension.
    Browser,
}

impl Target {
    fn knows(self, extension: &str) -> bool {
        match self {
            Target::Naga => extension != "subgroups",
            Target::Browser => !extension.starts_with("wgpu_"),
        }
    }
}

/// Composes `root` with those `modules` that it imports, directly or not.
///
/// # Errors
/// The first problem, with the file, line and column where it is.
pub fn compose(
    root: &File<'_>,
    modules: &[File<'_>],
    features: &[&str],
    target: Target,
) -> Result<Composed, ComposeError> {
    let units = order::order(root, modules, features)?;
    scope::check(&units)?;
    Ok(emit::emit(&units, target))
}

#[cfg(test)]
mod tests;
