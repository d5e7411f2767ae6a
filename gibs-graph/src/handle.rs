//! Handles: one version of one resource of one graph.
use crate::Element;
use std::marker::PhantomData;

/// Identity of a graph, so that handles of different graphs cannot be mixed up unnoticed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct GraphToken(pub(crate) u64);

/// A version of a buffer of `T`.
///
/// Reading borrows the handle; writing consumes it and gives the next version. Handles are neither `Clone` nor
/// `Copy`, so a stale read and a double write do not compile.
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

/// The value that a state had at the end of the frame before. Only read.
#[derive(Debug)]
pub struct Previous<T> {
    pub(crate) token: GraphToken,
    pub(crate) resource: u32,
    pub(crate) len: u64,
    pub(crate) element: PhantomData<fn() -> T>,
}

/// A state that waits for its last version of this frame; see [`crate::Graph::keep`].
#[derive(Debug)]
#[must_use = "a state must be kept, or the frame after has nothing to start from"]
pub struct State<T> {
    pub(crate) token: GraphToken,
    pub(crate) resource: u32,
    pub(crate) element: PhantomData<fn() -> T>,
}
