//! One file, split into its top-level items.
use super::condition::Condition;
use super::import::{self, Import};
use super::token::{Cursor, Token, tokens};
use super::{ComposeError, File, Problem};
use std::ops::Range;

/// A file and what stands in it.
#[derive(Debug)]
pub(super) struct Unit<'a> {
    pub file: File<'a>,
    pub tokens: Vec<Token<'a>>,
    pub items: Vec<Item<'a>>,
    /// Items that the features keep, by index.
    pub kept: Vec<bool>,
}

/// A top-level import, directive or declaration with its attributes.
#[derive(Debug)]
pub(super) struct Item<'a> {
    /// Its tokens, by index.
    pub tokens: Range<usize>,
    pub condition: Option<Conditional<'a>>,
    pub body: Body<'a>,
}

/// A condition on an item.
#[derive(Debug)]
pub(super) struct Conditional<'a> {
    /// Tokens of the attribute, by index.
    pub tokens: Range<usize>,
    /// Belongs to the chain that an earlier item starts.
    pub chained: bool,
    /// `None` for `@else`.
    pub test: Option<Condition<'a>>,
}

/// What an item is.
#[derive(Debug)]
pub(super) enum Body<'a> {
    Import(Vec<Import<'a>>),
    /// `enable`, `requires` or `diagnostic`, and the tokens behind the word, without `;`.
    Directive(Token<'a>, Range<usize>),
    /// A declaration; `const_assert` and `;` have no name.
    Declaration(Option<Token<'a>>),
}

impl<'a> Unit<'a> {
    /// Splits a file and decides its conditions.
    pub fn read(file: File<'a>, features: &[&str]) -> Result<Self, ComposeError> {
        let tokens = tokens(&file)?;
        let mut cursor = Cursor {
            file: &file,
            tokens: &tokens,
            at: 0,
        };
        let mut items: Vec<Item<'a>> = Vec::new();
        let mut declared = false;
        while cursor.peek().is_some() {
            let item = item(&mut cursor)?;
            let word = &tokens[item.body_start()];
            match item.body {
                Body::Declaration(_) => declared = true,
                _ if declared => {
                    return Err(file.error(word.start, Problem::Misplaced(word.text.into())));
                }
                _ => {}
            }
            if let Some(c) = item.condition.as_ref().filter(|c| c.chained)
                && !items.last().is_some_and(Item::starts_chain)
            {
                let (at, word) = (tokens[c.tokens.start], tokens[c.tokens.start + 1]);
                return Err(file.error(at.start, Problem::Dangling(word.text.into())));
            }
            items.push(item);
        }
        let kept = decide(&items, features);
        Ok(Unit {
            file,
            tokens,
            items,
            kept,
        })
    }

    /// The items that the features keep.
    pub fn kept(&self) -> impl Iterator<Item = &Item<'a>> {
        self.items
            .iter()
            .zip(&self.kept)
            .filter_map(|(item, kept)| kept.then_some(item))
    }

    /// The imports that the features keep.
    pub fn imports(&self) -> impl Iterator<Item = &Import<'a>> {
        self.kept()
            .filter_map(|item| {
                if let Body::Import(list) = &item.body {
                    Some(list)
                } else {
                    None
                }
            })
            .flatten()
    }

    /// The names that the features keep.
    pub fn declared(&self) -> impl Iterator<Item = Token<'a>> {
        self.kept().filter_map(|item| {
            if let Body::Declaration(name) = item.body {
                name
            } else {
                None
            }
        })
    }

    /// Bytes of a range of tokens.
    pub fn bytes(&self, tokens: &Range<usize>) -> Range<usize> {
        match self.tokens.get(tokens.clone()) {
            Some([first, .., last]) => first.start..last.end(),
            Some([only]) => only.start..only.end(),
            _ => 0..0,
        }
    }
}

impl Item<'_> {
    fn body_start(&self) -> usize {
        match &self.condition {
            Some(c) if c.tokens.start == self.tokens.start => c.tokens.end,
            _ => self.tokens.start,
        }
    }

    fn starts_chain(&self) -> bool {
        self.condition.as_ref().is_some_and(|c| c.test.is_some())
    }
}

/// Which items stay: of a chain of `@if`, `@elif` and `@else` the first that holds.
fn decide(items: &[Item<'_>], features: &[&str]) -> Vec<bool> {
    let mut taken = false;
    let mut keep = |item: &Item<'_>| {
        let Some(condition) = &item.condition else {
            return true;
        };
        let open = !condition.chained || !taken;
        let keep = open
            && condition
                .test
                .as_ref()
                .is_none_or(|test| test.holds(features));
        taken = keep || !open;
        keep
    };
    items.iter().map(&mut keep).collect()
}

fn item<'a>(cursor: &mut Cursor<'a, '_>) -> Result<Item<'a>, ComposeError> {
    let start = cursor.at;
    let condition = attributes(cursor)?;
    let word_at = cursor.at;
    let Some(word) = cursor.peek() else {
        return Err(cursor.unexpected(DECLARATION));
    };
    cursor.at += 1;
    let body = match word.text {
        "import" => Body::Import(import::read(cursor)?),
        "enable" | "requires" | "diagnostic" => {
            to_semicolon(cursor)?;
            Body::Directive(word, word_at + 1..cursor.at - 1)
        }
        "fn" | "struct" => {
            let name = cursor.name("a name")?;
            to_brace(cursor)?;
            Body::Declaration(Some(name))
        }
        "const" | "override" | "alias" | "var" => {
            if word.text == "var" && cursor.is("<") {
                while !cursor.skip(">") {
                    cursor.at += 1;
                    if cursor.peek().is_none() {
                        return Err(cursor.unexpected("`>`"));
                    }
                }
            }
            let name = cursor.name("a name")?;
            to_semicolon(cursor)?;
            Body::Declaration(Some(name))
        }
        "const_assert" => {
            to_semicolon(cursor)?;
            Body::Declaration(None)
        }
        ";" => Body::Declaration(None),
        _ => {
            cursor.at -= 1;
            return Err(cursor.unexpected(DECLARATION));
        }
    };
    no_conditions(cursor, word_at)?;
    Ok(Item {
        tokens: start..cursor.at,
        condition,
        body,
    })
}

const DECLARATION: &str = "an import, a directive or a declaration";

/// Steps over attributes, and gives the one that is a condition.
fn attributes<'a>(cursor: &mut Cursor<'a, '_>) -> Result<Option<Conditional<'a>>, ComposeError> {
    let mut condition = None;
    while cursor.is("@") {
        let start = cursor.at;
        cursor.at += 1;
        let word = cursor.name("the name of an attribute")?;
        if !is_condition(word.text) {
            if cursor.is("(") {
                cursor.skip_pair()?;
            }
            continue;
        }
        if condition.is_some() {
            return Err(cursor.file.error(word.start, Problem::SecondCondition));
        }
        let test = if word.text == "else" {
            None
        } else {
            Some(Condition::read(cursor)?)
        };
        condition = Some(Conditional {
            tokens: start..cursor.at,
            chained: word.text != "if",
            test,
        });
    }
    Ok(condition)
}

fn is_condition(word: &str) -> bool {
    matches!(word, "if" | "elif" | "else")
}

/// Steps behind the next `;` that is outside of brackets.
fn to_semicolon(cursor: &mut Cursor<'_, '_>) -> Result<(), ComposeError> {
    while let Some(token) = cursor.peek() {
        match token.text {
            "(" | "[" | "{" => cursor.skip_pair()?,
            ")" | "]" | "}" => break,
            _ => cursor.at += 1,
        }
        if token.text == ";" {
            return Ok(());
        }
    }
    Err(cursor.unexpected("`;`"))
}

/// Steps behind the next braces that are outside of brackets.
fn to_brace(cursor: &mut Cursor<'_, '_>) -> Result<(), ComposeError> {
    while let Some(token) = cursor.peek() {
        match token.text {
            "{" => return cursor.skip_pair(),
            "(" | "[" => cursor.skip_pair()?,
            ")" | "]" | "}" | ";" => break,
            _ => cursor.at += 1,
        }
    }
    Err(cursor.unexpected("`{`"))
}

fn no_conditions(cursor: &Cursor<'_, '_>, start: usize) -> Result<(), ComposeError> {
    match cursor.tokens[start..cursor.at]
        .windows(2)
        .find(|w| w[0].text == "@" && is_condition(w[1].text))
    {
        Some(found) => Err(cursor
            .file
            .error(found[0].start, Problem::Nested(found[1].text.into()))),
        None => Ok(()),
    }
}
