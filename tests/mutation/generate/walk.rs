//! The expressions and statements of a function.
use naga::{Block, Expression, Function, Handle, Span, Statement};
use std::collections::BTreeSet;

/// Expressions that something refers to.
pub fn used(function: &Function) -> BTreeSet<Handle<Expression>> {
    let mut used = BTreeSet::new();
    for (_, expression) in function.expressions.iter() {
        operands(expression, &mut used);
    }
    visit(&function.body, &mut |statement| match statement {
        Statement::If { condition, .. } => drop(used.insert(*condition)),
        Statement::Switch { selector, .. } => drop(used.insert(*selector)),
        Statement::Store { pointer, value } => used.extend([*pointer, *value]),
        Statement::ImageStore {
            coordinate, value, ..
        } => used.extend([*coordinate, *value]),
        Statement::Atomic { pointer, value, .. } => used.extend([*pointer, *value]),
        Statement::Call { arguments, .. } => used.extend(arguments.iter().copied()),
        Statement::Return { value } => used.extend(*value),
        Statement::Loop { break_if, .. } => used.extend(*break_if),
        _ => {}
    });
    used
}

fn operands(expression: &Expression, used: &mut BTreeSet<Handle<Expression>>) {
    match expression {
        Expression::Compose { components, .. } => used.extend(components.iter().copied()),
        Expression::Access { base, index } => used.extend([*base, *index]),
        Expression::AccessIndex { base, .. } => drop(used.insert(*base)),
        Expression::Splat { value, .. } => drop(used.insert(*value)),
        Expression::Swizzle { vector, .. } => drop(used.insert(*vector)),
        Expression::Load { pointer } => drop(used.insert(*pointer)),
        Expression::Unary { expr, .. } => drop(used.insert(*expr)),
        Expression::Binary { left, right, .. } => used.extend([*left, *right]),
        Expression::Select {
            condition,
            accept,
            reject,
        } => used.extend([*condition, *accept, *reject]),
        Expression::Math {
            arg,
            arg1,
            arg2,
            arg3,
            ..
        } => {
            used.insert(*arg);
            used.extend([arg1, arg2, arg3].into_iter().filter_map(|arg| *arg));
        }
        Expression::As { expr, .. } => drop(used.insert(*expr)),
        Expression::Relational { argument, .. } => drop(used.insert(*argument)),
        Expression::ImageLoad { coordinate, .. } => drop(used.insert(*coordinate)),
        _ => {}
    }
}

/// Visits statements depth first.
pub fn visit(block: &Block, seen: &mut impl FnMut(&Statement)) {
    visit_spans(block, &mut |statement, _| seen(statement));
}

pub fn visit_spans(block: &Block, seen: &mut impl FnMut(&Statement, Span)) {
    for (statement, span) in block.span_iter() {
        seen(statement, *span);
        match statement {
            Statement::Block(block) => visit_spans(block, seen),
            Statement::If { accept, reject, .. } => {
                visit_spans(accept, seen);
                visit_spans(reject, seen);
            }
            Statement::Switch { cases, .. } => {
                cases.iter().for_each(|case| visit_spans(&case.body, seen));
            }
            Statement::Loop {
                body, continuing, ..
            } => {
                visit_spans(body, seen);
                visit_spans(continuing, seen);
            }
            _ => {}
        }
    }
}

/// The statements that are within a loop, by their numbers.
pub fn repeated(block: &Block) -> BTreeSet<usize> {
    let (mut index, mut found) = (0, BTreeSet::new());
    visit(block, &mut |statement| {
        if let Statement::Loop {
            body, continuing, ..
        } = statement
        {
            let mut inner = 0;
            visit(body, &mut |_| inner += 1);
            visit(continuing, &mut |_| inner += 1);
            found.extend(index + 1..=index + inner);
        }
        index += 1;
    });
    found
}

/// The blocks within a statement, in the order in which they are visited.
pub fn blocks(statement: &mut Statement) -> Vec<&mut Block> {
    match statement {
        Statement::Block(block) => vec![block],
        Statement::If { accept, reject, .. } => vec![accept, reject],
        Statement::Switch { cases, .. } => cases.iter_mut().map(|case| &mut case.body).collect(),
        Statement::Loop {
            body, continuing, ..
        } => vec![body, continuing],
        _ => Vec::new(),
    }
}

/// Takes the statement with this number out; whether it was here.
pub fn drop_statement(block: &mut Block, left: &mut usize) -> bool {
    for i in 0..block.len() {
        if *left == 0 {
            block.cull(i..=i);
            return true;
        }
        *left -= 1;
        if blocks(&mut block[i])
            .into_iter()
            .any(|block| drop_statement(block, left))
        {
            return true;
        }
    }
    false
}

pub fn swap_ways(block: &mut Block, left: &mut usize) -> bool {
    for statement in block.iter_mut() {
        if *left == 0 {
            if let Statement::If { accept, reject, .. } = statement {
                std::mem::swap(accept, reject);
            }
            return true;
        }
        *left -= 1;
        if blocks(statement)
            .into_iter()
            .any(|block| swap_ways(block, left))
        {
            return true;
        }
    }
    false
}
