//! Kernels as data: the two implementations of a stage.
use crate::RawView;
use std::ops::Range;

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

/// Runs workgroups, one after the other. Bindings come in the order of the stage's ports. Where they have maps of what is
/// written, a call is for a single workgroup: the maps tell calls apart.
pub type CpuKernel = fn(&[RawView<'_>], Workgroups);

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
    #[inline]
    pub fn linear(&self) -> u32 {
        (self.id[2] * self.count[1] + self.id[1]) * self.count[0] + self.id[0]
    }

    /// Invocations per workgroup.
    #[inline]
    pub fn lanes(&self) -> u32 {
        self.size[0] * self.size[1] * self.size[2]
    }

    /// Indices of a one-dimensional dispatch that this workgroup owns, at most `count`.
    #[inline]
    pub fn range(&self, count: u32) -> Range<usize> {
        let first =
            (u64::from(self.linear()) * u64::from(self.lanes())).min(u64::from(count)) as usize;
        let last = (first + self.lanes() as usize).min(count as usize);
        first..last
    }
}

/// Workgroups of a dispatch that follow each other, x running fastest.
#[derive(Clone, Debug)]
pub struct Workgroups {
    next: Workgroup,
    left: u32,
}

impl Workgroups {
    /// Those with linear indices in `range`, of a dispatch of `count` workgroups of `size` invocations each. Where a count is zero,
    /// the range is empty.
    pub fn new(range: Range<u32>, count: [u32; 3], size: [u32; 3]) -> Self {
        let [x, y, _] = count.map(|n| n.max(1));
        let first = range.start;
        Self {
            next: Workgroup {
                id: [first % x, first / x % y, first / x / y],
                count,
                size,
            },
            left: range.end.saturating_sub(first),
        }
    }

    /// Linear index of the next one.
    pub fn first(&self) -> u32 {
        self.next.linear()
    }
}

impl Iterator for Workgroups {
    type Item = Workgroup;

    #[inline]
    fn next(&mut self) -> Option<Workgroup> {
        self.left = self.left.checked_sub(1)?;
        let Workgroup { id, count, .. } = self.next;
        let [x, y, z] = id;
        self.next.id = match (x + 1 < count[0], y + 1 < count[1]) {
            (true, _) => [x + 1, y, z],
            (false, true) => [0, y + 1, z],
            (false, false) => [0, 0, z + 1],
        };
        Some(Workgroup { id, ..self.next })
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

#[cfg(test)]
mod tests {
    use super::Workgroups;

    #[test]
    fn workgroups_go_along_x_then_y_then_z() {
        let count = [3, 2, 2];
        let all: Vec<_> = Workgroups::new(0..12, count, [8, 4, 1]).collect();
        let ids: Vec<_> = all.iter().map(|group| group.id).collect();
        let expected: Vec<_> = (0..2)
            .flat_map(|z| (0..2).flat_map(move |y| (0..3).map(move |x| [x, y, z])))
            .collect();
        assert_eq!(ids, expected);
        for (i, group) in (0..).zip(&all) {
            assert_eq!(group.linear(), i);
            let from: Vec<_> = Workgroups::new(i..12, count, [8, 4, 1]).collect();
            assert_eq!(from[0].id, group.id);
            assert_eq!(from.len(), 12 - i as usize);
        }
        assert!(Workgroups::new(5..5, count, [1; 3]).next().is_none());
    }
}
