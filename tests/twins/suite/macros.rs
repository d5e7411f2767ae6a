//! The macro that makes a stage of a function in two languages.

/// Declares a module with the stage and `twin()`, see [`Twin`](super::declare::Twin):
///
/// ```text
/// twin! {
///     name ["module::function", ..], (argument: Type, ..) -> Type,
///     wgsl "expression, or statements with a return",
///     rust expression,
///     draw |d| (argument, ..),
///     bound ROUNDED,
///     // And, where they are needed, in this order:
///     uses ["module::what else is imported"],
///     text "further WGSL declarations",
///     features ["for conditional parts"],
///     globals { port: Type = vec![..] },
///     truth Truth { .. },
///     cases 1000,
/// }
/// ```
macro_rules! twin {
    (
        $name:ident [$($of:literal),* $(,)?], ($($arg:ident : $ty:ty),* $(,)?) -> $out:ty,
        wgsl $wgsl:expr,
        rust $rust:expr,
        draw $draw:expr,
        bound $bound:expr
        $(, uses [$($uses:literal),* $(,)?])?
        $(, text $text:expr)?
        $(, features [$($feature:literal),* $(,)?])?
        $(, globals { $($global:ident : $gty:ty = $content:expr),* $(,)? })?
        $(, truth $truth:expr)?
        $(, cases $cases:expr)?
        $(,)?
    ) => {
        mod $name {
            use super::*;
            use gibs_graph::{Element, Graph, WgslSource, Workgroup, bytemuck};
            use std::sync::OnceLock;
            use $crate::suite::declare::{Kernel, Twin, recast, take};
            use $crate::suite::inputs::Draw;

            const IN: usize = (0 $(+ size_of::<$ty>())*) / 4;
            const OUT: usize = size_of::<$out>() / 4;
            const OF: &[&str] = &[$($of),*];
            static TEXT: OnceLock<String> = OnceLock::new();

            gibs_graph::stage! {
                /// Runs the function on every case.
                pub stage Cases {
                    wgsl: source(),
                    workgroup: [64, 1, 1],
                    ports: {
                        read source: [u32; IN],
                        write target_: [u32; OUT],
                        $($(read $global: $gty,)*)?
                    },
                    cpu: kernel,
                    wide: None,
                }
            }

            fn source() -> WgslSource {
                let kernel = Kernel {
                    of: OF,
                    uses: &[$($($uses),*)?],
                    text: [$($text,)? ""][0],
                    arguments: &[$((stringify!($arg), <$ty>::layout())),*],
                    out: <$out>::layout(),
                    body: $wgsl,
                    globals: &[$($((stringify!($global), <$gty>::layout())),*)?],
                };
                WgslSource {
                    name: stringify!($name),
                    text: TEXT.get_or_init(|| kernel.wgsl()),
                    modules: gibs_shaders::MODULES,
                    features: &[$($($feature),*)?],
                }
            }

            fn kernel(p: &Views<'_>, group: Workgroup) {
                $($(
                    let $global: &[$gty] = p.$global.slice();
                    // Some are there for the device kernel alone.
                    let _ = $global;
                )*)?
                for i in group.range(p.source.len() as u32) {
                    let (words, mut at) = (&p.source[i], 0);
                    $(let $arg: $ty = take(words, &mut at);)*
                    let out: $out = $rust;
                    debug_assert_eq!(at, IN);
                    p.target_.set(i, recast(&out));
                }
            }

            fn graph(cases: u32) -> Graph {
                let mut g = Graph::new(stringify!($name));
                let source = g.input("source", u64::from(cases));
                let target_ = g.transient("target", u64::from(cases));
                $($(
                    let content: Vec<$gty> = $content;
                    let $global = g.input(stringify!($global), content.len() as u64);
                )*)?
                let inputs = Inputs { source: &source, target_, $($($global: &$global),*)? };
                let size = gibs_graph::Dispatch::Elements(u64::from(cases));
                let out = g.add::<Cases>("twin", inputs, size);
                g.output("target", &out.target_);
                g
            }

            fn draw(d: &mut Draw, words: &mut Vec<u32>) {
                let draw: fn(&mut Draw) -> ($($ty,)*) = $draw;
                let ($($arg,)*) = draw(d);
                $(words.extend_from_slice(bytemuck::cast_slice(bytemuck::bytes_of(&$arg)));)*
            }

            /// The twin.
            pub fn twin() -> Twin {
                Twin {
                    name: stringify!($name),
                    of: OF,
                    out: <$out>::layout(),
                    cases: [$($cases,)? $crate::suite::run::CASES][0],
                    words: IN,
                    draw,
                    graph,
                    globals: vec![$($({
                        let content: Vec<$gty> = $content;
                        (stringify!($global), bytemuck::cast_slice(&content).to_vec())
                    }),*)?],
                    bound: $bound,
                    truth: [$(Some($truth),)? None][0],
                }
            }
        }
    };
}

/// All twins of a family: `twins!(name, ..)` of those declared in the module.
macro_rules! twins {
    ($($name:ident),* $(,)?) => {
        /// All of this family.
        pub fn all() -> Vec<$crate::suite::declare::Twin> {
            vec![$($name::twin()),*]
        }
    };
}
