//! Declares a twin: one small stage that runs a WGSL function and its Rust twin over the same inputs.
//!
//! An input and an output are words, so that any bits pass, and nothing is converted on the way. Both sides read and write
//! them by the layouts of the Rust types, from which the device kernel is made.
use super::inputs::Draw;
use gibs_graph::bytemuck::{self, Pod};
use gibs_graph::{Element, Graph, Layout, Scalar};
use std::fmt::Write as _;

/// How far apart the two may be, in steps between neighbouring floats, and why. Words that are no floats are always equal.
#[derive(Clone, Copy, Debug)]
pub struct Bound {
    /// Name in tables.
    pub name: &'static str,
    /// On a device that rounds each of `+ - * / sqrt` correctly and fuses none.
    pub steps: u64,
    /// On any other device that keeps to the standards; `None` where no number can be derived.
    pub elsewhere: Option<u64>,
    /// Where these come from.
    pub reason: &'static str,
}

/// See its reason.
pub const EXACT: Bound = Bound {
    name: "exact",
    steps: 0,
    elsewhere: Some(0),
    reason: "integers, bits, comparisons, and sums and products that nothing can be fused with, which Vulkan has rounded \
             correctly: equal on every device",
};

/// See its reason.
pub const ROUNDED: Bound = Bound {
    name: "rounded",
    steps: 0,
    elsewhere: None,
    reason: "`+ - * / sqrt` in the same order in both languages: equal where each is rounded correctly by itself. Other \
             devices may fuse a product with a sum, and divide and take roots less precisely; where what follows cancels or \
             compares, no number bounds what that makes of it, so that it is reported and not judged",
};

/// See its reason.
pub const DIVIDED: Bound = Bound {
    name: "divided",
    steps: 0,
    elsewhere: Some(3),
    reason: "ends in one quotient of numbers that are the same on every device: equal where it is rounded correctly; \
             Vulkan allows 2.5 ULP, and half of one is our own rounding, so that 3 steps elsewhere",
};

/// See its reason.
pub const ROOT: Bound = Bound {
    name: "root",
    steps: 0,
    elsewhere: Some(7),
    reason: "one root: equal where it is rounded correctly. Vulkan derives it from `1.0 / inversesqrt(x)`: 2 ULP of that, \
             which are up to 4 of the root, 2.5 of the quotient and half of one of our own rounding: 7 steps elsewhere",
};

/// All of them.
pub const BOUNDS: [&Bound; 4] = [&EXACT, &ROUNDED, &DIVIDED, &ROOT];

/// What is right, where that is known better than in `f32`.
#[derive(Clone, Copy)]
pub struct Truth {
    /// What each of the results is, and over which inputs it is held to that.
    pub what: &'static [&'static str],
    /// The results of a case.
    pub of: fn(&[u32]) -> Vec<f64>,
    /// Largest error allowed, in units of the last place of the truth, and why.
    pub most: f64,
    /// Where that comes from.
    pub reason: &'static str,
}

/// A function in two languages.
pub struct Twin {
    /// Name in tables.
    pub name: &'static str,
    /// `module::function` of each WGSL function that it tests.
    pub of: &'static [&'static str],
    /// Layout of the result.
    pub out: Layout,
    /// Cases to run.
    pub cases: u32,
    /// Words of a case.
    pub words: usize,
    /// Appends a case.
    pub draw: fn(&mut Draw, &mut Vec<u32>),
    /// The graph for so many cases.
    pub graph: fn(u32) -> Graph,
    /// Further buffers that both sides read, and what is in them.
    pub globals: Vec<(&'static str, Vec<u8>)>,
    /// How far apart they may be.
    pub bound: Bound,
    /// What is right, where that is known.
    pub truth: Option<Truth>,
}

/// The parts of a device kernel.
pub struct Kernel<'a> {
    /// Its functions under test, as `module::function`.
    pub of: &'a [&'a str],
    /// What else it imports.
    pub uses: &'a [&'a str],
    /// Further declarations.
    pub text: &'a str,
    /// Arguments.
    pub arguments: &'a [(&'a str, Layout)],
    /// Result.
    pub out: Layout,
    /// Expression, or statements with a `return`.
    pub body: &'a str,
    /// Further buffers.
    pub globals: &'a [(&'a str, Layout)],
}

impl Kernel<'_> {
    /// Its WGSL.
    pub fn wgsl(&self) -> String {
        let mut text = String::new();
        let mut types = Vec::new();
        let layouts = self.arguments.iter().chain(self.globals).map(|(_, l)| l);
        for layout in layouts.chain([&self.out]) {
            structs(layout, &mut types);
        }
        let mut imports: Vec<String> = self
            .of
            .iter()
            .chain(self.uses)
            .map(|s| (*s).into())
            .collect();
        imports.extend(types.iter().map(|name| format!("types::{name}")));
        imports.sort();
        imports.dedup();
        for path in imports {
            let _ = writeln!(text, "import package::{path};");
        }
        let words: u32 = self.arguments.iter().map(|(_, l)| l.size() / 4).sum();
        let out = self.out.size() / 4;
        let _ = writeln!(
            text,
            "@group(0) @binding(0) var<storage, read> source: array<array<u32, {words}>>;\n\
             @group(0) @binding(1) var<storage, read_write> target_: array<array<u32, {out}>>;"
        );
        for (index, (name, layout)) in (2..).zip(self.globals) {
            let _ = writeln!(
                text,
                "@group(0) @binding({index}) var<storage, read> {name}: array<{layout}>;"
            );
        }
        let parameters = self
            .arguments
            .iter()
            .map(|(name, layout)| format!("{name}: {layout}"));
        let parameters: Vec<_> = parameters.collect();
        let body = if self.body.contains("return ") {
            self.body.into()
        } else {
            format!("return {};", self.body)
        };
        let _ = writeln!(
            text,
            "{}\nfn twin({}) -> {} {{ {body} }}\n\
             @compute @workgroup_size(64)\n\
             fn main(@builtin(global_invocation_id) id: vec3<u32>) {{\n\
             let i = id.x;\n\
             if i >= arrayLength(&source) {{ return; }}",
            self.text,
            parameters.join(", "),
            self.out
        );
        let mut at = 0;
        let loaded = self.arguments.iter().map(|(_, layout)| {
            let value = load(layout, at);
            at += layout.size() / 4;
            value
        });
        let loaded: Vec<_> = loaded.collect();
        let _ = writeln!(text, "let result = twin({});", loaded.join(", "));
        store(&self.out, "result", 0, &mut text);
        text.push_str("}\n");
        text
    }
}

fn structs(layout: &Layout, names: &mut Vec<String>) {
    match layout {
        Layout::Struct { name, fields, .. } => {
            names.push(name.clone());
            fields
                .iter()
                .for_each(|field| structs(&field.layout, names));
        }
        Layout::Array { element, .. } => structs(element, names),
        _ => {}
    }
}

/// The expression of a value whose first word is `source[i][at]`.
fn load(layout: &Layout, at: u32) -> String {
    let parts = |parts: Vec<String>| format!("{layout}({})", parts.join(", "));
    match layout {
        Layout::Scalar(Scalar::U32) => format!("source[i][{at}]"),
        Layout::Scalar(scalar) => format!("bitcast<{}>(source[i][{at}])", scalar.name()),
        Layout::Vector(scalar, n) => {
            let part = |k| load(&Layout::Scalar(*scalar), at + k);
            parts((0..*n).map(part).collect())
        }
        Layout::Array {
            element,
            count,
            stride,
        } => parts(
            (0..*count)
                .map(|k| load(element, at + k * stride / 4))
                .collect(),
        ),
        Layout::Struct { fields, .. } => {
            let part = |f: &gibs_graph::Field| load(&f.layout, at + f.offset / 4);
            parts(fields.iter().map(part).collect())
        }
        _ => unreachable!("a layout that is not known"),
    }
}

/// Statements that write `value` from `target_[i][at]` on.
fn store(layout: &Layout, value: &str, at: u32, text: &mut String) {
    match layout {
        Layout::Scalar(Scalar::U32) => {
            let _ = writeln!(text, "target_[i][{at}] = {value};");
        }
        Layout::Scalar(_) => {
            let _ = writeln!(text, "target_[i][{at}] = bitcast<u32>({value});");
        }
        Layout::Vector(scalar, n) => {
            for (k, axis) in (0..*n).zip(["x", "y", "z", "w"]) {
                store(
                    &Layout::Scalar(*scalar),
                    &format!("{value}.{axis}"),
                    at + k,
                    text,
                );
            }
        }
        Layout::Array {
            element,
            count,
            stride,
        } => {
            for k in 0..*count {
                store(element, &format!("{value}[{k}]"), at + k * stride / 4, text);
            }
        }
        Layout::Struct { fields, .. } => {
            for f in fields {
                store(
                    &f.layout,
                    &format!("{value}.{}", f.name),
                    at + f.offset / 4,
                    text,
                );
            }
        }
        _ => unreachable!("a layout that is not known"),
    }
}

/// Of each word of a layout, whether it is a float.
pub fn floats(layout: &Layout) -> Vec<bool> {
    match layout {
        Layout::Scalar(scalar) => vec![*scalar == Scalar::F32],
        Layout::Vector(scalar, n) => vec![*scalar == Scalar::F32; *n as usize],
        Layout::Array { element, count, .. } => floats(element).repeat(*count as usize),
        Layout::Struct { fields, .. } => fields.iter().flat_map(|f| floats(&f.layout)).collect(),
        _ => unreachable!("a layout that is not known"),
    }
}

/// The next argument of a case.
pub fn take<T: Element>(words: &[u32], at: &mut usize) -> T {
    let first = *at;
    *at += size_of::<T>() / 4;
    bytemuck::pod_read_unaligned(bytemuck::cast_slice(&words[first..*at]))
}

/// A value as other plain data of its size.
pub fn recast<A: Pod, B: Pod>(value: &A) -> B {
    bytemuck::pod_read_unaligned(bytemuck::bytes_of(value))
}
