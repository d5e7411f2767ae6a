//! Positions in WGSL files.
use std::fmt;

/// A position in a file, and the line there.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Place {
    /// Name of the file.
    pub file: String,
    /// Line, from 1.
    pub line: u32,
    /// Column in characters, from 1.
    pub column: u32,
    /// Text of the line.
    pub text: String,
}

impl Place {
    /// The place of the byte `offset` in the file `name`.
    pub(super) fn of(name: &str, text: &str, offset: usize) -> Self {
        let (line, column, text) = locate(text, offset);
        Place {
            file: name.into(),
            line: line + 1,
            column: column + 1,
            text: text.into(),
        }
    }

    /// The line with a mark under the column, to put below a message.
    pub fn snippet(&self) -> String {
        let number = self.line.to_string();
        let text: String = self
            .text
            .trim_end()
            .chars()
            .map(|c| if c.is_control() { ' ' } else { c })
            .collect();
        let (gutter, indent) = (
            " ".repeat(number.len()),
            " ".repeat(self.column.saturating_sub(1) as usize),
        );
        format!("  {number} | {text}\n  {gutter} | {indent}^")
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", self.file, self.line, self.column)
    }
}

/// Line and column, both from 0, of the byte `offset`, and the text of the line.
pub(super) fn locate(text: &str, offset: usize) -> (u32, u32, &str) {
    let offset = text.floor_char_boundary(offset);
    let start = text[..offset].rfind('\n').map_or(0, |i| i + 1);
    let end = text[start..].find('\n').map_or(text.len(), |i| start + i);
    let line = text[..start].matches('\n').count();
    (
        line as u32,
        text[start..offset].chars().count() as u32,
        &text[start..end],
    )
}
