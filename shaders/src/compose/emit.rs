//! The composed text, and where each line of it comes from.
use super::place::{Place, locate};
use super::unit::{Body, Item, Unit};
use super::{File, Target};
use std::collections::{BTreeSet, HashSet};
use std::ops::Range;

/// Plain WGSL that knows where it comes from.
#[derive(Clone, Debug)]
pub struct Composed {
    text: String,
    lines: Vec<Line>,
    files: Vec<String>,
    features: BTreeSet<String>,
}

/// Origin of a line.
#[derive(Clone, Copy, Debug)]
struct Line {
    /// Index of the file.
    file: usize,
    /// Line in the file, from 1.
    line: u32,
    /// Column in the file, from 1, where the whole line comes from one spot.
    column: Option<u32>,
}

impl Composed {
    /// The text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Every feature that a condition of the included files names, given or not.
    pub fn features(&self) -> impl Iterator<Item = &str> {
        self.features.iter().map(String::as_str)
    }

    /// Where the byte `offset` of the text comes from.
    pub fn place(&self, offset: usize) -> Place {
        // Nothing stands behind the last line break.
        let (line, column, text) =
            locate(&self.text, offset.min(self.text.len().saturating_sub(1)));
        match self.lines.get(line as usize) {
            Some(origin) => Place {
                file: self.files[origin.file].clone(),
                line: origin.line,
                column: origin.column.unwrap_or(column + 1),
                text: text.into(),
            },
            None => Place {
                file: String::new(),
                line: 1,
                column: 1,
                text: String::new(),
            },
        }
    }

    fn push(&mut self, text: &str, line: Line) {
        self.text.push_str(text);
        self.text.push('\n');
        self.lines.push(line);
    }
}

/// Writes the directives of all files, then each file without what was dropped.
pub(super) fn emit(units: &[Unit<'_>], target: Target) -> Composed {
    let mut out = Composed {
        text: String::new(),
        lines: Vec::new(),
        files: units.iter().map(|u| u.file.name.to_string()).collect(),
        features: BTreeSet::new(),
    };
    let conditions = units
        .iter()
        .flat_map(|u| &u.items)
        .filter_map(|i| i.condition.as_ref());
    for test in conditions.filter_map(|c| c.test.as_ref()) {
        test.features(&mut |name| {
            out.features.insert(name.into());
        });
    }
    let mut seen = HashSet::new();
    for (index, unit) in units.iter().enumerate() {
        for item in unit.kept() {
            for (text, at) in directives(unit, item, target) {
                let place = Place::of("", unit.file.text, at);
                if seen.insert(text.clone()) {
                    out.push(
                        &text,
                        Line {
                            file: index,
                            line: place.line,
                            column: Some(place.column),
                        },
                    );
                }
            }
        }
    }
    for (index, unit) in units.iter().enumerate() {
        out.push(
            &format!("// {}", unit.file.name),
            Line {
                file: index,
                line: 1,
                column: Some(1),
            },
        );
        body(unit, index, &mut out);
    }
    out
}

/// The lines that a directive becomes, one per extension, and where each comes from.
fn directives(unit: &Unit<'_>, item: &Item<'_>, target: Target) -> Vec<(String, usize)> {
    let Body::Directive(word, arguments) = &item.body else {
        return Vec::new();
    };
    let arguments = &unit.tokens[arguments.clone()];
    if word.text != "enable" {
        let text: String = arguments.iter().map(|t| t.text).collect();
        let space = if word.text == "requires" { " " } else { "" };
        return vec![(format!("{}{space}{text};", word.text), word.start)];
    }
    let known = arguments
        .iter()
        .filter(|t| t.text != "," && target.knows(t.text));
    known
        .map(|t| (format!("enable {};", t.text), t.start))
        .collect()
}

/// Writes a file with what was dropped or hoisted blanked out, so that columns stay; lines that become empty go.
fn body(unit: &Unit<'_>, index: usize, out: &mut Composed) {
    let mut gone: Vec<Range<usize>> = Vec::new();
    for (item, kept) in unit.items.iter().zip(&unit.kept) {
        if !kept || !matches!(item.body, Body::Declaration(_)) {
            gone.push(unit.bytes(&item.tokens));
        } else if let Some(condition) = &item.condition {
            gone.push(unit.bytes(&condition.tokens));
        }
    }
    let blanked = blank(&unit.file, &gone);
    let mut was_empty = true;
    for (number, line) in blanked.lines().enumerate() {
        let line = line.trim_end();
        if !(line.is_empty() && was_empty) {
            out.push(
                line,
                Line {
                    file: index,
                    line: number as u32 + 1,
                    column: None,
                },
            );
        }
        was_empty = line.is_empty();
    }
}

fn blank(file: &File<'_>, gone: &[Range<usize>]) -> String {
    let mut text = String::with_capacity(file.text.len());
    let mut at = 0;
    for range in gone {
        text.push_str(&file.text[at..range.start]);
        text.extend(
            file.text[range.clone()]
                .chars()
                .map(|c| if c == '\n' { '\n' } else { ' ' }),
        );
        at = range.end;
    }
    text.push_str(&file.text[at..]);
    text
}
