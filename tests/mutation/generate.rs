//! Mutants of a WGSL kernel: its IR with one small thing wrong.
use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{
    BinaryOperator, Block, Expression, Function, Handle, Literal, LocalVariable, MathFunction,
    Module, Range, Scalar, Span, Statement, Type, TypeInner, UnaryOperator,
};
use std::collections::BTreeSet;

/// One change to a kernel.
#[derive(Clone, Debug)]
pub struct Mutant {
    /// What was changed, for people.
    pub what: String,
    /// The kernel as WGSL.
    pub text: String,
}

/// Which function something is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Main,
    Function(Handle<Function>),
}

/// A change, and where.
#[derive(Clone, Debug)]
enum Change {
    /// An expression becomes another.
    Expression(Place, Handle<Expression>, Expression),
    /// A constant's value becomes another.
    Constant(Handle<Expression>, Expression),
    /// The n-th statement, counted depth first, goes.
    Drop(Place, usize),
    /// The two ways of the n-th statement, an `if`, are swapped.
    Swap(Place, usize),
}

/// A change with its description.
struct Described {
    what: String,
    /// Name of the function, or of the constant.
    function: String,
    change: Change,
}

/// A kernel, and everything that can be changed about it.
pub struct Kernel {
    module: Module,
    source: String,
    changes: Vec<Described>,
}

impl Kernel {
    /// Parses a composed kernel.
    pub fn new(wgsl: &str) -> Result<Self, String> {
        let module = naga::front::wgsl::parse_str(wgsl).map_err(|e| e.emit_to_string(wgsl))?;
        let mut kernel = Self {
            module,
            source: wgsl.into(),
            changes: Vec::new(),
        };
        kernel.changes = kernel.find();
        Ok(kernel)
    }

    /// How many changes there are.
    pub fn len(&self) -> usize {
        self.changes.len()
    }

    /// The function, or constant, that a change is in, and which of its changes it is.
    pub fn place_of(&self, index: usize) -> (&str, usize) {
        let function = self.changes[index].function.as_str();
        let before = self.changes[..index].iter();
        (
            function,
            before.filter(|change| change.function == function).count(),
        )
    }

    /// The change that [`Kernel::place_of`] would say this of.
    pub fn index_of(&self, function: &str, ordinal: usize) -> Option<usize> {
        let changes = self.changes.iter().enumerate();
        let mut those = changes.filter(|(_, change)| change.function == function);
        those.nth(ordinal).map(|(index, _)| index)
    }

    /// The kernel as it is, written and bounded as mutants are.
    pub fn original(&self) -> Result<String, String> {
        self.write(self.module.clone())
    }

    /// A mutant; an error where the change gives no valid kernel.
    pub fn mutant(&self, index: usize) -> Result<Mutant, String> {
        let Described { what, change, .. } = &self.changes[index];
        let mut module = self.module.clone();
        match change {
            Change::Expression(place, handle, new) => {
                *function(&mut module, *place).expressions.get_mut(*handle) = new.clone();
            }
            Change::Constant(handle, new) => {
                *module.global_expressions.get_mut(*handle) = new.clone();
            }
            Change::Drop(place, index) => {
                let mut left = *index;
                drop_statement(&mut function(&mut module, *place).body, &mut left);
            }
            Change::Swap(place, index) => {
                let mut left = *index;
                swap_ways(&mut function(&mut module, *place).body, &mut left);
            }
        }
        Ok(Mutant {
            what: what.clone(),
            text: self.write(module)?,
        })
    }

    fn write(&self, mut module: Module) -> Result<String, String> {
        bound_loops(&mut module);
        leave_names_to_globals(&mut module);
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::all());
        let info = validator.validate(&module).map_err(|e| e.to_string())?;
        let flags = naga::back::wgsl::WriterFlags::empty();
        let text =
            naga::back::wgsl::write_string(&module, &info, flags).map_err(|e| e.to_string())?;
        // What it says may be an error where it is read again, such as a constant that overflows.
        let read = naga::front::wgsl::parse_str(&text).map_err(|e| e.emit_to_string(&text))?;
        validator.validate(&read).map_err(|e| e.to_string())?;
        Ok(text)
    }

    /// Everything that runs: `main` and what it calls.
    fn places(&self) -> Vec<Place> {
        let mut found = vec![Place::Main];
        let mut next = 0;
        while let Some(&place) = found.get(next) {
            next += 1;
            let mut called = Vec::new();
            visit(&self.function(place).body, &mut |statement| {
                if let Statement::Call { function, .. } = statement {
                    called.push(Place::Function(*function));
                }
            });
            for place in called {
                if !found.contains(&place) {
                    found.push(place);
                }
            }
        }
        found
    }

    fn function(&self, place: Place) -> &Function {
        match place {
            Place::Main => &self.module.entry_points[0].function,
            Place::Function(handle) => &self.module.functions[handle],
        }
    }

    fn find(&self) -> Vec<Described> {
        let mut changes = Vec::new();
        let mut counts = false;
        for place in self.places() {
            visit(&self.function(place).body, &mut |statement| {
                counts |= matches!(statement, Statement::Atomic { .. });
            });
        }
        let mut constants = BTreeSet::new();
        for place in self.places() {
            let function = self.function(place);
            let name = function.name.as_deref().unwrap_or("main");
            let used = used(function);
            for (handle, expression) in function.expressions.iter() {
                if let Expression::Constant(constant) = expression {
                    constants.insert(*constant);
                }
                if !used.contains(&handle) {
                    continue;
                }
                let line = self.line(function.expressions.get_span(handle));
                for (what, new) in alternatives(function, expression) {
                    if self.is_equivalent(function, expression, &new) {
                        continue;
                    }
                    let change = Change::Expression(place, handle, new);
                    changes.push(Described {
                        what: format!("{name}: {what}: {line}"),
                        function: name.into(),
                        change,
                    });
                }
            }
            let mut index = 0;
            visit_spans(&function.body, &mut |statement, span| {
                let line = self.line(span);
                let mut add = |what: &str, change| {
                    changes.push(Described {
                        what: format!("{name}: {what}: {line}"),
                        function: name.into(),
                        change,
                    });
                };
                match statement {
                    // What `&&` and `||` are lowered to writes this into a variable that is false already.
                    Statement::Store { pointer, value } if is_false(function, *pointer, *value) => {
                    }
                    Statement::Store { .. } | Statement::ImageStore { .. } => {
                        add("no store", Change::Drop(place, index));
                    }
                    Statement::ControlBarrier(_) => add("no barrier", Change::Drop(place, index)),
                    Statement::Atomic { result: None, .. } => {
                        add("no atomic", Change::Drop(place, index));
                    }
                    Statement::Call { result: None, .. } => {
                        add("no call", Change::Drop(place, index));
                    }
                    // A thread beyond the end does what the last one does, unless it counts.
                    Statement::Return { value: None } if place == Place::Main && !counts => {}
                    Statement::Return { value: None } if index > 0 => {
                        add("no return", Change::Drop(place, index));
                    }
                    Statement::If { .. } => add("the other way", Change::Swap(place, index)),
                    _ => {}
                }
                index += 1;
            });
        }
        for constant in constants {
            let constant = &self.module.constants[constant];
            let (name, handle) = (constant.name.as_deref().unwrap_or_default(), constant.init);
            let line = self.line(self.module.global_expressions.get_span(handle));
            if let Expression::Literal(literal) = self.module.global_expressions[handle] {
                for (what, new) in literals(literal) {
                    changes.push(Described {
                        what: format!("constant {name}: {what}: {line}"),
                        function: format!("constant {name}"),
                        change: Change::Constant(handle, Expression::Literal(new)),
                    });
                }
            }
        }
        changes
    }

    /// Changes that change nothing, since what is beyond the end of a buffer is its last element: the bound of a guard
    /// against the length, and the index into a buffer of which only the first element is used.
    fn is_equivalent(&self, function: &Function, old: &Expression, new: &Expression) -> bool {
        match (old, new) {
            (
                Expression::Binary { right, .. },
                Expression::Binary {
                    op: BinaryOperator::Greater | BinaryOperator::LessEqual,
                    ..
                },
            ) => matches!(function.expressions[*right], Expression::ArrayLength(_)),
            (Expression::AccessIndex { base, index: 0 }, Expression::AccessIndex { .. }) => {
                let Expression::GlobalVariable(global) = function.expressions[*base] else {
                    return false;
                };
                let ty = self.module.global_variables[global].ty;
                matches!(self.module.types[ty].inner, TypeInner::Array { .. })
            }
            _ => false,
        }
    }

    /// The line of the source that something is from.
    fn line(&self, span: Span) -> String {
        let Some(range) = span.to_range() else {
            return String::new();
        };
        let start = range.start.min(self.source.len());
        let from = self.source[..start].rfind('\n').map_or(0, |at| at + 1);
        let to = self.source[start..]
            .find('\n')
            .map_or(self.source.len(), |at| start + at);
        self.source[from..to].trim().to_owned()
    }
}

fn function(module: &mut Module, place: Place) -> &mut Function {
    match place {
        Place::Main => &mut module.entry_points[0].function,
        Place::Function(handle) => module.functions.get_mut(handle),
    }
}

/// A store of `false` into a variable that has no value yet.
fn is_false(function: &Function, pointer: Handle<Expression>, value: Handle<Expression>) -> bool {
    let Expression::LocalVariable(variable) = function.expressions[pointer] else {
        return false;
    };
    let has_name = function.local_variables[variable].name.is_some();
    let stores_false = matches!(
        function.expressions[value],
        Expression::Literal(Literal::Bool(false))
    );
    !has_name && stores_false
}

/// Expressions that something refers to.
fn used(function: &Function) -> BTreeSet<Handle<Expression>> {
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

/// What an expression may become, with a description.
fn alternatives(function: &Function, expression: &Expression) -> Vec<(String, Expression)> {
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
        // The field or component beside it; of another type, it is no valid kernel.
        Expression::AccessIndex { base, index } => {
            let beside = if index == 0 { 1 } else { index - 1 };
            let new = Expression::AccessIndex {
                base,
                index: beside,
            };
            vec![(format!("index {index} to {beside}"), new)]
        }
        _ => Vec::new(),
    }
}

fn literals(literal: Literal) -> Vec<(String, Literal)> {
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

/// Visits statements depth first.
fn visit(block: &Block, seen: &mut impl FnMut(&Statement)) {
    visit_spans(block, &mut |statement, _| seen(statement));
}

fn visit_spans(block: &Block, seen: &mut impl FnMut(&Statement, Span)) {
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

/// The blocks within a statement, in the order in which they are visited.
fn blocks(statement: &mut Statement) -> Vec<&mut Block> {
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
fn drop_statement(block: &mut Block, left: &mut usize) -> bool {
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

fn swap_ways(block: &mut Block, left: &mut usize) -> bool {
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

/// Ports are found by the names of globals, so nothing else may have one of theirs: the writer renames what collides.
fn leave_names_to_globals(module: &mut Module) {
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
fn bound_loops(module: &mut Module) {
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
