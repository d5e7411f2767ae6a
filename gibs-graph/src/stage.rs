//! Stages: ports declared once, from which everything else follows.
use crate::{KernelSource, Port, Recorder};

/// A kind of stage. Implemented by [`stage!`](crate::stage!), never by hand: what it takes beyond the documented items
/// may change at any time. Compiling a graph refuses a stage that binds something else than its ports.
pub trait Stage {
    /// One handle per port: borrowed where the stage reads, owned where it writes.
    type Inputs<'g>;
    /// The next version of every port that the stage writes.
    type Outputs;

    /// Type name.
    const NAME: &'static str;

    /// The ports, in declaration order.
    fn ports() -> Vec<Port>;

    /// The implementations.
    fn kernel() -> KernelSource;

    /// Binds handles to ports.
    #[doc(hidden)]
    fn bind(recorder: &mut Recorder<'_>, inputs: Self::Inputs<'_>) -> Self::Outputs;
}

/// What a stage declares, without its type: for code that walks stages, or finds one by its name.
#[derive(Clone, Debug)]
pub struct StageInfo {
    /// Type name.
    pub name: &'static str,
    /// Ports.
    pub ports: Vec<Port>,
    /// Kernels.
    pub kernel: KernelSource,
}

impl StageInfo {
    /// That of a stage.
    pub fn of<S: Stage>() -> Self {
        Self {
            name: S::NAME,
            ports: S::ports(),
            kernel: S::kernel(),
        }
    }
}

/// Declares a stage: its ports, its device kernel and its CPU kernel.
///
/// Generates, in the module that calls it: the marker type, `Inputs<'g>` (handles that go in), `Outputs` (versions
/// that come out), `Views<'a>` (what the CPU kernel sees) and the [`Stage`] implementation. Access words are
/// `uniform`, `read`, `write`, `read_write`, `atomic` (of `u32`), `previous` and `host_only` for buffers, `sampled` and
/// `stored` for images, with a [`Texel`](crate::Texel) as their type; at least one port is read.
///
/// A port that only some frames need is `optional_read`, `optional_write` or `optional_read_write`: its handle is an
/// `Option`. Where it is `None`, the stage has no binding for it, the CPU kernel's view is empty, and the device kernel
/// is composed without the feature of the port's name: put `@if(name)` before the global and what uses it.
///
/// `acceleration` and `optional_acceleration` are for what rays are traced in, [`Graph::acceleration`](crate::Graph::acceleration),
/// of the type [`AccelerationInstance`](crate::AccelerationInstance). With one of them bound, the device kernel is composed with the
/// feature `RAY_QUERY`; what the CPU kernel sees are the instances.
///
/// `=>` behind the type of a port that is written names the [`Comparator`](crate::Comparator) that backends are held to,
/// where it is not [`Comparator::ROUNDING`](crate::Comparator::ROUNDING): `write order: u32 => IN_ANY_ORDER`.
///
/// ```
/// use gibs_graph::{stage, Dispatch, Graph, WgslSource, Workgroup};
///
/// stage! {
///     /// Doubles every number.
///     pub stage Double {
///         wgsl: WgslSource {
///             name: "double",
///             text: "@group(0) @binding(0) var<storage, read> source: array<u32>;
///                    @group(0) @binding(1) var<storage, read_write> target_: array<u32>;
///                    @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
///                        if id.x < arrayLength(&source) { target_[id.x] = 2u * source[id.x]; }
///                    }",
///             modules: &[],
///             features: &[],
///         },
///         workgroup: [64, 1, 1],
///         ports: { read source: u32, write target_: u32 },
///         cpu: kernel,
///         wide: None,
///     }
/// }
///
/// fn kernel(p: &Views<'_>, group: Workgroup) {
///     for i in group.range(p.source.len() as u32) {
///         p.target_.set(i, 2 * p.source[i]);
///     }
/// }
///
/// # fn main() {
/// let mut g = Graph::new("example");
/// let source = g.input::<u32>("source", 100);
/// let target_ = g.transient::<u32>("doubled", 100);
/// let out = g.add::<Double>("double", Inputs { source: &source, target_ }, Dispatch::Elements(100));
/// g.output("doubled", &out.target_);
/// let schedule = g.compile(None).unwrap();
/// assert_eq!(schedule.steps.len(), 1);
/// # }
/// ```
///
/// Any other access word does not compile:
///
/// ```compile_fail
/// use gibs_graph::{stage, WgslSource, Workgroup};
///
/// stage! {
///     /// Misspells `read`.
///     pub stage Double {
///         wgsl: WgslSource { name: "double", text: "", modules: &[], features: &[] },
///         workgroup: [64, 1, 1],
///         ports: { reed source: u32, write target_: u32 },
///         cpu: kernel,
///         wide: None,
///     }
/// }
///
/// fn kernel(_: &Views<'_>, _: Workgroup) {}
/// # fn main() {}
/// ```
#[macro_export]
macro_rules! stage {
    (
        $(#[$meta:meta])*
        pub stage $name:ident {
            wgsl: $wgsl:expr,
            workgroup: $workgroup:expr,
            ports: { $($access:ident $port:ident : $ty:ty $(=> $comparator:expr)?),* $(,)? },
            cpu: $cpu:path,
            wide: $wide:expr $(,)?
        }
    ) => {
        $($crate::__stage_word!($access);)*

        $(#[$meta])*
        #[derive(Clone, Copy, Debug)]
        pub struct $name;

        #[doc = concat!("Handles that go into [`", stringify!($name), "`].")]
        #[allow(missing_docs)]
        pub struct Inputs<'g> {
            $(pub $port: $crate::__stage_input!('g $access $ty),)*
        }

        #[doc = concat!("What the CPU kernel of [`", stringify!($name), "`] sees.")]
        #[allow(missing_docs)]
        pub struct Views<'a> {
            $(pub $port: $crate::__stage_view!('a $access $ty),)*
        }

        impl<'a> Views<'a> {
            /// Views of bindings that come in the order of the ports, for workgroups from the one with linear index `group` on.
            pub fn bind(raw: &[$crate::RawView<'a>], group: u32) -> Self {
                let mut _next = raw.iter().copied();
                let _ = group;
                Self {
                    $($port: $crate::__stage_bind_view!($access $ty, _next, group, $port),)*
                }
            }
        }

        $crate::__stage_outputs!($name [] $($access $port : $ty,)*);

        impl $crate::Stage for $name {
            type Inputs<'g> = Inputs<'g>;
            type Outputs = Outputs;
            const NAME: &'static str = stringify!($name);

            fn ports() -> Vec<$crate::Port> {
                vec![$($crate::Port::new(
                    stringify!($port),
                    $crate::__stage_access!($access),
                    $crate::__stage_element!($access $ty),
                    $crate::__stage_image!($access $ty),
                    $crate::__stage_optional!($access),
                )$(.compared($comparator))?,)*]
            }

            fn kernel() -> $crate::KernelSource {
                fn entry(raw: &[$crate::RawView<'_>], groups: $crate::Workgroups) {
                    let views = Views::bind(raw, groups.first());
                    for group in groups {
                        $cpu(&views, group);
                    }
                }
                let wide: Option<fn(&Views<'_>, $crate::Workgroup)> = $wide;
                $crate::KernelSource {
                    wgsl: $wgsl,
                    cpu: entry,
                    cpu_wide: wide.map(|_| {
                        fn wide_entry(raw: &[$crate::RawView<'_>], groups: $crate::Workgroups) {
                            let wide: Option<fn(&Views<'_>, $crate::Workgroup)> = $wide;
                            if let Some(kernel) = wide {
                                let views = Views::bind(raw, groups.first());
                                for group in groups {
                                    kernel(&views, group);
                                }
                            }
                        }
                        wide_entry as $crate::CpuKernel
                    }),
                    workgroup: $workgroup,
                }
            }

            fn bind(recorder: &mut $crate::Recorder<'_>, inputs: Inputs<'_>) -> Outputs {
                $(let $port = $crate::__stage_record!($access recorder, inputs.$port, stringify!($port));)*
                $crate::__stage_result!([] $($access $port,)*)
            }
        }
    };
}

/// The next binding of a kernel; the executor passes exactly one per declared port.
#[doc(hidden)]
pub fn next_view<'a>(
    views: &mut impl Iterator<Item = crate::RawView<'a>>,
    port: &str,
) -> crate::RawView<'a> {
    views
        .next()
        .unwrap_or_else(|| panic!("the executor passed no binding for port {port}"))
}
