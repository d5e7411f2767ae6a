//! What CPU kernels see of their buffers. The one unsafe module of this crate.
//!
//! # The rule
//! Workgroups of a stage run at the same time. Two workgroups never touch the same element of a [`WriteView`] unless
//! both only read it: a kernel that breaks this is a data race, undefined behaviour that no compiler sees, as two
//! invocations that write one element are on a device. The executor's debug mode finds both with a [`WriteMap`]: elements that two
//! workgroups write, and elements of what a stage only writes that are written twice by one. One that reads what another one writes shows as a result that depends on the order. [`AtomicView`] is free of the rule.
//! A resource is bound at most once per stage when any port writes it (graph compilation checks this), so views of
//! one stage never overlap.
use crate::{Access, Element};
use std::marker::PhantomData;
use std::ops::Deref;
use std::sync::atomic::{AtomicU32, Ordering};

/// Memory of one binding, untyped.
///
/// Made by the executor from memory that outlives the stage's run and that nothing else touches meanwhile.
#[derive(Clone, Copy)]
pub struct RawView<'a> {
    ptr: *mut u8,
    bytes: usize,
    access: Access,
    size: [u32; 2],
    map: Option<&'a WriteMap>,
    life: PhantomData<&'a ()>,
}

// SAFETY: a RawView is only a place; who may touch it when is the rule above, kept by the views made from it.
unsafe impl Send for RawView<'_> {}
// SAFETY: as above.
unsafe impl Sync for RawView<'_> {}

impl<'a> RawView<'a> {
    /// A view of `bytes` bytes at `ptr` that is touched as `access` says.
    ///
    /// # Safety
    /// The memory is valid for reads and, where `access` writes, for writes for `'a`, aligned to 64 bytes and
    /// initialized. During `'a` it is touched by nothing but views made from this value (and copies of it), or, where
    /// `access` does not write, from others that do not write either.
    pub unsafe fn new(
        ptr: *mut u8,
        bytes: usize,
        access: Access,
        map: Option<&'a WriteMap>,
    ) -> Self {
        Self {
            ptr,
            bytes,
            access,
            size: [0; 2],
            map,
            life: PhantomData,
        }
    }

    /// What a kernel gets for an optional port that is not bound: a view of nothing that fits any access.
    pub fn absent() -> Self {
        Self {
            // Dangling, but aligned, as an empty slice's.
            ptr: std::ptr::without_provenance_mut(64),
            bytes: 0,
            access: Access::Read,
            size: [0; 2],
            map: None,
            life: PhantomData,
        }
    }

    /// The same view, of an image of this size.
    pub fn with_size(self, size: [u32; 2]) -> Self {
        Self { size, ..self }
    }

    /// Size of an image; zero for a buffer.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The port was declared for this kind of view: what keeps slices and writes of one binding apart.
    #[inline]
    fn expect(&self, fits: bool) {
        assert!(
            fits || self.bytes == 0,
            "a view that does not fit a port with access {:?}",
            self.access
        );
    }

    #[inline]
    fn len_of<T>(&self) -> usize {
        const {
            assert!(size_of::<T>() > 0, "an element has bytes");
            assert!(
                align_of::<T>() <= 64,
                "elements are aligned to 64 bytes at most"
            );
        }
        self.bytes / size_of::<T>()
    }
}

/// Elements that a stage only reads; a slice.
#[derive(Clone, Copy)]
pub struct ReadView<'a, T>(&'a [T]);

impl<'a, T: Element> ReadView<'a, T> {
    /// A view of the whole binding.
    ///
    /// # Panics
    /// If the port writes.
    #[inline]
    pub fn of(raw: RawView<'a>) -> Self {
        raw.expect(!raw.access.writes());
        // SAFETY: the memory is valid and initialized for 'a (RawView::new), T is plain data of at most its
        // alignment, and nothing writes it: this port does not, and then no view of the memory does (RawView::new).
        Self(unsafe { std::slice::from_raw_parts(raw.ptr.cast::<T>(), raw.len_of::<T>()) })
    }

    /// A view of a slice, for tests and for calls outside a graph.
    pub fn of_slice(slice: &'a [T]) -> Self {
        Self(slice)
    }

    /// The elements, for as long as the stage runs.
    #[inline]
    pub fn slice(self) -> &'a [T] {
        self.0
    }
}

impl<T> Deref for ReadView<'_, T> {
    type Target = [T];
    fn deref(&self) -> &[T] {
        self.0
    }
}

/// Elements that a stage writes, each from one workgroup only.
#[derive(Clone, Copy)]
pub struct WriteView<'a, T> {
    raw: RawView<'a>,
    len: usize,
    group: u32,
    element: PhantomData<fn() -> T>,
}

impl<'a, T: Element> WriteView<'a, T> {
    /// A view of the whole binding for workgroups from the one with linear index `group` on; for that one alone where a map notes
    /// who writes what.
    ///
    /// # Panics
    /// If the port does not write, or is atomic.
    #[inline]
    pub fn of(raw: RawView<'a>, group: u32) -> Self {
        raw.expect(raw.access.writes() && raw.access != Access::Atomic);
        Self {
            len: raw.len_of::<T>(),
            raw,
            group,
            element: PhantomData,
        }
    }

    /// Number of elements.
    #[inline]
    pub fn len(&self) -> usize {
        self.len
    }

    /// There are no elements.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The element at `index`.
    ///
    /// # Panics
    /// If `index` is out of range: a bug in the kernel.
    #[inline]
    #[track_caller]
    pub fn get(&self, index: usize) -> T {
        self.check(index);
        // SAFETY: index is in range; no other workgroup writes this element (the rule of this module).
        unsafe { self.raw.ptr.cast::<T>().add(index).read() }
    }

    /// Replaces the element at `index`.
    ///
    /// # Panics
    /// If `index` is out of range: a bug in the kernel.
    #[inline]
    #[track_caller]
    pub fn set(&self, index: usize, value: T) {
        self.check(index);
        if let Some(map) = self.raw.map {
            map.mark(self.raw.ptr.addr(), index, size_of::<T>(), self.group);
        }
        // SAFETY: index is in range; no other workgroup touches this element (the rule of this module).
        unsafe { self.raw.ptr.cast::<T>().add(index).write(value) }
    }

    /// Changes the element at `index` in place.
    ///
    /// # Panics
    /// If `index` is out of range: a bug in the kernel.
    #[inline]
    #[track_caller]
    pub fn update(&self, index: usize, change: impl FnOnce(&mut T)) {
        let mut value = self.get(index);
        change(&mut value);
        self.set(index, value);
    }

    #[inline]
    #[track_caller]
    fn check(&self, index: usize) {
        assert!(
            index < self.len,
            "index {index} of a buffer of {}",
            self.len
        );
    }
}

/// 32-bit integers that all workgroups may contend for. Only operations whose result does not depend on order may
/// decide what the stage gives.
#[derive(Clone, Copy)]
pub struct AtomicView<'a>(&'a [AtomicU32]);

impl<'a> AtomicView<'a> {
    /// A view of the whole binding.
    ///
    /// # Panics
    /// If the port is not atomic.
    #[inline]
    pub fn of(raw: RawView<'a>) -> Self {
        raw.expect(raw.access == Access::Atomic);
        // SAFETY: the memory is valid and initialized for 'a, aligned, and only touched through atomics during 'a:
        // every view of an atomic port is such a one.
        Self(unsafe {
            std::slice::from_raw_parts(raw.ptr.cast::<AtomicU32>(), raw.len_of::<u32>())
        })
    }

    /// Adds, wrapping, and returns the value before.
    #[inline]
    pub fn add(&self, index: usize, value: u32) -> u32 {
        self.0[index].fetch_add(value, Ordering::Relaxed)
    }

    /// Keeps the larger.
    #[inline]
    pub fn max(&self, index: usize, value: u32) -> u32 {
        self.0[index].fetch_max(value, Ordering::Relaxed)
    }

    /// Keeps the smaller.
    #[inline]
    pub fn min(&self, index: usize, value: u32) -> u32 {
        self.0[index].fetch_min(value, Ordering::Relaxed)
    }

    /// The value now.
    #[inline]
    pub fn load(&self, index: usize) -> u32 {
        self.0[index].load(Ordering::Relaxed)
    }

    /// Replaces the value.
    #[inline]
    pub fn store(&self, index: usize, value: u32) {
        self.0[index].store(value, Ordering::Relaxed);
    }

    /// Asks for the memory of a value that will be needed soon; nothing happens where there is none. One atomic operation
    /// waits for another, and with it for its memory.
    #[inline(always)]
    pub fn prefetch(&self, index: usize) {
        #[cfg(target_arch = "x86_64")]
        if let Some(soon) = self.0.get(index) {
            // SAFETY: a prefetch reads nothing; the address is that of the referenced value.
            unsafe {
                use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
                _mm_prefetch::<_MM_HINT_T0>(soon.as_ptr().cast());
            }
        }
        #[cfg(not(target_arch = "x86_64"))]
        let _ = index;
    }

    /// Number of integers.
    #[inline]
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// There are none.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// Who wrote what during one stage: finds elements that two workgroups write, or, where a stage only writes, one of them twice:
/// an invocation writes its element once, so that there are two who did.
#[derive(Debug)]
pub struct WriteMap {
    base: usize,
    /// Per 32-bit word: 0 for untouched, else workgroup + 1.
    owner: Vec<AtomicU32>,
    /// First conflict, as word index + 1.
    conflict: AtomicU32,
    /// A workgroup writes no element twice, either.
    once: bool,
}

impl WriteMap {
    /// A map of `bytes` bytes at address `base`; with `once`, of what no workgroup may write twice.
    pub fn new(base: usize, bytes: usize, once: bool) -> Self {
        Self {
            once,
            base,
            owner: (0..bytes.div_ceil(4)).map(|_| AtomicU32::new(0)).collect(),
            conflict: AtomicU32::new(0),
        }
    }

    fn mark(&self, ptr: usize, index: usize, size: usize, group: u32) {
        let first = (ptr - self.base + index * size) / 4;
        for word in first..first + size.div_ceil(4) {
            let before = self.owner[word].swap(group + 1, Ordering::Relaxed);
            if before != 0 && (before != group + 1 || self.once) {
                self.conflict.store(word as u32 + 1, Ordering::Relaxed);
            }
        }
    }

    /// Byte offset of an element that was written twice, if there is one.
    pub fn conflict(&self) -> Option<usize> {
        match self.conflict.load(Ordering::Relaxed) {
            0 => None,
            word => Some((word as usize - 1) * 4),
        }
    }
}
