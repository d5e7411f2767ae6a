//! Sentences for the user, each once.
use std::collections::BTreeSet;

/// Warnings in the order in which they came up.
#[derive(Debug, Default)]
pub(super) struct Warnings {
    lines: Vec<(Option<&'static str>, String)>,
    kinds: BTreeSet<&'static str>,
    texts: BTreeSet<String>,
}

impl Warnings {
    /// A warning that is said once per wording.
    pub(super) fn push(&mut self, line: String) {
        if self.texts.insert(line.clone()) {
            self.lines.push((None, line));
        }
    }

    /// A warning of a kind that is said the first time only.
    pub(super) fn once(&mut self, kind: &'static str, line: impl FnOnce() -> String) {
        if self.kinds.insert(kind) {
            self.lines.push((Some(kind), line()));
        }
    }

    /// Adds what another part of the import had to say.
    pub(super) fn merge(&mut self, other: Warnings) {
        for (kind, line) in other.lines {
            match kind {
                Some(kind) => self.once(kind, || line),
                None => self.push(line),
            }
        }
    }

    /// All sentences.
    pub(super) fn into_lines(self) -> Vec<String> {
        self.lines.into_iter().map(|(_, line)| line).collect()
    }
}
