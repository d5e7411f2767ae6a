//! What is done to every kernel, so that any mutant of it can be run.
use super::walk::{blocks, visit};
use super::{Place, function};
use naga::{
    BinaryOperator, Block, Expression, Function, Handle, Literal, LocalVariable, Module, Range,
    Scalar, Span, Statement, Type, TypeInner,
};

/// Ports are found by the names of globals, so nothing else may have one of theirs: the writer renames what collides.
pub fn leave_names_to_globals(module: &mut Module) {
    for (_, constant) in module.constants.iter_mut() {
        constant.name = None;
    }
    let mut functions: Vec<&mut Function> = Vec::new();
    for (_, function) in module.functions.iter_mut() {
        function.name = None;
        functions.push(function);
    }
    functions.extend(
        module
            .entry_points
            .iter_mut()
            .map(|entry| &mut entry.function),
    );
    for function in functions {
        function.named_expressions.clear();
        for (_, local) in function.local_variables.iter_mut() {
            local.name = None;
        }
        for argument in &mut function.arguments {
            argument.name = None;
        }
    }
}

/// Rounds of all loops of one call after which it gives up: far more than any kernel makes on the scenes of the cases,
/// and few enough that a mutant that never ends does.
const MOST_ROUNDS: u32 = 1 << 14;

/// Ends every loop after that many rounds, so that a mutant cannot run for ever.
pub fn bound_loops(module: &mut Module) {
    let integer = Type {
        name: None,
        inner: TypeInner::Scalar(Scalar::U32),
    };
    let ty = module.types.insert(integer, Span::UNDEFINED);
    let functions: Vec<_> = module.functions.iter().map(|(handle, _)| handle).collect();
    let places = functions
        .into_iter()
        .map(Place::Function)
        .chain([Place::Main]);
    for place in places.collect::<Vec<_>>() {
        let function = function(module, place);
        let mut has_loop = false;
        visit(&function.body, &mut |s| {
            has_loop |= matches!(s, Statement::Loop { .. })
        });
        if !has_loop {
            continue;
        }
        let zero = function
            .expressions
            .append(Expression::Literal(Literal::U32(0)), Span::UNDEFINED);
        let variable = LocalVariable {
            name: Some("rounds".into()),
            ty,
            init: Some(zero),
        };
        let rounds = function.local_variables.append(variable, Span::UNDEFINED);
        let mut body = std::mem::take(&mut function.body);
        bound_block(&mut body, rounds, &mut function.expressions);
        function.body = body;
    }
}

fn bound_block(
    block: &mut Block,
    rounds: Handle<LocalVariable>,
    expressions: &mut naga::Arena<Expression>,
) {
    for statement in block.iter_mut() {
        for block in blocks(statement) {
            bound_block(block, rounds, expressions);
        }
        if let Statement::Loop { body, .. } = statement {
            let mut append = |expression| expressions.append(expression, Span::UNDEFINED);
            let pointer = append(Expression::LocalVariable(rounds));
            let one = append(Expression::Literal(Literal::U32(1)));
            let most = append(Expression::Literal(Literal::U32(MOST_ROUNDS)));
            let before = append(Expression::Load { pointer });
            let after = append(Expression::Binary {
                op: BinaryOperator::Add,
                left: before,
                right: one,
            });
            let over = append(Expression::Binary {
                op: BinaryOperator::Greater,
                left: after,
                right: most,
            });
            let mut bounded = Block::new();
            let mut push = |statement| bounded.push(statement, Span::UNDEFINED);
            push(Statement::Emit(Range::new_from_bounds(before, over)));
            push(Statement::Store {
                pointer,
                value: after,
            });
            push(Statement::If {
                condition: over,
                accept: Block::from_vec(vec![Statement::Break]),
                reject: Block::new(),
            });
            bounded.append(body);
            *body = bounded;
        }
    }
}
