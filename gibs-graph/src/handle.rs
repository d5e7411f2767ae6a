//! Handles: one version of one resource of one graph.
use crate::{Element, Texel};
use std::marker::PhantomData;

/// Identity of a graph, so that handles of different graphs cannot be mixed up unnoticed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct GraphToken(pub(crate) u64);

/// A version of a buffer of `T`.
///
/// Reading borrows the handle; writing consumes it and gives the next version. Handles are neither `Clone` nor
/// `Copy`, so a stale read and a double write do not compile.
///
/// ```
/// # use gibs_graph::{stage, Dispatch, Graph, Initial, WgslSource, Workgroup};
/// # stage! {
/// #     /// Adds `term` to `sum`.
/// #     pub stage Add {
/// #         wgsl: WgslSource { name: "add", text: "", modules: &[], features: &[] },
/// #         workgroup: [64, 1, 1],
/// #         ports: { read term: u32, read_write sum: u32 },
/// #         cpu: add,
/// #         wide: None,
/// #     }
/// # }
/// # fn add(_: &Views<'_>, _: Workgroup) {}
/// # fn main() {
/// # let mut g = Graph::new("example");
/// # let term = g.input::<u32>("term", 8);
/// # let sum = g.zeroed::<u32>("sum", 8);
/// let once = g.add::<Add>("once", Inputs { term: &term, sum }, Dispatch::Elements(8)).sum;
/// let twice = g.add::<Add>("twice", Inputs { term: &term, sum: once }, Dispatch::Elements(8)).sum;
/// g.output("sum", &twice);
/// # assert_eq!(g.compile(None).unwrap().steps.len(), 3);
/// # }
/// ```
///
/// A stale read, of a version that a stage has replaced:
///
/// ```compile_fail,E0382
/// # use gibs_graph::{stage, Dispatch, Graph, Initial, WgslSource, Workgroup};
/// # stage! {
/// #     /// Adds `term` to `sum`.
/// #     pub stage Add {
/// #         wgsl: WgslSource { name: "add", text: "", modules: &[], features: &[] },
/// #         workgroup: [64, 1, 1],
/// #         ports: { read term: u32, read_write sum: u32 },
/// #         cpu: add,
/// #         wide: None,
/// #     }
/// # }
/// # fn add(_: &Views<'_>, _: Workgroup) {}
/// # fn main() {
/// # let mut g = Graph::new("example");
/// # let term = g.input::<u32>("term", 8);
/// # let sum = g.zeroed::<u32>("sum", 8);
/// let once = g.add::<Add>("once", Inputs { term: &term, sum }, Dispatch::Elements(8)).sum;
/// g.output("sum", &sum);
/// # }
/// ```
///
/// A double write, of two stages that would both replace one version:
///
/// ```compile_fail,E0382
/// # use gibs_graph::{stage, Dispatch, Graph, Initial, WgslSource, Workgroup};
/// # stage! {
/// #     /// Adds `term` to `sum`.
/// #     pub stage Add {
/// #         wgsl: WgslSource { name: "add", text: "", modules: &[], features: &[] },
/// #         workgroup: [64, 1, 1],
/// #         ports: { read term: u32, read_write sum: u32 },
/// #         cpu: add,
/// #         wide: None,
/// #     }
/// # }
/// # fn add(_: &Views<'_>, _: Workgroup) {}
/// # fn main() {
/// # let mut g = Graph::new("example");
/// # let term = g.input::<u32>("term", 8);
/// # let sum = g.zeroed::<u32>("sum", 8);
/// let once = g.add::<Add>("once", Inputs { term: &term, sum }, Dispatch::Elements(8)).sum;
/// let other = g.add::<Add>("other", Inputs { term: &term, sum }, Dispatch::Elements(8)).sum;
/// # }
/// ```
///
/// One resource that is read and written by one stage, but not through one port:
///
/// ```compile_fail,E0505
/// # use gibs_graph::{stage, Dispatch, Graph, Initial, WgslSource, Workgroup};
/// # stage! {
/// #     /// Adds `term` to `sum`.
/// #     pub stage Add {
/// #         wgsl: WgslSource { name: "add", text: "", modules: &[], features: &[] },
/// #         workgroup: [64, 1, 1],
/// #         ports: { read term: u32, read_write sum: u32 },
/// #         cpu: add,
/// #         wide: None,
/// #     }
/// # }
/// # fn add(_: &Views<'_>, _: Workgroup) {}
/// # fn main() {
/// # let mut g = Graph::new("example");
/// # let term = g.input::<u32>("term", 8);
/// # let sum = g.zeroed::<u32>("sum", 8);
/// let once = g.add::<Add>("once", Inputs { term: &sum, sum }, Dispatch::Elements(8)).sum;
/// # }
/// ```
///
/// A buffer of another element type:
///
/// ```compile_fail,E0308
/// # use gibs_graph::{stage, Dispatch, Graph, Initial, WgslSource, Workgroup};
/// # stage! {
/// #     /// Adds `term` to `sum`.
/// #     pub stage Add {
/// #         wgsl: WgslSource { name: "add", text: "", modules: &[], features: &[] },
/// #         workgroup: [64, 1, 1],
/// #         ports: { read term: u32, read_write sum: u32 },
/// #         cpu: add,
/// #         wide: None,
/// #     }
/// # }
/// # fn add(_: &Views<'_>, _: Workgroup) {}
/// # fn main() {
/// # let mut g = Graph::new("example");
/// # let term = g.input::<u32>("term", 8);
/// # let sum = g.zeroed::<u32>("sum", 8);
/// let real = g.input::<f32>("real", 8);
/// let once = g.add::<Add>("once", Inputs { term: &real, sum }, Dispatch::Elements(8)).sum;
/// # }
/// ```
#[derive(Debug)]
#[must_use = "a version that nobody reads is dead"]
pub struct Buffer<T> {
    pub(crate) token: GraphToken,
    pub(crate) resource: u32,
    pub(crate) version: u32,
    pub(crate) len: u64,
    pub(crate) element: PhantomData<fn() -> T>,
}

impl<T: Element> Buffer<T> {
    /// Number of elements.
    pub fn len(&self) -> u64 {
        self.len
    }

    /// There are no elements.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }
}

impl<T: Element> Previous<T> {
    /// Number of elements.
    pub fn len(&self) -> u64 {
        self.len
    }

    /// There are no elements.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }
}

/// A version of an image of `T`; see [`Buffer`] for what versions are.
#[derive(Debug)]
#[must_use = "a version that nobody reads is dead"]
pub struct Image<T> {
    pub(crate) token: GraphToken,
    pub(crate) resource: u32,
    pub(crate) version: u32,
    pub(crate) size: [u32; 2],
    pub(crate) texel: PhantomData<fn() -> T>,
}

impl<T: Texel> Image<T> {
    /// Width and height.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }
}

/// The value that a state had at the end of the frame before. Only read.
///
/// A port that writes takes no such handle:
///
/// ```compile_fail,E0308
/// # use gibs_graph::{stage, Dispatch, Graph, Initial, WgslSource, Workgroup};
/// # stage! {
/// #     /// Adds `term` to `sum`.
/// #     pub stage Add {
/// #         wgsl: WgslSource { name: "add", text: "", modules: &[], features: &[] },
/// #         workgroup: [64, 1, 1],
/// #         ports: { read term: u32, read_write sum: u32 },
/// #         cpu: add,
/// #         wide: None,
/// #     }
/// # }
/// # fn add(_: &Views<'_>, _: Workgroup) {}
/// # fn main() {
/// # let mut g = Graph::new("example");
/// # let term = g.input::<u32>("term", 8);
/// # let sum = g.zeroed::<u32>("sum", 8);
/// let (past, before, now) = g.history::<u32>("past", 8, Initial::Zero);
/// let once = g.add::<Add>("once", Inputs { term: &term, sum: before }, Dispatch::Elements(8)).sum;
/// # }
/// ```
#[derive(Debug)]
pub struct Previous<T> {
    pub(crate) token: GraphToken,
    pub(crate) resource: u32,
    pub(crate) len: u64,
    pub(crate) element: PhantomData<fn() -> T>,
}

/// An acceleration structure that stages trace rays in; see [`crate::Graph::acceleration`]. Only read.
#[derive(Debug)]
pub struct Acceleration(pub(crate) Buffer<crate::AccelerationInstance>);

/// A state that waits for its last version of this frame; see [`crate::Graph::keep`].
#[derive(Debug)]
#[must_use = "a state must be kept, or the frame after has nothing to start from"]
pub struct State<T> {
    pub(crate) token: GraphToken,
    pub(crate) resource: u32,
    pub(crate) element: PhantomData<fn() -> T>,
}
