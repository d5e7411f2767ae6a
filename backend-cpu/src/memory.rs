//! Memory of resources: aligned to cache lines, zeroed.
use gibs_graph::{BackendError, Initial, Kind, Resource};
use std::alloc::Layout;
use std::ptr::NonNull;

/// Alignment of small allocations: a cache line, the strictest that elements have.
const LINE: usize = 64;

/// Allocations from this size on ask for pages of this size: random access to large scenes is bound by the translation
/// of addresses otherwise.
const HUGE: usize = 2 << 20;

/// One allocation of a resource.
pub(crate) struct Memory {
    start: NonNull<u8>,
    layout: Layout,
    bytes: usize,
}

// SAFETY: a Memory owns its bytes as a Vec does.
unsafe impl Send for Memory {}
// SAFETY: as above; writing needs `&mut`.
unsafe impl Sync for Memory {}

impl Memory {
    fn zeroed(resource: &Resource) -> Result<Self, BackendError> {
        let oom = || BackendError::OutOfMemory {
            device: "cpu".into(),
            resource: resource.key.clone(),
            bytes: resource.bytes,
        };
        let bytes = usize::try_from(resource.bytes).map_err(|_| oom())?;
        let align = if bytes < HUGE { LINE } else { HUGE };
        let size = bytes
            .max(1)
            .checked_next_multiple_of(LINE)
            .ok_or_else(oom)?;
        let layout = Layout::from_size_align(size, align).map_err(|_| oom())?;
        // SAFETY: the size is not zero.
        let start = NonNull::new(unsafe { std::alloc::alloc(layout) }).ok_or_else(oom)?;
        if align == HUGE {
            advise_huge_pages(start, size);
        }
        // SAFETY: the allocation has `size` bytes.
        unsafe { start.write_bytes(0, size) };
        Ok(Self {
            start,
            layout,
            bytes,
        })
    }

    pub fn bytes(&self) -> &[u8] {
        // SAFETY: the allocation is initialized and at least `bytes` long.
        unsafe { std::slice::from_raw_parts(self.start.as_ptr(), self.bytes) }
    }

    pub fn bytes_mut(&mut self) -> &mut [u8] {
        // SAFETY: as in `bytes`; `&mut self` makes it the only reference.
        unsafe { std::slice::from_raw_parts_mut(self.start.as_ptr(), self.bytes) }
    }
}

impl Drop for Memory {
    fn drop(&mut self) {
        // SAFETY: allocated with this layout, freed once.
        unsafe { std::alloc::dealloc(self.start.as_ptr(), self.layout) };
    }
}

/// Asks the system for large pages, which it may refuse: nothing depends on it but speed.
#[cfg(target_os = "linux")]
fn advise_huge_pages(start: NonNull<u8>, size: usize) {
    // SAFETY: the range is one live allocation; the advice changes no contents.
    unsafe { libc::madvise(start.as_ptr().cast(), size, libc::MADV_HUGEPAGE) };
}

#[cfg(not(target_os = "linux"))]
fn advise_huge_pages(_: NonNull<u8>, _: usize) {}

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
