//! Proof of AVX2, and plain code compiled for it.
#![allow(unsafe_code)]

/// Proof that the processor has AVX2, FMA and the bit instructions that came with them: only [`Avx2::detect`] makes one.
#[derive(Clone, Copy, Debug)]
pub struct Avx2(());

impl Avx2 {
    /// The proof, if the processor has what it takes.
    #[inline]
    pub fn detect() -> Option<Self> {
        let all = is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("lzcnt")
            && is_x86_feature_detected!("popcnt");
        all.then_some(Avx2(()))
    }

    /// Runs `f`, compiled for such processors as far as it is inlined. The compiler never fuses `a * b + c` on its own,
    /// so that results stay what they are elsewhere.
    #[inline]
    pub fn run<R>(self, f: impl FnOnce() -> R) -> R {
        // SAFETY: `self` proves that the processor has the features.
        unsafe { compiled(f) }
    }
}

/// Proof that the processor has AVX-512 with bytes, dot products of bytes, and vectors of any length, besides what [`Avx2`] stands
/// for: only [`Avx512::detect`] makes one.
#[derive(Clone, Copy, Debug)]
pub struct Avx512(());

impl Avx512 {
    /// The proof, if the processor has what it takes.
    #[inline]
    pub fn detect() -> Option<Self> {
        let all = is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512bw")
            && is_x86_feature_detected!("avx512vl")
            && is_x86_feature_detected!("avx512vnni")
            && Avx2::detect().is_some();
        all.then_some(Avx512(()))
    }
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn compiled<R>(f: impl FnOnce() -> R) -> R {
    f()
}

/// Asks for the memory of an element that will be needed soon; nothing happens where there is none.
#[inline(always)]
pub fn prefetch<T>(slice: &[T], index: usize) {
    if let Some(soon) = slice.get(index) {
        let start = std::ptr::from_ref(soon).cast::<i8>();
        let ask = |byte: usize| {
            // SAFETY: a prefetch reads nothing; the address lies within the referenced value.
            unsafe {
                std::arch::x86_64::_mm_prefetch::<{ std::arch::x86_64::_MM_HINT_T0 }>(
                    start.add(byte),
                )
            };
        };
        (0..size_of::<T>()).step_by(64).for_each(ask);
        // Elements that do not fit into lines may end in one more.
        if !size_of::<T>().is_multiple_of(64) && !64usize.is_multiple_of(size_of::<T>()) {
            ask(size_of::<T>() - 1);
        }
    }
}
