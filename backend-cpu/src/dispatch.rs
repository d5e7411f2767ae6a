//! Running one kernel.
use crate::executable::CpuExecutable;
use crate::order::shuffled;
use gibs_graph::{
    Access, BackendError, DispatchArgs, DispatchSize, DispatchStep, MAX_GROUPS, RawView,
    Workgroups, WriteMap, unknown_step,
};
use std::any::Any;
use std::cell::Cell;
use std::ops::Range;

thread_local! {
    static IN_KERNEL: Cell<bool> = const { Cell::new(false) };
}

/// Whether this thread runs a kernel. A panic there becomes a [`BackendError::Kernel`], so that a program's panic hook may
/// leave it out.
pub fn in_kernel() -> bool {
    IN_KERNEL.get()
}

/// Workgroups that a thread takes at once, at most.
const MOST_GROUPS_A_PIECE: u32 = 8;

/// Marks the thread until it is dropped, also by a panic. A kernel that waits for threads of the pool may run another one
/// meanwhile, so it holds what was before.
struct InKernel(bool);

impl InKernel {
    fn enter() -> Self {
        Self(IN_KERNEL.replace(true))
    }
}

impl Drop for InKernel {
    fn drop(&mut self) {
        IN_KERNEL.set(self.0);
    }
}

impl CpuExecutable {
    /// Number of workgroups along each axis, and in all.
    fn groups(&self, label: &str, size: DispatchSize) -> Result<([u32; 3], u32), BackendError> {
        let groups = match size {
            DispatchSize::Groups(groups) => groups,
            DispatchSize::Indirect(resource) => {
                let home = self.schedule.resources[resource as usize].home;
                let bytes = self.allocations[home as usize].current.bytes();
                let args: DispatchArgs =
                    gibs_graph::bytemuck::pod_read_unaligned(&bytes[..size_of::<DispatchArgs>()]);
                [args.x, args.y, args.z]
            }
            _ => return Err(unknown_step(label)),
        };
        let total = groups
            .iter()
            .try_fold(1, |total: u32, &n| total.checked_mul(n));
        match total {
            _ if groups.contains(&0) => Ok((groups, 0)),
            Some(total) if groups.iter().all(|&n| n <= MAX_GROUPS) => Ok((groups, total)),
            _ => Err(BackendError::Kernel {
                stage: label.into(),
                message: format!(
                    "{groups:?} workgroups were asked for; at most {MAX_GROUPS} along each axis and 2^32 - 1 in all \
                     run everywhere; fold them in the stage that counts them"
                ),
            }),
        }
    }

    pub(crate) fn dispatch(
        &mut self,
        label: &str,
        dispatch: &DispatchStep,
    ) -> Result<(), BackendError> {
        let (count, total) = self.groups(label, dispatch.size)?;
        let maps = self.maps(dispatch);
        let mut bound_maps = maps.iter();
        let mut views = emptied(std::mem::take(&mut self.views));
        for binding in dispatch.slots() {
            let Some(binding) = binding else {
                views.push(RawView::absent());
                continue;
            };
            let resource = &self.schedule.resources[binding.resource as usize];
            let allocation = &mut self.allocations[resource.home as usize];
            let memory = match (binding.access, &mut allocation.previous) {
                (Access::Previous, Some(previous)) => previous,
                _ => &mut allocation.current,
            };
            // SAFETY: the memory belongs to this executable, is initialized and aligned to cache lines, is not moved or
            // touched otherwise until the kernels below have returned, and was borrowed mutably here; a resource is
            // bound twice only where no port writes it, and resources that share memory are never bound together.
            let view = unsafe {
                RawView::new(
                    memory.start(),
                    resource.bytes as usize,
                    binding.access,
                    bound_maps.next().and_then(Option::as_ref),
                )
            };
            views.push(match resource.image {
                Some(image) => view.with_size(image.size),
                None => view,
            });
        }
        let kernel = match dispatch.kernel.cpu_wide {
            Some(wide) if !self.shared.options.scalar => wide,
            _ => dispatch.kernel.cpu,
        };
        let size = dispatch.kernel.workgroup;
        // Maps of what is written tell workgroups apart by their calls.
        let shuffle = self.shared.options.checked;
        let run = |range: Range<u32>| {
            let _marked = InKernel::enter();
            kernel(&views, Workgroups::new(range, count, size));
        };
        let threads = self.shared.pool.current_num_threads();
        // Enough pieces to balance, few enough that a piece is worth a thread's while. All that costs time may lie in a few places, as
        // live surfels do in a buffer with room for many more.
        let piece = (total / (threads as u32).saturating_mul(128)).clamp(1, MOST_GROUPS_A_PIECE);
        let shares = &mut self.shares;
        let all = || {
            shares.run(total.div_ceil(piece), |place| {
                let first = place * piece;
                let range = first..total.min(first.saturating_add(piece));
                if shuffle {
                    let places = range.map(|i| shuffled(i, total));
                    places.for_each(|i| run(i..i + 1));
                } else {
                    run(range);
                }
            });
        };
        // A kernel that leaves its buffers panics. What it had written by then stays, as on a device that is lost; nothing
        // else is broken by it.
        let ran = std::panic::catch_unwind(std::panic::AssertUnwindSafe(all));
        self.views = emptied(views);
        if let Err(panic) = ran {
            return Err(BackendError::Kernel {
                stage: label.into(),
                message: format!("the CPU kernel failed: {}", said(panic.as_ref())),
            });
        }
        for (map, binding) in maps.iter().zip(&dispatch.bindings) {
            if let Some(offset) = map.as_ref().and_then(WriteMap::conflict) {
                return Err(BackendError::WriteConflict {
                    stage: label.into(),
                    port: binding.port.into(),
                    offset: offset as u64,
                });
            }
        }
        Ok(())
    }

    /// When checking, a map per binding that is written without atomics; otherwise nothing.
    fn maps(&self, dispatch: &DispatchStep) -> Vec<Option<WriteMap>> {
        if !self.shared.options.checked {
            return Vec::new();
        }
        let bindings = dispatch.bindings.iter();
        bindings
            .map(|binding| {
                let resource = &self.schedule.resources[binding.resource as usize];
                let memory = self.allocations[resource.home as usize].current.bytes();
                (binding.access.writes() && binding.access != Access::Atomic).then(|| {
                    WriteMap::new(
                        memory.as_ptr().addr(),
                        resource.bytes as usize,
                        binding.access != Access::ReadWrite,
                    )
                })
            })
            .collect()
    }
}

/// What a panic says.
fn said(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied())
        .unwrap_or("it panicked")
}

/// The vector without its views, for views of another lifetime. Collecting reuses the allocation, so that a frame
/// makes none.
fn emptied<'a>(views: Vec<RawView<'_>>) -> Vec<RawView<'a>> {
    views.into_iter().map_while(|_| None).collect()
}
