//! Memory of resources: aligned to cache lines, zeroed.
use gibs_graph::{BackendError, Initial, Kind, Resource};

/// A cache line, the strictest alignment that elements have.
#[repr(C, align(64))]
#[derive(Clone, Copy)]
struct Block([u8; 64]);

/// One allocation of a resource.
pub(crate) struct Memory {
    blocks: Vec<Block>,
    bytes: usize,
}

impl Memory {
    fn zeroed(resource: &Resource) -> Result<Self, BackendError> {
        let oom = || BackendError::OutOfMemory {
            device: "cpu".into(),
            resource: resource.key.clone(),
            bytes: resource.bytes,
        };
        let bytes = usize::try_from(resource.bytes).map_err(|_| oom())?;
        let mut blocks = Vec::new();
        blocks
            .try_reserve_exact(bytes.div_ceil(64))
            .map_err(|_| oom())?;
        blocks.resize(bytes.div_ceil(64), Block([0; 64]));
        Ok(Self { blocks, bytes })
    }

    pub fn bytes(&self) -> &[u8] {
        // SAFETY: the blocks are plain initialized bytes, at least `bytes` of them.
        unsafe { std::slice::from_raw_parts(self.blocks.as_ptr().cast(), self.bytes) }
    }

    pub fn bytes_mut(&mut self) -> &mut [u8] {
        // SAFETY: as in `bytes`; any byte pattern is a valid block.
        unsafe { std::slice::from_raw_parts_mut(self.blocks.as_mut_ptr().cast(), self.bytes) }
    }
}

/// The allocations of one resource: two for a history, one otherwise.
pub(crate) struct Allocation {
    pub current: Memory,
    pub previous: Option<Memory>,
}

impl Allocation {
    pub fn new(resource: &Resource) -> Result<Self, BackendError> {
        let previous = match resource.kind {
            Kind::History(_) => Some(Memory::zeroed(resource)?),
            _ => None,
        };
        let mut made = Self {
            current: Memory::zeroed(resource)?,
            previous,
        };
        made.reset(&resource.kind);
        Ok(made)
    }

    /// Sets states and histories to their initial value.
    pub fn reset(&mut self, kind: &Kind) {
        if let Kind::State(initial) | Kind::History(initial) = kind {
            for memory in std::iter::once(&mut self.current).chain(&mut self.previous) {
                match initial {
                    Initial::Zero => memory.bytes_mut().fill(0),
                    _ => {
                        let bytes = initial.bytes(memory.bytes);
                        memory.bytes_mut().copy_from_slice(&bytes);
                    }
                }
            }
        }
    }

    /// Makes the value of this frame the one of the frame before.
    pub fn rotate(&mut self) {
        if let Some(previous) = &mut self.previous {
            std::mem::swap(&mut self.current, previous);
        }
    }
}
