//! Mutants of a WGSL kernel: its IR with one small thing wrong.
mod alternatives;
mod prepare;
mod walk;

use alternatives::{alternatives, literals};
use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{Expression, Function, Handle, Literal, Module, Span, Statement};
use prepare::{bound_loops, leave_names_to_globals};
use std::collections::BTreeSet;
use walk::{drop_statement, repeated, swap_ways, used, visit, visit_spans};

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

    /// The composed WGSL that it was read from.
    pub fn source(&self) -> &str {
        &self.source
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
                for (what, new) in alternatives(&self.module, function, expression) {
                    let change = Change::Expression(place, handle, new);
                    changes.push(Described {
                        what: format!("{name}: {what}: {line}"),
                        function: name.into(),
                        change,
                    });
                }
            }
            let mut index = 0;
            let repeated = repeated(&function.body);
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
                    // Outside loops, what `&&` is lowered to writes this into a variable that is false already.
                    Statement::Store { pointer, value }
                        if is_false(function, *pointer, *value) && !repeated.contains(&index) => {}
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
                    // What naga has put where a function ends is in no line.
                    Statement::Return { value: None } if !line.is_empty() => {
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
