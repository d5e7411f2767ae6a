//! Running the steps of a schedule.
use crate::Shared;
use crate::memory::Allocation;
use crate::order::shuffled;
use gibs_graph::{
    Access, Action, BackendError, DispatchArgs, DispatchSize, DispatchStep, Executable, MAX_GROUPS,
    RawView, Resource, ResourceId, Schedule, StepTime, Workgroup, WriteMap, check_image,
    check_range, check_step,
};
use rayon::prelude::*;
use std::sync::Arc;
use std::time::Instant;

pub(crate) struct CpuExecutable {
    schedule: Arc<Schedule>,
    shared: Arc<Shared>,
    /// Of each resource; empty for one that is at home elsewhere.
    allocations: Vec<Allocation>,
    /// Room for the views of one step; empty between steps.
    views: Vec<RawView<'static>>,
    measure: bool,
    /// Of the last measured frame that finished.
    times: Option<Vec<StepTime>>,
    /// Room for the times of the frame under way.
    next_times: Vec<StepTime>,
}

impl CpuExecutable {
    pub fn new(schedule: Arc<Schedule>, shared: Arc<Shared>) -> Result<Self, BackendError> {
        shared.capabilities.check(&shared.device.name, &schedule)?;
        let resources = schedule.resources.iter();
        let allocations = resources.map(Allocation::new).collect::<Result<_, _>>()?;
        Ok(Self {
            schedule,
            shared,
            allocations,
            views: Vec::new(),
            measure: false,
            times: None,
            next_times: Vec::new(),
        })
    }

    /// Runs the steps of a frame, on a thread of the pool.
    fn frame(&mut self) -> Result<(), BackendError> {
        for allocation in &mut self.allocations {
            allocation.rotate();
        }
        self.next_times.clear();
        for step in 0..self.schedule.steps.len() {
            let start = self.measure.then(Instant::now);
            self.step(step)?;
            if let Some(start) = start {
                let time = start.elapsed();
                self.next_times.push(StepTime { step, time });
            }
        }
        if self.measure {
            std::mem::swap(self.times.get_or_insert_default(), &mut self.next_times);
        }
        Ok(())
    }

    /// Runs one step, on a thread of the pool.
    fn step(&mut self, index: usize) -> Result<(), BackendError> {
        let schedule = Arc::clone(&self.schedule);
        let step = &schedule.steps[index];
        match &step.action {
            Action::Clear(resource) => {
                let bytes = schedule.resources[*resource as usize].bytes as usize;
                self.home(*resource).current.bytes_mut()[..bytes]
                    .par_chunks_mut(1 << 20)
                    .for_each(|chunk| chunk.fill(0));
                Ok(())
            }
            Action::Dispatch(dispatch) => self.dispatch(&step.label, dispatch),
        }
    }

    /// The memory that a resource uses.
    fn home(&mut self, resource: ResourceId) -> &mut Allocation {
        let home = self.schedule.resources[resource as usize].home;
        &mut self.allocations[home as usize]
    }

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

    fn dispatch(&mut self, label: &str, dispatch: &DispatchStep) -> Result<(), BackendError> {
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
        let shuffle = self.shared.options.checked;
        let run = |i: u32| {
            let i = if shuffle { shuffled(i, total) } else { i };
            let id = [
                i % count[0],
                i / count[0] % count[1],
                i / count[0] / count[1],
            ];
            kernel(&views, Workgroup { id, count, size });
        };
        match total {
            0 => {}
            1 => run(0),
            _ => {
                // Enough pieces to balance, few enough that a piece is worth a thread's while.
                let least = (total as usize / (self.shared.pool.current_num_threads() * 16)).max(1);
                (0..total).into_par_iter().with_min_len(least).for_each(run);
            }
        }
        self.views = emptied(views);
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
                (binding.access.writes() && binding.access != Access::Atomic)
                    .then(|| WriteMap::new(memory.as_ptr().addr(), resource.bytes as usize))
            })
            .collect()
    }
}

/// The vector without its views, for views of another lifetime. Collecting reuses the allocation, so that a frame
/// makes none.
fn emptied<'a>(views: Vec<RawView<'_>>) -> Vec<RawView<'a>> {
    views.into_iter().map_while(|_| None).collect()
}

impl Executable for CpuExecutable {
    fn schedule(&self) -> &Arc<Schedule> {
        &self.schedule
    }

    fn upload(
        &mut self,
        resource: ResourceId,
        offset: u64,
        bytes: &[u8],
    ) -> Result<(), BackendError> {
        check_range(&self.schedule, resource, offset, bytes.len())?;
        let found = &self.schedule.resources[resource as usize];
        if let Some(image) = found.image {
            check_image(found, bytes.len())?;
            // Rounded as the format has it, as on a device.
            let values = image.format.decode(&image.format.encode(bytes));
            let memory = self.home(resource).current.bytes_mut();
            memory[..values.len()].copy_from_slice(&values);
            return Ok(());
        }
        let memory = self.home(resource).current.bytes_mut();
        memory[offset as usize..offset as usize + bytes.len()].copy_from_slice(bytes);
        Ok(())
    }

    /// Enters the pool once: what is parallel within the frame then starts from one of its threads, which costs less
    /// than entering per step.
    fn run(&mut self) -> Result<(), BackendError> {
        let shared = Arc::clone(&self.shared);
        shared.pool.install(|| self.frame())
    }

    fn run_step(&mut self, step: usize) -> Result<(), BackendError> {
        check_step(&self.schedule, step)?;
        let shared = Arc::clone(&self.shared);
        shared.pool.install(|| self.step(step))
    }

    fn read(&mut self, resource: ResourceId) -> Result<Vec<u8>, BackendError> {
        check_range(&self.schedule, resource, 0, 0)?;
        let bytes = self.schedule.resources[resource as usize].bytes as usize;
        Ok(self.home(resource).current.bytes()[..bytes].to_vec())
    }

    fn reset(&mut self) -> Result<(), BackendError> {
        for (allocation, resource) in self.allocations.iter_mut().zip(&self.schedule.resources) {
            allocation.reset(&resource.kind);
        }
        Ok(())
    }

    fn wait(&mut self) -> Result<(), BackendError> {
        Ok(())
    }

    fn measure(&mut self, on: bool) {
        self.measure = on;
    }

    fn timings(&mut self) -> Result<Option<Vec<StepTime>>, BackendError> {
        Ok(self.times.clone())
    }

    fn adopt(&mut self, schedule: Arc<Schedule>) -> Result<(), BackendError> {
        let capabilities = &self.shared.capabilities;
        capabilities.check(&self.shared.device.name, &schedule)?;
        let mut taken = vec![None; schedule.resources.len()];
        for (from, to) in schedule.adoptions(&self.schedule) {
            taken[to as usize] = Some(from as usize);
        }
        // Everything that can fail comes before anything is taken.
        let allocate = |(resource, from): (&Resource, &Option<usize>)| match from {
            Some(from) if self.allocations[*from].bytes() as u64 == resource.room => Ok(None),
            _ => Allocation::new(resource).map(Some),
        };
        let resources = schedule.resources.iter().zip(&taken);
        let made = resources
            .map(allocate)
            .collect::<Result<Vec<_>, BackendError>>()?;
        let mut old: Vec<_> = self.allocations.drain(..).map(Some).collect();
        let places = made.into_iter().zip(taken);
        self.allocations = places
            .filter_map(|(made, from)| {
                let old = from.and_then(|from| old[from].take());
                match (made, old) {
                    (Some(mut made), Some(old)) => {
                        made.begin_with(&old);
                        Some(made)
                    }
                    (made, old) => made.or(old),
                }
            })
            .collect();
        self.schedule = schedule;
        self.times = None;
        Ok(())
    }
}
