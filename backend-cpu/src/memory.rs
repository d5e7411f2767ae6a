//! Memory of resources: aligned to cache lines, zeroed.
use crate::shares::Shares;
use gibs_graph::{BackendError, Initial, Kind, Resource};
use std::alloc::Layout;
use std::ptr::NonNull;

/// Alignment of small allocations: a cache line, the strictest that elements have.
const LINE: usize = 64;

/// Allocations from this size on ask for pages of this size: random access to large scenes is bound by the translation
/// of addresses otherwise.
const HUGE: usize = 2 << 20;

/// One allocation of a resource. Large ones take no memory before it is written to.
pub(crate) struct Memory {
    /// What was allocated; `start` is the first aligned byte in it.
    allocated: NonNull<u8>,
    layout: Layout,
    start: NonNull<u8>,
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
            bytes: resource.room,
        };
        let bytes = usize::try_from(resource.room).map_err(|_| oom())?;
        let align = if bytes < HUGE { LINE } else { HUGE };
        // Without an alignment of its own, a large zeroed allocation is fresh pages of the system, which are zero.
        let size = bytes.checked_add(align).ok_or_else(oom)?;
        let layout = Layout::from_size_align(size, 1).map_err(|_| oom())?;
        // SAFETY: the size is not zero.
        let allocated =
            NonNull::new(unsafe { std::alloc::alloc_zeroed(layout) }).ok_or_else(oom)?;
        let start = allocated.map_addr(|address| {
            let aligned = address.get().next_multiple_of(align);
            address.saturating_add(aligned - address.get())
        });
        if align == HUGE {
            advise_huge_pages(start, bytes);
        }
        Ok(Self {
            allocated,
            layout,
            start,
            bytes,
        })
    }

    /// Where it begins, for views: unlike a slice's, this pointer stays good when another one is taken.
    pub fn start(&mut self) -> *mut u8 {
        self.start.as_ptr()
    }

    /// Sets the first bytes to zero, on all threads: each clears the part that it will have of a dispatch over them.
    pub fn clear(&mut self, bytes: usize, shares: &mut Shares) {
        const PIECE: usize = 1 << 15;
        let start = Start(self.start);
        let bytes = bytes.min(self.bytes);
        // Fewer than 2^32 pieces, as long as an address has 47 bits.
        shares.run(bytes.div_ceil(PIECE) as u32, |piece| {
            let first = piece as usize * PIECE;
            // SAFETY: the piece lies within the memory, which `&mut self` borrows, and nobody else clears it.
            unsafe { start.at(first).write_bytes(0, PIECE.min(bytes - first)) };
        });
    }

    pub fn bytes(&self) -> &[u8] {
        // SAFETY: the allocation is zeroed and has `bytes` bytes from `start`, which is less than `align` into it.
        unsafe { std::slice::from_raw_parts(self.start.as_ptr(), self.bytes) }
    }

    pub fn bytes_mut(&mut self) -> &mut [u8] {
        // SAFETY: as in `bytes`; `&mut self` makes it the only reference.
        unsafe { std::slice::from_raw_parts_mut(self.start.as_ptr(), self.bytes) }
    }
}

/// A place that threads share.
#[derive(Clone, Copy)]
struct Start(NonNull<u8>);

// SAFETY: it is only a place; who writes where is up to those who do.
unsafe impl Sync for Start {}

impl Start {
    /// # Safety
    /// `offset` lies within the allocation.
    unsafe fn at(self, offset: usize) -> NonNull<u8> {
        // SAFETY: as the caller says.
        unsafe { self.0.add(offset) }
    }
}

impl Drop for Memory {
    fn drop(&mut self) {
        // SAFETY: allocated with this layout, freed once.
        unsafe { std::alloc::dealloc(self.allocated.as_ptr(), self.layout) };
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

    /// Bytes of each of them.
    pub fn bytes(&self) -> usize {
        self.current.bytes
    }

    /// Takes over what a shorter one holds.
    pub fn begin_with(&mut self, old: &Self) {
        let old = [Some(&old.current), old.previous.as_ref()];
        let new = [Some(&mut self.current), self.previous.as_mut()];
        for (new, old) in new.into_iter().zip(old) {
            if let (Some(new), Some(old)) = (new, old) {
                new.bytes_mut()[..old.bytes].copy_from_slice(old.bytes());
            }
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use gibs_graph::Graph;

    #[test]
    fn more_than_an_address_can_say_is_an_error() {
        let mut g = Graph::new("test");
        let huge = g.input::<u32>("huge", u64::MAX / 2);
        g.output("huge", &huge);
        let schedule = g.compile(None).expect("it is sound");
        let made = Allocation::new(&schedule.resources[0]);
        let named = |resource: &str, bytes| resource == "huge" && bytes == u64::MAX;
        assert!(matches!(
            made.err(),
            Some(BackendError::OutOfMemory { resource, bytes, .. }) if named(&resource, bytes)
        ));
    }

    #[test]
    fn clearing_clears_what_it_is_asked_to() {
        const WORDS: u64 = 100_001;
        let mut g = Graph::new("test");
        let words = g.input::<u32>("words", WORDS);
        g.output("words", &words);
        let schedule = g.compile(None).expect("it is sound");
        let made = Allocation::new(&schedule.resources[0]);
        let memory = &mut made.expect("there is room").current;
        for threads in [1, 2, 5] {
            for bytes in [0, 4, 1 << 15, (1 << 15) + 4, 4 * WORDS as usize] {
                memory.bytes_mut().fill(0xff);
                memory.clear(bytes, &mut Shares::new(threads));
                let (cleared, rest) = memory.bytes().split_at(bytes);
                assert!(cleared.iter().all(|&byte| byte == 0), "{bytes} bytes");
                assert!(rest.iter().all(|&byte| byte == 0xff), "{bytes} bytes");
            }
        }
    }
}
