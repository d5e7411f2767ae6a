//! Conditions on features.
use super::ComposeError;
use super::token::Cursor;

/// An expression of features.
#[derive(Clone, Debug)]
pub(super) enum Condition<'a> {
    Constant(bool),
    Feature(&'a str),
    Not(Box<Condition<'a>>),
    // Lists, so that a long chain is no deep tree: only parentheses and negations nest.
    All(Vec<Condition<'a>>),
    Any(Vec<Condition<'a>>),
}

/// How deep parentheses and negations may nest; bounds the recursion.
const MAX_DEPTH: usize = 64;

impl<'a> Condition<'a> {
    /// Reads `(expression)`.
    pub fn read(cursor: &mut Cursor<'a, '_>) -> Result<Self, ComposeError> {
        cursor.expect("(", "`(` and a condition")?;
        let condition = Self::or(cursor, 0)?;
        cursor.expect(")", "`&&`, `||` or `)`")?;
        Ok(condition)
    }

    fn or(cursor: &mut Cursor<'a, '_>, depth: usize) -> Result<Self, ComposeError> {
        let mut operands = vec![Self::and(cursor, depth)?];
        while cursor.skip("||") {
            operands.push(Self::and(cursor, depth)?);
        }
        Ok(Self::Any(operands))
    }

    fn and(cursor: &mut Cursor<'a, '_>, depth: usize) -> Result<Self, ComposeError> {
        let mut operands = vec![Self::not(cursor, depth)?];
        while cursor.skip("&&") {
            operands.push(Self::not(cursor, depth)?);
        }
        Ok(Self::All(operands))
    }

    fn not(cursor: &mut Cursor<'a, '_>, depth: usize) -> Result<Self, ComposeError> {
        if depth > MAX_DEPTH {
            return Err(cursor.unexpected("a condition with less nesting"));
        }
        if cursor.skip("!") {
            return Ok(Self::Not(Self::not(cursor, depth + 1)?.into()));
        }
        if cursor.skip("(") {
            let inner = Self::or(cursor, depth + 1)?;
            cursor.expect(")", "`&&`, `||` or `)`")?;
            return Ok(inner);
        }
        Ok(match cursor.name("a feature, `!` or `(`")?.text {
            "true" => Self::Constant(true),
            "false" => Self::Constant(false),
            feature => Self::Feature(feature),
        })
    }

    /// Whether it holds.
    pub fn holds(&self, features: &[&str]) -> bool {
        match self {
            Self::Constant(value) => *value,
            Self::Feature(name) => features.contains(name),
            Self::Not(inner) => !inner.holds(features),
            Self::All(operands) => operands.iter().all(|operand| operand.holds(features)),
            Self::Any(operands) => operands.iter().any(|operand| operand.holds(features)),
        }
    }

    /// Calls `visit` with every feature that it names.
    pub fn features(&self, visit: &mut impl FnMut(&'a str)) {
        match self {
            Self::Constant(_) => {}
            Self::Feature(name) => visit(name),
            Self::Not(inner) => inner.features(visit),
            Self::All(operands) | Self::Any(operands) => {
                operands.iter().for_each(|operand| operand.features(visit));
            }
        }
    }
}
