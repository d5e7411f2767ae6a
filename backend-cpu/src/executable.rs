//! Running the steps of a schedule.
use crate::Shared;
use crate::memory::Allocation;
use crate::shares::Shares;
use gibs_graph::{
    Action, BackendError, Executable, RawView, Resource, ResourceId, Schedule, StepTime,
    check_image, check_range, check_step, unknown_step,
};
use std::sync::Arc;
use std::time::Instant;

pub(crate) struct CpuExecutable {
    pub(crate) schedule: Arc<Schedule>,
    pub(crate) shared: Arc<Shared>,
    /// Of each resource; empty for one that is at home elsewhere.
    pub(crate) allocations: Vec<Allocation>,
    /// Room for the views of one step; empty between steps.
    pub(crate) views: Vec<RawView<'static>>,
    /// What is left of the step under way.
    pub(crate) shares: Shares,
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
        let shares = Shares::new(shared.pool.current_num_threads());
        Ok(Self {
            schedule,
            shared,
            allocations,
            views: Vec::new(),
            shares,
            measure: false,
            times: None,
            next_times: Vec::new(),
        })
    }

    /// Runs the steps of a frame, on a thread of the pool.
    fn frame(&mut self) -> Result<(), BackendError> {
        self.rotate()?;
        self.next_times.clear();
        let began = self.measure.then(Instant::now);
        for step in 0..self.schedule.steps.len() {
            let start = began.map(|began| began.elapsed());
            self.step(step)?;
            if let (Some(began), Some(start)) = (began, start) {
                let time = began.elapsed().saturating_sub(start);
                self.next_times.push(StepTime { step, start, time });
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
        #[cfg(feature = "tracing")]
        let _span = tracing::info_span!("step", label = %step.label).entered();
        match &step.action {
            Action::Clear(resource) => {
                let bytes = schedule.resources[*resource as usize].bytes as usize;
                let home = schedule.resources[*resource as usize].home;
                let memory = &mut self.allocations[home as usize].current;
                memory.clear(bytes, &mut self.shares);
                Ok(())
            }
            Action::Dispatch(dispatch) => self.dispatch(&step.label, dispatch),
            _ => Err(unknown_step(&step.label)),
        }
    }

    /// The memory that a resource uses.
    fn home(&mut self, resource: ResourceId) -> &mut Allocation {
        let home = self.schedule.resources[resource as usize].home;
        &mut self.allocations[home as usize]
    }
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

    fn rotate(&mut self) -> Result<(), BackendError> {
        self.allocations.iter_mut().for_each(Allocation::rotate);
        Ok(())
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
