//! How long a resource lives, and what it holds first.
use crate::Element;
use serde::Serialize;

/// What a resource is for.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub enum Kind {
    /// Written by the host between frames; keeps its content.
    Input,
    /// Lives within a frame; undefined at its start.
    Transient,
    /// Lives within a frame; zero at its start.
    Zeroed,
    /// Outlives the frame, changed in place.
    State(Initial),
    /// Outlives the frame, in two rotating allocations, so that the frame before can still be read.
    History(Initial),
}

impl Kind {
    /// Allocations of a resource: two for a history.
    pub fn allocations(&self) -> u64 {
        if matches!(self, Kind::History(_)) {
            2
        } else {
            1
        }
    }

    /// The content outlives the frame.
    pub fn persists(&self) -> bool {
        matches!(self, Kind::Input | Kind::State(_) | Kind::History(_))
    }
}

/// Content of a state before the first frame and after a reset.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub enum Initial {
    /// All bytes zero.
    Zero,
    /// 0, 1, 2, ... as `u32`.
    Sequence,
    /// One element, repeated.
    Fill(Vec<u8>),
}

impl Initial {
    /// One element, repeated.
    pub fn fill<T: Element>(value: T) -> Self {
        Initial::Fill(bytemuck::bytes_of(&value).to_vec())
    }

    /// The content of a buffer of `bytes` bytes.
    pub fn bytes(&self, bytes: usize) -> Vec<u8> {
        match self {
            Initial::Zero => vec![0; bytes],
            Initial::Sequence => (0..bytes / 4)
                .flat_map(|i| (i as u32).to_ne_bytes())
                .collect(),
            Initial::Fill(element) => element.iter().copied().cycle().take(bytes).collect(),
        }
    }
}
