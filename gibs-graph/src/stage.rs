//! Stages: ports declared once, from which everything else follows.
use crate::{
    Access, Buffer, Element, Image, KernelSource, Port, Previous, Recorder, Sampled, Stored,
};

/// A kind of stage. Implemented by [`stage!`](crate::stage!), never by hand.
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
    fn bind(recorder: &mut Recorder<'_>, inputs: Self::Inputs<'_>) -> Self::Outputs;
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
#[macro_export]
macro_rules! stage {
    (
        $(#[$meta:meta])*
        pub stage $name:ident {
            wgsl: $wgsl:expr,
            workgroup: $workgroup:expr,
            ports: { $($access:ident $port:ident : $ty:ty),* $(,)? },
            cpu: $cpu:path,
            wide: $wide:expr $(,)?
        }
    ) => {
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
            /// Views of bindings that come in the order of the ports, for the workgroup with linear index `group`.
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
                vec![$($crate::Port {
                    name: stringify!($port),
                    access: $crate::__stage_access!($access),
                    element: $crate::__stage_element!($access $ty),
                    image: $crate::__stage_image!($access $ty),
                    optional: $crate::__stage_optional!($access),
                },)*]
            }

            fn kernel() -> $crate::KernelSource {
                fn entry(raw: &[$crate::RawView<'_>], group: $crate::Workgroup) {
                    $cpu(&Views::bind(raw, group.linear()), group);
                }
                let wide: Option<fn(&Views<'_>, $crate::Workgroup)> = $wide;
                $crate::KernelSource {
                    wgsl: $wgsl,
                    cpu: entry,
                    cpu_wide: wide.map(|_| {
                        fn wide_entry(raw: &[$crate::RawView<'_>], group: $crate::Workgroup) {
                            let wide: Option<fn(&Views<'_>, $crate::Workgroup)> = $wide;
                            if let Some(kernel) = wide {
                                kernel(&Views::bind(raw, group.linear()), group);
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

#[doc(hidden)]
#[macro_export]
macro_rules! __stage_input {
    ($g:lifetime uniform $ty:ty) => { &$g $crate::Buffer<$ty> };
    ($g:lifetime read $ty:ty) => { &$g $crate::Buffer<$ty> };
    ($g:lifetime host_only $ty:ty) => { &$g $crate::Buffer<$ty> };
    ($g:lifetime previous $ty:ty) => { &$g $crate::Previous<$ty> };
    ($g:lifetime write $ty:ty) => { $crate::Buffer<$ty> };
    ($g:lifetime read_write $ty:ty) => { $crate::Buffer<$ty> };
    ($g:lifetime atomic $ty:ty) => { $crate::Buffer<$ty> };
    ($g:lifetime sampled $ty:ty) => { &$g $crate::Image<$ty> };
    ($g:lifetime stored $ty:ty) => { $crate::Image<$ty> };
    ($g:lifetime optional_read $ty:ty) => { Option<&$g $crate::Buffer<$ty>> };
    ($g:lifetime optional_write $ty:ty) => { Option<$crate::Buffer<$ty>> };
    ($g:lifetime optional_read_write $ty:ty) => { Option<$crate::Buffer<$ty>> };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __stage_view {
    ($a:lifetime uniform $ty:ty) => { &$a $ty };
    ($a:lifetime read $ty:ty) => { $crate::ReadView<$a, $ty> };
    ($a:lifetime host_only $ty:ty) => { $crate::ReadView<$a, $ty> };
    ($a:lifetime previous $ty:ty) => { $crate::ReadView<$a, $ty> };
    ($a:lifetime write $ty:ty) => { $crate::WriteView<$a, $ty> };
    ($a:lifetime read_write $ty:ty) => { $crate::WriteView<$a, $ty> };
    ($a:lifetime atomic $ty:ty) => { $crate::AtomicView<$a> };
    ($a:lifetime sampled $ty:ty) => { $crate::ImageView<$a, $ty> };
    ($a:lifetime stored $ty:ty) => { $crate::ImageStore<$a, $ty> };
    ($a:lifetime optional_read $ty:ty) => { $crate::ReadView<$a, $ty> };
    ($a:lifetime optional_write $ty:ty) => { $crate::WriteView<$a, $ty> };
    ($a:lifetime optional_read_write $ty:ty) => { $crate::WriteView<$a, $ty> };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __stage_access {
    (uniform) => {
        $crate::Access::Uniform
    };
    (read) => {
        $crate::Access::Read
    };
    (host_only) => {
        $crate::Access::HostOnly
    };
    (previous) => {
        $crate::Access::Previous
    };
    (write) => {
        $crate::Access::Write
    };
    (read_write) => {
        $crate::Access::ReadWrite
    };
    (atomic) => {
        $crate::Access::Atomic
    };
    (sampled) => {
        $crate::Access::Sampled
    };
    (stored) => {
        $crate::Access::Stored
    };
    (optional_read) => {
        $crate::Access::Read
    };
    (optional_write) => {
        $crate::Access::Write
    };
    (optional_read_write) => {
        $crate::Access::ReadWrite
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __stage_optional {
    (optional_read) => {
        true
    };
    (optional_write) => {
        true
    };
    (optional_read_write) => {
        true
    };
    ($access:ident) => {
        false
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __stage_element {
    (sampled $ty:ty) => {
        <$ty as $crate::Texel>::FORMAT.value()
    };
    (stored $ty:ty) => {
        <$ty as $crate::Texel>::FORMAT.value()
    };
    ($access:ident $ty:ty) => {
        <$ty as $crate::Element>::layout()
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __stage_image {
    (sampled $ty:ty) => {
        Some(<$ty as $crate::Texel>::FORMAT)
    };
    (stored $ty:ty) => {
        Some(<$ty as $crate::Texel>::FORMAT)
    };
    ($access:ident $ty:ty) => {
        None
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __stage_bind_view {
    (uniform $ty:ty, $next:ident, $group:ident, $port:ident) => {
        &$crate::ReadView::<$ty>::of($crate::next_view(&mut $next, stringify!($port))).slice()[0]
    };
    (write $ty:ty, $next:ident, $group:ident, $port:ident) => {
        $crate::WriteView::of($crate::next_view(&mut $next, stringify!($port)), $group)
    };
    (read_write $ty:ty, $next:ident, $group:ident, $port:ident) => {
        $crate::WriteView::of($crate::next_view(&mut $next, stringify!($port)), $group)
    };
    (optional_write $ty:ty, $next:ident, $group:ident, $port:ident) => {
        $crate::WriteView::of($crate::next_view(&mut $next, stringify!($port)), $group)
    };
    (optional_read_write $ty:ty, $next:ident, $group:ident, $port:ident) => {
        $crate::WriteView::of($crate::next_view(&mut $next, stringify!($port)), $group)
    };
    (atomic $ty:ty, $next:ident, $group:ident, $port:ident) => {
        $crate::AtomicView::of($crate::next_view(&mut $next, stringify!($port)))
    };
    (sampled $ty:ty, $next:ident, $group:ident, $port:ident) => {
        $crate::ImageView::of($crate::next_view(&mut $next, stringify!($port)))
    };
    (stored $ty:ty, $next:ident, $group:ident, $port:ident) => {
        $crate::ImageStore::of($crate::next_view(&mut $next, stringify!($port)), $group)
    };
    ($access:ident $ty:ty, $next:ident, $group:ident, $port:ident) => {
        $crate::ReadView::of($crate::next_view(&mut $next, stringify!($port)))
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __stage_record {
    (write $r:ident, $handle:expr, $port:expr) => {
        $r.write($handle, $port, $crate::Access::Write)
    };
    (read_write $r:ident, $handle:expr, $port:expr) => {
        $r.write($handle, $port, $crate::Access::ReadWrite)
    };
    (atomic $r:ident, $handle:expr, $port:expr) => {
        $r.write($handle, $port, $crate::Access::Atomic)
    };
    (optional_read $r:ident, $handle:expr, $port:expr) => {
        if let Some(handle) = $handle {
            $r.read(handle, $port, $crate::Access::Read)
        }
    };
    (optional_write $r:ident, $handle:expr, $port:expr) => {
        $handle.map(|handle| $r.write(handle, $port, $crate::Access::Write))
    };
    (optional_read_write $r:ident, $handle:expr, $port:expr) => {
        $handle.map(|handle| $r.write(handle, $port, $crate::Access::ReadWrite))
    };
    (previous $r:ident, $handle:expr, $port:expr) => {
        $r.previous($handle, $port)
    };
    (sampled $r:ident, $handle:expr, $port:expr) => {
        $r.sample($handle, $port)
    };
    (stored $r:ident, $handle:expr, $port:expr) => {
        $r.store($handle, $port)
    };
    ($access:ident $r:ident, $handle:expr, $port:expr) => {
        $r.read($handle, $port, $crate::__stage_access!($access))
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __stage_outputs {
    ($name:ident [$($out:ident $oty:tt,)*] write $port:ident : $ty:ty, $($rest:tt)*) => {
        $crate::__stage_outputs!($name [$($out $oty,)* $port ($crate::Buffer<$ty>),] $($rest)*);
    };
    ($name:ident [$($out:ident $oty:tt,)*] read_write $port:ident : $ty:ty, $($rest:tt)*) => {
        $crate::__stage_outputs!($name [$($out $oty,)* $port ($crate::Buffer<$ty>),] $($rest)*);
    };
    ($name:ident [$($out:ident $oty:tt,)*] optional_write $port:ident : $ty:ty, $($rest:tt)*) => {
        $crate::__stage_outputs!($name [$($out $oty,)* $port (Option<$crate::Buffer<$ty>>),] $($rest)*);
    };
    ($name:ident [$($out:ident $oty:tt,)*] optional_read_write $port:ident : $ty:ty, $($rest:tt)*) => {
        $crate::__stage_outputs!($name [$($out $oty,)* $port (Option<$crate::Buffer<$ty>>),] $($rest)*);
    };
    ($name:ident [$($out:ident $oty:tt,)*] stored $port:ident : $ty:ty, $($rest:tt)*) => {
        $crate::__stage_outputs!($name [$($out $oty,)* $port ($crate::Image<$ty>),] $($rest)*);
    };
    ($name:ident [$($out:ident $oty:tt,)*] atomic $port:ident : $ty:ty, $($rest:tt)*) => {
        $crate::__stage_outputs!($name [$($out $oty,)* $port ($crate::Buffer<$ty>),] $($rest)*);
    };
    ($name:ident [$($out:ident $oty:tt,)*] $access:ident $port:ident : $ty:ty, $($rest:tt)*) => {
        $crate::__stage_outputs!($name [$($out $oty,)*] $($rest)*);
    };
    ($name:ident [$($out:ident $oty:tt,)*]) => {
        #[doc = concat!("Versions that [`", stringify!($name), "`] makes.")]
        #[allow(missing_docs)]
        pub struct Outputs {
            $(pub $out: $oty,)*
        }
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __stage_result {
    ([$($out:ident,)*] write $port:ident, $($rest:tt)*) => { $crate::__stage_result!([$($out,)* $port,] $($rest)*) };
    ([$($out:ident,)*] read_write $port:ident, $($rest:tt)*) => { $crate::__stage_result!([$($out,)* $port,] $($rest)*) };
    ([$($out:ident,)*] optional_write $port:ident, $($rest:tt)*) => { $crate::__stage_result!([$($out,)* $port,] $($rest)*) };
    ([$($out:ident,)*] optional_read_write $port:ident, $($rest:tt)*) => { $crate::__stage_result!([$($out,)* $port,] $($rest)*) };
    ([$($out:ident,)*] atomic $port:ident, $($rest:tt)*) => { $crate::__stage_result!([$($out,)* $port,] $($rest)*) };
    ([$($out:ident,)*] stored $port:ident, $($rest:tt)*) => { $crate::__stage_result!([$($out,)* $port,] $($rest)*) };
    ([$($out:ident,)*] $access:ident $port:ident, $($rest:tt)*) => {{
        let () = $port;
        $crate::__stage_result!([$($out,)*] $($rest)*)
    }};
    ([$($out:ident,)*]) => { Outputs { $($out,)* } };
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

impl Recorder<'_> {
    /// Binds a port that reads.
    pub fn read<T: Element>(&mut self, handle: &Buffer<T>, port: &'static str, access: Access) {
        self.bind(
            handle.token,
            handle.resource,
            Some(handle.version),
            port,
            access,
        );
    }

    /// Binds a port that reads the value of the frame before.
    pub fn previous<T: Element>(&mut self, handle: &Previous<T>, port: &'static str) {
        self.bind(handle.token, handle.resource, None, port, Access::Previous);
    }

    /// Binds a port that writes, and gives the version that it makes.
    pub fn write<T: Element>(
        &mut self,
        handle: Buffer<T>,
        port: &'static str,
        access: Access,
    ) -> Buffer<T> {
        self.bind(
            handle.token,
            handle.resource,
            Some(handle.version),
            port,
            access,
        );
        Buffer {
            version: handle.version + 1,
            ..handle
        }
    }

    /// Binds an image that is read.
    pub fn sample<T: Sampled>(&mut self, image: &Image<T>, port: &'static str) {
        self.bind(
            image.token,
            image.resource,
            Some(image.version),
            port,
            Access::Sampled,
        );
    }

    /// Binds an image that is written, and gives the version that it makes.
    pub fn store<T: Stored>(&mut self, image: Image<T>, port: &'static str) -> Image<T> {
        self.bind(
            image.token,
            image.resource,
            Some(image.version),
            port,
            Access::Stored,
        );
        Image {
            version: image.version + 1,
            ..image
        }
    }
}
