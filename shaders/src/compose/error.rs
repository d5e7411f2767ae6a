//! What can be wrong with files that are composed.
use super::Place;
use thiserror::Error;

/// A problem and where it is.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{place}: {problem}\n{}", place.snippet())]
pub struct ComposeError {
    /// Where.
    pub place: Box<Place>,
    /// What.
    pub problem: Problem,
}

/// What is wrong.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Problem {
    /// The file ends inside a block comment.
    #[error("this comment is never closed; add `*/`")]
    UnclosedComment,
    /// The file ends inside a pair.
    #[error("`{0}` is never closed")]
    Unclosed(String),
    /// Something else was needed.
    #[error("expected {expected}, found {found}")]
    Unexpected {
        /// What may stand here.
        expected: &'static str,
        /// What stands here.
        found: String,
    },
    /// An import or a directive after a declaration.
    #[error("`{0}` must stand at the top of the file, before its first declaration")]
    Misplaced(String),
    /// An import that does not start with `package`.
    #[error("an import starts with `package::`, not with `{0}`")]
    Foreign(String),
    /// An import with `as`.
    #[error("an import cannot be renamed, because all files share one namespace; remove `as`")]
    Renamed,
    /// An import with `*`.
    #[error("an import names its declarations; write `import package::module::{{a, b}};`")]
    Wildcard,
    /// An import of a module instead of a declaration in it.
    #[error(
        "`package::{0}` is a module; name what you need of it, as in `import package::{0}::name;`"
    )]
    Module(String),
    /// No module has the path.
    #[error("there is no module `package::{path}`{}", list("; there are ", known))]
    UnknownModule {
        /// Path without `package::`.
        path: String,
        /// Modules that exist.
        known: Vec<String>,
    },
    /// The module lacks the name.
    #[error(
        "module `package::{module}` declares no `{name}`{}",
        list("; it declares ", declared)
    )]
    UnknownName {
        /// Path without `package::`.
        module: String,
        /// Name that is imported.
        name: String,
        /// What the module declares with the given features.
        declared: Vec<String>,
    },
    /// Modules import each other in a circle.
    #[error("imports form a circle: {}", .0.join(" -> "))]
    Cycle(
        /// Files, the first also the last.
        Vec<String>,
    ),
    /// Two declarations of one name.
    #[error(
        "`{name}` is also declared at {other}; all files share one namespace, so rename one of the two"
    )]
    Duplicate {
        /// The name.
        name: String,
        /// File, line and column of the other declaration.
        other: String,
    },
    /// A declaration of a module is used without import.
    #[error(
        "`{name}` is declared in `package::{module}` but not imported; add `import package::{module}::{name};`"
    )]
    NotImported {
        /// The name.
        name: String,
        /// Path of the module that declares it.
        module: String,
    },
    /// `@else` or `@elif` that follows no `@if`.
    #[error("`@{0}` must follow an import, directive or declaration that has `@if` or `@elif`")]
    Dangling(String),
    /// Two conditions on one declaration.
    #[error("a declaration takes one condition; join them with `&&`")]
    SecondCondition,
    /// A condition inside a declaration.
    #[error(
        "`@{0}` is allowed before imports, directives and declarations only, not inside of them"
    )]
    Nested(String),
}

fn list(lead: &str, names: &[String]) -> String {
    if names.is_empty() {
        String::new()
    } else {
        format!("{lead}{}", names.join(", "))
    }
}
