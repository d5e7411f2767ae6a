//! CPU kernels for processors with wider registers than the compiler may assume. Each is the twin of a scalar function
//! and gives its results to the bit; which one runs is decided when the program runs.
#[cfg(target_arch = "x86_64")]
mod continue_paths;
#[cfg(target_arch = "x86_64")]
mod directions;
#[cfg(target_arch = "x86_64")]
mod generate_rays;
#[cfg(target_arch = "x86_64")]
mod hashes;
#[cfg(target_arch = "x86_64")]
mod integrate;
#[cfg(target_arch = "x86_64")]
mod lanes;
#[cfg(target_arch = "x86_64")]
mod lookup;
#[cfg(not(target_arch = "x86_64"))]
mod lookup_scalar;
#[cfg(target_arch = "x86_64")]
mod place;
#[cfg(target_arch = "x86_64")]
mod primary_rays;
#[cfg(target_arch = "x86_64")]
mod resolve;
#[cfg(target_arch = "x86_64")]
mod sample_lights;
#[cfg(target_arch = "x86_64")]
mod select_pixels;
#[cfg(target_arch = "x86_64")]
mod shade_hits;
#[cfg(target_arch = "x86_64")]
mod update_depth;
#[cfg(target_arch = "x86_64")]
mod x86;

#[cfg(test)]
mod tests;

#[cfg(not(target_arch = "x86_64"))]
pub use {
    crate::shared::grid::overlapped_by,
    crate::stages::{
        continue_paths::continue_each as continue_paths,
        generate_rays::generate_each as generate_rays, integrate::integrate_each as integrate,
        positional_update::place_each as place, primary_rays::primary_each as primary_rays,
        resolve_hits::resolve_each as resolve_hits, sample_lights::sample_each as sample_lights,
        select_pixels::select_each as select_pixels, shade_hits::shade_each as shade_hits,
        update_depth::update_each as update_depth,
    },
    lookup_scalar::Lookup,
};
#[cfg(target_arch = "x86_64")]
pub use {
    continue_paths::continue_paths,
    generate_rays::generate_rays,
    integrate::integrate,
    lookup::{Lookup, overlapped_by},
    place::place,
    primary_rays::primary_rays,
    resolve::resolve_hits,
    sample_lights::sample_lights,
    select_pixels::select_pixels,
    shade_hits::shade_hits,
    update_depth::update_depth,
    x86::{Avx2, prefetch},
};

/// No processor of this architecture has AVX2: a type without values.
#[cfg(not(target_arch = "x86_64"))]
#[derive(Clone, Copy, Debug)]
pub enum Avx2 {}

#[cfg(not(target_arch = "x86_64"))]
impl Avx2 {
    /// Nothing: there is no AVX2 here.
    pub fn detect() -> Option<Self> {
        None
    }

    /// Never called.
    pub fn run<R>(self, _: impl FnOnce() -> R) -> R {
        match self {}
    }
}

/// Asks for the memory of an element that will be needed soon: not on this architecture.
#[cfg(not(target_arch = "x86_64"))]
#[inline(always)]
pub fn prefetch<T>(_: &[T], _: usize) {}

/// Runs `f` with whatever instructions the processor has. What `f` calls must be `#[inline]` to gain by it: rounding to
/// integers, for one, is a call without SSE 4.1.
#[inline]
pub fn run<R>(f: impl FnOnce() -> R) -> R {
    match Avx2::detect() {
        Some(avx2) => avx2.run(f),
        None => f(),
    }
}
