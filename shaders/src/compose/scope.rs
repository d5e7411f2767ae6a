//! Names: each declared once, and used where it is imported.
use super::place::Place;
use super::token::{Kind, Token};
use super::unit::{Body, Unit};
use super::{ComposeError, Problem};
use std::collections::{HashMap, HashSet};

/// Checks the names of all files; the last one is the root.
pub(super) fn check(units: &[Unit<'_>]) -> Result<(), ComposeError> {
    let mut owner: HashMap<&str, (usize, Token<'_>)> = HashMap::new();
    for (index, unit) in units.iter().enumerate() {
        for name in unit.declared() {
            if let Some((other, first)) = owner.insert(name.text, (index, name)) {
                let other = &units[other].file;
                let other = Place::of(&other.name, other.text, first.start).to_string();
                return Err(unit.file.error(
                    name.start,
                    Problem::Duplicate {
                        name: name.text.into(),
                        other,
                    },
                ));
            }
        }
    }
    let root = units.len().saturating_sub(1);
    for (index, unit) in units.iter().enumerate() {
        let imported: HashSet<&str> = unit.imports().map(|i| i.name.text).collect();
        let uses = uses(unit);
        let local: HashSet<&str> = uses
            .iter()
            .filter(|u| u.binds)
            .map(|u| u.name.text)
            .collect();
        for used in &uses {
            let name = used.name.text;
            let Some(&(declared_in, _)) = owner.get(name) else {
                continue;
            };
            // The root is open to modules: WGSL cannot pass a storage buffer to a function.
            if declared_in != index
                && declared_in != root
                && !imported.contains(name)
                && !local.contains(name)
            {
                let problem = Problem::NotImported {
                    name: name.into(),
                    module: units[declared_in].file.path.into(),
                };
                return Err(unit.file.error(used.name.start, problem));
            }
        }
    }
    Ok(())
}

struct Use<'a> {
    name: Token<'a>,
    /// It names a parameter, a member or a local, and so hides what other files declare.
    binds: bool,
}

/// Words that may refer to a declaration: not members, not attributes.
fn uses<'a>(unit: &Unit<'a>) -> Vec<Use<'a>> {
    let mut uses = Vec::new();
    for item in unit
        .kept()
        .filter(|item| matches!(item.body, Body::Declaration(_)))
    {
        let tokens = &unit.tokens[item.tokens.clone()];
        for (i, &name) in tokens.iter().enumerate() {
            let before = i.checked_sub(1).map_or("", |i| tokens[i].text);
            let built_in = before == "("
                && i >= 3
                && tokens[i - 3].text == "@"
                && tokens[i - 2].text == "builtin";
            if name.kind != Kind::Word
                || matches!(before, "." | "@")
                || built_in
                || is_enumerant(name.text)
            {
                continue;
            }
            let after = tokens.get(i + 1).map_or("", |t| t.text);
            let binds = after == ":" || matches!(before, "let" | "var" | "const");
            uses.push(Use { name, binds });
        }
    }
    uses
}

/// Words that have their own meaning in `var<..>` and `ptr<..>`, where no declaration hides them.
fn is_enumerant(word: &str) -> bool {
    matches!(
        word,
        "function"
            | "private"
            | "workgroup"
            | "uniform"
            | "storage"
            | "read"
            | "write"
            | "read_write"
    )
}
