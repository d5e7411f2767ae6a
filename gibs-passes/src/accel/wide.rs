//! Traversal of the wide tree: eight boxes or triangles at a time.
//!
//! SIMD only selects candidates, by tests that accept whatever [`super::intersect`] accepts; the shared scalar formula
//! decides and gives the reported numbers. Results therefore equal those of [`super::scalar`] to the bit.
use super::intersect::BoxRay;
use super::portable::Portable;
use super::types::{Hit, Ray, WideNode, WidePacket, WideView};
use super::walk::{Stack, any, closest};
use crate::simd::Avx2;

/// One way to test eight boxes or triangles. Implementations differ in speed, never in results.
pub(super) trait Kernel: Copy {
    /// A ray in the form that the tests want.
    type Ray: Copy;

    fn prepare(self, ray: &BoxRay, t_min: f32) -> Self::Ray;

    /// Bit mask of the children that the ray enters no later than `limit`, with the distances of all eight.
    fn boxes(self, ray: &Self::Ray, node: &WideNode, limit: f32) -> (u32, [f32; 8]);

    /// Bit mask of the triangles that the ray hits beyond `t_min` and no later than `limit`.
    fn triangles(self, ray: &Self::Ray, packet: &WidePacket, limit: f32) -> u32;

    /// Asks for memory that will be needed soon.
    #[inline(always)]
    fn prefetch<T>(self, _soon: &T) {}
}

/// The instruction set that a [`Tracer`] uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Simd {
    /// 256-bit vectors by intrinsics, where the processor has AVX2 and FMA.
    Avx2,
    /// Plain loops over eight lanes, for whatever the compiler makes of them.
    Portable,
}

#[derive(Clone, Copy, Debug)]
enum Chosen {
    Avx2(Avx2),
    Portable(Portable),
}

/// A traversal with its stack. Make one per thread or workgroup and trace many rays with it.
#[derive(Clone, Debug)]
pub struct Tracer {
    chosen: Chosen,
    stack: Stack,
}

impl Default for Tracer {
    fn default() -> Self {
        Self::new()
    }
}

impl Tracer {
    /// A tracer with the best instruction set of this processor.
    pub fn new() -> Self {
        Avx2::detect().map_or_else(Self::portable, |avx2| Self::with(Chosen::Avx2(avx2)))
    }

    /// A tracer without processor-specific instructions, with the same results.
    pub fn portable() -> Self {
        Self::with(Chosen::Portable(Portable))
    }

    /// What this tracer uses.
    pub fn simd(&self) -> Simd {
        match self.chosen {
            Chosen::Avx2(_) => Simd::Avx2,
            Chosen::Portable(_) => Simd::Portable,
        }
    }

    fn with(chosen: Chosen) -> Self {
        Tracer {
            chosen,
            stack: Stack::default(),
        }
    }

    /// Closest hit of a ray; the filter is that of [`super::scalar::closest`].
    #[inline]
    pub fn closest(
        &mut self,
        view: &WideView,
        ray: &Ray,
        filter: impl Fn(u32, u32, f32, f32) -> bool,
    ) -> Hit {
        match self.chosen {
            Chosen::Avx2(kernel) => kernel.closest(view, ray, &mut self.stack, &filter),
            Chosen::Portable(kernel) => closest(kernel, view, ray, &mut self.stack, &filter),
        }
    }

    /// Whether a ray hits anything; the filter is that of [`super::scalar::closest`].
    #[inline]
    pub fn any(
        &mut self,
        view: &WideView,
        ray: &Ray,
        filter: impl Fn(u32, u32, f32, f32) -> bool,
    ) -> bool {
        match self.chosen {
            Chosen::Avx2(kernel) => kernel.any(view, ray, &mut self.stack, &filter),
            Chosen::Portable(kernel) => any(kernel, view, ray, &mut self.stack, &filter),
        }
    }
}
