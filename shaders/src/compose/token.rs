//! Words and marks of WGSL, without comments.
use super::{ComposeError, File, Place, Problem};

/// What a token is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Identifier or keyword.
    Word,
    /// Number, with suffix.
    Number,
    /// One character, or `::`, `&&`, `||`.
    Mark,
}

/// A piece of a file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Token<'a> {
    pub kind: Kind,
    pub text: &'a str,
    /// Byte offset in the file.
    pub start: usize,
}

impl Token<'_> {
    pub fn end(&self) -> usize {
        self.start + self.text.len()
    }
}

impl File<'_> {
    /// An error at a byte of this file.
    pub(super) fn error(&self, offset: usize, problem: Problem) -> ComposeError {
        ComposeError {
            place: Box::new(Place::of(&self.name, self.text, offset)),
            problem,
        }
    }
}

/// Splits a file.
///
/// # Errors
/// A block comment that is not closed.
pub(super) fn tokens<'a>(file: &File<'a>) -> Result<Vec<Token<'a>>, ComposeError> {
    let text = file.text;
    let mut tokens = Vec::new();
    let mut at = 0;
    while let Some(first) = text[at..].chars().next() {
        let rest = &text[at..];
        if first.is_whitespace() {
            at += first.len_utf8();
        } else if rest.starts_with("//") {
            at += rest.find(is_line_break).unwrap_or(rest.len());
        } else if rest.starts_with("/*") {
            at += comment(rest).ok_or_else(|| file.error(at, Problem::UnclosedComment))?;
        } else {
            let (kind, len) = token(rest, first);
            tokens.push(Token {
                kind,
                text: &rest[..len],
                start: at,
            });
            at += len;
        }
    }
    Ok(tokens)
}

/// WGSL's line breaks; carriage return and line feed count alone, too.
fn is_line_break(c: char) -> bool {
    matches!(
        c,
        '\n' | '\r' | '\u{b}' | '\u{c}' | '\u{85}' | '\u{2028}' | '\u{2029}'
    )
}

/// Bytes of the block comment at the start of `text`; block comments nest.
fn comment(text: &str) -> Option<usize> {
    let (mut depth, mut at) = (0, 0);
    loop {
        let next = at + text[at..].find(['/', '*'])?;
        (depth, at) = match text.as_bytes().get(next..next + 2) {
            Some(b"/*") => (depth + 1, next + 2),
            Some(b"*/") => (depth - 1, next + 2),
            _ => (depth, next + 1),
        };
        if depth == 0 {
            return Some(at);
        }
    }
}

fn token(rest: &str, first: char) -> (Kind, usize) {
    let word = |c: char| c == '_' || c.is_alphanumeric();
    let run = |more: &dyn Fn(char) -> bool| rest.find(|c| !more(c)).unwrap_or(rest.len());
    if first.is_ascii_digit() {
        (Kind::Number, run(&|c| word(c) || c == '.'))
    } else if word(first) {
        (Kind::Word, run(&word))
    } else if ["::", "&&", "||"].iter().any(|m| rest.starts_with(m)) {
        (Kind::Mark, 2)
    } else {
        (Kind::Mark, first.len_utf8())
    }
}

/// A position in the tokens of a file.
#[derive(Debug)]
pub(super) struct Cursor<'a, 'f> {
    pub file: &'f File<'a>,
    pub tokens: &'f [Token<'a>],
    /// Index of the next token.
    pub at: usize,
}

impl<'a> Cursor<'a, '_> {
    /// The next token, if any.
    pub fn peek(&self) -> Option<Token<'a>> {
        self.tokens.get(self.at).copied()
    }

    /// Whether the next token reads so.
    pub fn is(&self, text: &str) -> bool {
        self.peek().is_some_and(|t| t.text == text)
    }

    /// Steps over the next token if it reads so.
    pub fn skip(&mut self, text: &str) -> bool {
        let found = self.is(text);
        self.at += usize::from(found);
        found
    }

    /// Steps over the next token, which must read so.
    pub fn expect(
        &mut self,
        text: &'static str,
        expected: &'static str,
    ) -> Result<(), ComposeError> {
        if self.skip(text) {
            Ok(())
        } else {
            Err(self.unexpected(expected))
        }
    }

    /// Steps over a name.
    pub fn name(&mut self, expected: &'static str) -> Result<Token<'a>, ComposeError> {
        match self.peek() {
            Some(token) if token.kind == Kind::Word => {
                self.at += 1;
                Ok(token)
            }
            _ => Err(self.unexpected(expected)),
        }
    }

    /// Steps over a pair of brackets and all between, from the opening one on.
    pub fn skip_pair(&mut self) -> Result<(), ComposeError> {
        let Some(open) = self.peek() else {
            return Ok(());
        };
        let mut depth = 0_usize;
        while let Some(token) = self.peek() {
            self.at += 1;
            match token.text {
                "(" | "[" | "{" => depth += 1,
                ")" | "]" | "}" => depth -= 1,
                _ => {}
            }
            if depth == 0 {
                return Ok(());
            }
        }
        Err(self
            .file
            .error(open.start, Problem::Unclosed(open.text.into())))
    }

    /// The error that the next token is not what is needed.
    pub fn unexpected(&self, expected: &'static str) -> ComposeError {
        let (offset, found) = match self.peek() {
            Some(token) => (token.start, format!("`{}`", token.text)),
            None => (
                self.tokens.last().map_or(0, Token::end),
                "the end of the file".into(),
            ),
        };
        self.file
            .error(offset, Problem::Unexpected { expected, found })
    }
}
