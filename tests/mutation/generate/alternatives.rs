//! What an expression may become.
use naga::{
    BinaryOperator, Expression, Function, Literal, MathFunction, Module, TypeInner, UnaryOperator,
};

/// What an expression may become, with a description.
pub fn alternatives(
    module: &Module,
    function: &Function,
    expression: &Expression,
) -> Vec<(String, Expression)> {
    use BinaryOperator as B;
    use MathFunction as M;
    let binary = |op, left, right| Expression::Binary { op, left, right };
    match *expression {
        Expression::Binary { op, left, right } => {
            let others: &[B] = match op {
                B::Add => &[B::Subtract],
                B::Subtract => &[B::Add],
                B::Multiply => &[B::Divide],
                B::Divide => &[B::Multiply],
                B::Modulo => &[B::Divide],
                B::Equal => &[B::NotEqual],
                B::NotEqual => &[B::Equal],
                B::Less => &[B::LessEqual, B::GreaterEqual],
                B::LessEqual => &[B::Less, B::Greater],
                B::Greater => &[B::GreaterEqual, B::LessEqual],
                B::GreaterEqual => &[B::Greater, B::Less],
                B::And => &[B::InclusiveOr],
                B::InclusiveOr => &[B::And],
                B::ExclusiveOr => &[B::And],
                B::LogicalAnd => &[B::LogicalOr],
                B::LogicalOr => &[B::LogicalAnd],
                B::ShiftLeft => &[B::ShiftRight],
                B::ShiftRight => &[B::ShiftLeft],
            };
            let named = |other: &B| (format!("{op:?} to {other:?}"), binary(*other, left, right));
            let mut found: Vec<_> = others.iter().map(named).collect();
            if op == B::Subtract {
                found.push(("sign of a difference".into(), binary(op, right, left)));
            }
            found
        }
        Expression::Unary { op, expr } if op != UnaryOperator::BitwiseNot => {
            // The operand in its place: as the sum with nothing there is no expression, so it is copied.
            let copy = function.expressions[expr].clone();
            match copy {
                Expression::Load { .. } | Expression::Binary { .. } | Expression::Literal(_) => {
                    vec![(format!("no {op:?}"), copy)]
                }
                _ => Vec::new(),
            }
        }
        Expression::Literal(literal) => literals(literal)
            .into_iter()
            .map(|(what, new)| (what, Expression::Literal(new)))
            .collect(),
        Expression::Math {
            fun,
            arg,
            arg1,
            arg2,
            arg3,
        } => {
            let other = match fun {
                M::Min => M::Max,
                M::Max => M::Min,
                M::Floor => M::Ceil,
                M::Ceil => M::Floor,
                M::Cross if arg1.is_some() => {
                    let swapped = Expression::Math {
                        fun,
                        arg: arg1.unwrap_or(arg),
                        arg1: Some(arg),
                        arg2,
                        arg3,
                    };
                    return vec![("sign of a cross product".into(), swapped)];
                }
                M::Sqrt => M::Abs,
                M::Abs => M::Sign,
                _ => return Vec::new(),
            };
            let new = Expression::Math {
                fun: other,
                arg,
                arg1,
                arg2,
                arg3,
            };
            vec![(format!("{fun:?} to {other:?}"), new)]
        }
        Expression::Select {
            condition,
            accept,
            reject,
        } => {
            let swapped = Expression::Select {
                condition,
                accept: reject,
                reject: accept,
            };
            vec![("the other choice".into(), swapped)]
        }
        // The element, field or component beside it; of another type, it is no valid kernel.
        Expression::AccessIndex { base, index } => {
            let beside = if index == 0 { 1 } else { index - 1 };
            let new = Expression::AccessIndex {
                base,
                index: beside,
            };
            let of_buffer = match function.expressions[base] {
                Expression::GlobalVariable(global) => {
                    let ty = module.global_variables[global].ty;
                    matches!(module.types[ty].inner, TypeInner::Array { .. })
                }
                _ => false,
            };
            let what = if of_buffer { "element" } else { "index" };
            vec![(format!("{what} {index} to {beside}"), new)]
        }
        _ => Vec::new(),
    }
}

pub fn literals(literal: Literal) -> Vec<(String, Literal)> {
    let other = match literal {
        Literal::F32(0.0) => Literal::F32(1.0),
        Literal::F32(x) => Literal::F32(-x),
        Literal::U32(x) => Literal::U32(x.wrapping_add(1)),
        Literal::I32(x) => Literal::I32(x.wrapping_add(1)),
        Literal::Bool(x) => Literal::Bool(!x),
        _ => return Vec::new(),
    };
    vec![(format!("{literal:?} to {other:?}"), other)]
}
