//! Running the steps of a schedule.
use crate::Options;
use crate::memory::Allocation;
use gibs_graph::{
    Access, Action, BackendError, DispatchArgs, DispatchSize, DispatchStep, Executable, RawView, ResourceId, Schedule,
    StepTime, Workgroup, WriteMap, check_range,
};
use rayon::prelude::*;
use std::any::Any;
use std::sync::Arc;
use std::time::Instant;

pub(crate) struct CpuExecutable {
    schedule: Arc<Schedule>,
    pool: Arc<rayon::ThreadPool>,
    options: Options,
    allocations: Vec<Allocation>,
    measure: bool,
    times: Option<Vec<StepTime>>,
}

impl CpuExecutable {
    pub fn new(
        schedule: Arc<Schedule>,
        pool: Arc<rayon::ThreadPool>,
        options: Options,
        old: Option<CpuExecutable>,
    ) -> Result<Self, BackendError> {
        let mut allocations =
            schedule.resources.iter().map(Allocation::new).collect::<Result<Vec<_>, BackendError>>()?;
        if let Some(mut old) = old {
            for (from, to) in schedule.adoptions(&old.schedule) {
                std::mem::swap(&mut allocations[to as usize], &mut old.allocations[from as usize]);
            }
        }
        Ok(Self { schedule, pool, options, allocations, measure: false, times: None })
    }

    fn rotate(&mut self) {
        for allocation in &mut self.allocations {
            allocation.rotate();
        }
    }

    fn step(&mut self, index: usize) -> Result<(), BackendError> {
        let schedule = Arc::clone(&self.schedule);
        let step = &schedule.steps[index];
        match &step.action {
            Action::Clear(resource) => {
                let memory = self.allocations[*resource as usize].current.bytes_mut();
                self.pool.install(|| memory.par_chunks_mut(1 << 20).for_each(|chunk| chunk.fill(0)));
                Ok(())
            }
            Action::Dispatch(dispatch) => self.dispatch(&step.label, dispatch),
        }
    }

    fn groups(&self, size: DispatchSize) -> [u32; 3] {
        match size {
            DispatchSize::Groups(groups) => groups,
            DispatchSize::Indirect(resource) => {
                let bytes = self.allocations[resource as usize].current.bytes();
                let args: DispatchArgs = gibs_graph::bytemuck::pod_read_unaligned(&bytes[..size_of::<DispatchArgs>()]);
                [args.x, args.y, args.z]
            }
        }
    }

    fn dispatch(&mut self, label: &str, dispatch: &DispatchStep) -> Result<(), BackendError> {
        let count = self.groups(dispatch.size);
        let total = count.iter().map(|&n| u64::from(n)).product::<u64>();
        let mut maps = Vec::new();
        if self.options.checked {
            for binding in &dispatch.bindings {
                let memory = self.allocations[binding.resource as usize].current.bytes();
                let checks = matches!(binding.access, Access::Write | Access::ReadWrite);
                maps.push(checks.then(|| WriteMap::new(memory.as_ptr().addr(), memory.len())));
            }
        }
        let mut views = Vec::with_capacity(dispatch.bindings.len());
        for (i, binding) in dispatch.bindings.iter().enumerate() {
            let allocation = &mut self.allocations[binding.resource as usize];
            let memory = match (binding.access, &mut allocation.previous) {
                (Access::Previous, Some(previous)) => previous.bytes_mut(),
                _ => allocation.current.bytes_mut(),
            };
            // SAFETY: the memory belongs to this executable, is initialized and aligned to cache lines, is not moved or
            // touched otherwise until the kernels below have returned, and was borrowed mutably here; a resource is
            // bound twice only where no port writes it.
            views.push(unsafe {
                RawView::new(memory.as_mut_ptr(), memory.len(), maps.get(i).and_then(Option::as_ref))
            });
        }
        let kernel = match dispatch.kernel.cpu_wide {
            Some(wide) if !self.options.scalar => wide,
            _ => dispatch.kernel.cpu,
        };
        let size = dispatch.kernel.workgroup;
        let shuffle = self.options.checked;
        let run = |i: u64| {
            let i = if shuffle { shuffled(i, total) } else { i };
            let row = u64::from(count[0]);
            let plane = row * u64::from(count[1]);
            let id = [(i % row) as u32, (i % plane / row) as u32, (i / plane) as u32];
            kernel(&views, Workgroup { id, count, size });
        };
        match total {
            0 => {}
            1 => run(0),
            _ => {
                // Enough pieces to balance, few enough that a piece is worth a thread's while.
                let least = (total as usize / (self.pool.current_num_threads() * 16)).max(1);
                self.pool.install(|| (0..total as usize).into_par_iter().with_min_len(least).for_each(|i| run(i as u64)));
            }
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
}

/// A permutation of `0..total`: steps of a stride that shares no factor with `total`.
fn shuffled(i: u64, total: u64) -> u64 {
    const STRIDE: u64 = 2_654_435_761; // prime, so coprime to anything that is not a multiple of it
    ((u128::from(i) * u128::from(STRIDE) + u128::from(total / 2)) % u128::from(total)) as u64
}

impl Executable for CpuExecutable {
    fn schedule(&self) -> &Arc<Schedule> {
        &self.schedule
    }

    fn upload(&mut self, resource: ResourceId, offset: u64, bytes: &[u8]) -> Result<(), BackendError> {
        check_range(&self.schedule, resource, offset, bytes.len())?;
        let memory = self.allocations[resource as usize].current.bytes_mut();
        memory[offset as usize..offset as usize + bytes.len()].copy_from_slice(bytes);
        Ok(())
    }

    fn run(&mut self) -> Result<(), BackendError> {
        self.rotate();
        let mut times = self.measure.then(|| Vec::with_capacity(self.schedule.steps.len()));
        for step in 0..self.schedule.steps.len() {
            let start = Instant::now();
            self.step(step)?;
            if let Some(times) = &mut times {
                times.push(StepTime { step, time: start.elapsed() });
            }
        }
        if times.is_some() {
            self.times = times;
        }
        Ok(())
    }

    fn run_step(&mut self, step: usize) -> Result<(), BackendError> {
        self.step(step)
    }

    fn read(&mut self, resource: ResourceId) -> Result<Vec<u8>, BackendError> {
        check_range(&self.schedule, resource, 0, 0)?;
        Ok(self.allocations[resource as usize].current.bytes().to_vec())
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

    fn into_any(self: Box<Self>) -> Box<dyn Any> {
        self
    }
}
