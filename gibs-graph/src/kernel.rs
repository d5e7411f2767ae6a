//! Kernels as data: the two implementations of a stage.
use crate::RawView;

/// The implementations of one stage.
#[derive(Clone, Copy)]
pub struct KernelSource {
    /// Device kernel; its entry point is `main`.
    pub wgsl: WgslSource,
    /// The scalar twin, the oracle.
    pub cpu: CpuKernel,
    /// A second CPU kernel with the same result, for speed.
    pub cpu_wide: Option<CpuKernel>,
    /// Invocations per workgroup along x, y and z.
    pub workgroup: [u32; 3],
}

/// A WGSL module and what it may import.
#[derive(Clone, Copy, Debug)]
pub struct WgslSource {
    /// Name of the module, for error messages; also the key of the pipeline cache.
    pub name: &'static str,
    /// Its text.
    pub text: &'static str,
    /// `(path, text)` of every module that it may import.
    pub modules: &'static [(&'static str, &'static str)],
    /// Features for conditional parts.
    pub features: &'static [&'static str],
}

/// Runs one workgroup. Bindings come in the order of the stage's ports.
pub type CpuKernel = fn(&[RawView<'_>], Workgroup);

/// Which workgroup runs, of how many.
#[derive(Clone, Copy, Debug)]
pub struct Workgroup {
    /// Position in the dispatch.
    pub id: [u32; 3],
    /// Size of the dispatch, in workgroups.
    pub count: [u32; 3],
    /// Size of the workgroup, in invocations.
    pub size: [u32; 3],
}

impl Workgroup {
    /// Position in the dispatch as one number; x runs fastest.
    pub fn linear(&self) -> u32 {
        (self.id[2] * self.count[1] + self.id[1]) * self.count[0] + self.id[0]
    }

    /// Invocations per workgroup.
    pub fn lanes(&self) -> u32 {
        self.size[0] * self.size[1] * self.size[2]
    }

    /// Indices of a one-dimensional dispatch that this workgroup owns, at most `count`.
    pub fn range(&self, count: u32) -> std::ops::Range<usize> {
        let first =
            (u64::from(self.linear()) * u64::from(self.lanes())).min(u64::from(count)) as usize;
        let last = (first + self.lanes() as usize).min(count as usize);
        first..last
    }
}

impl std::fmt::Debug for KernelSource {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("KernelSource")
            .field("wgsl", &self.wgsl.name)
            .field("workgroup", &self.workgroup)
            .field("wide", &self.cpu_wide.is_some())
            .finish()
    }
}
