//! A schedule that is ready to run.
use crate::buffers::{Allocation, Parity, Readback, write};
use crate::context::Context;
use crate::kernels::{Kernel, bind, kernel};
use crate::limits;
use crate::timing::Timer;
use gibs_graph::{
    Action, BackendError, DispatchSize, Executable, ResourceId, Schedule, StepTime, check_range,
};
use std::any::Any;
use std::sync::Arc;

/// A schedule with its buffers, pipelines and bind groups.
pub struct WgpuExecutable {
    context: Arc<Context>,
    schedule: Arc<Schedule>,
    allocations: Vec<Allocation>,
    steps: Vec<Prepared>,
    /// Of the last frame. A frame starts by turning it over, so that what was current becomes the frame before's.
    parity: Parity,
    readback: Readback,
    timer: Option<Timer>,
    measuring: bool,
}

/// A step with everything that recording it takes.
enum Prepared {
    Clear(ResourceId),
    Dispatch(Box<Dispatch>),
}

struct Dispatch {
    step: usize,
    label: String,
    kernel: Arc<Kernel>,
    groups: [wgpu::BindGroup; 2],
    size: DispatchSize,
}

impl WgpuExecutable {
    pub(crate) fn new(
        context: Arc<Context>,
        schedule: Arc<Schedule>,
        adopt: Option<WgpuExecutable>,
    ) -> Result<Self, BackendError> {
        limits::check(&schedule, &context.limits, &context.info.name)?;
        // All kernels before any memory: what is wrong with them is the likelier and the cheaper failure.
        for (_, step, dispatch) in schedule.dispatches() {
            kernel(&context, &step.label, dispatch)?;
        }
        let allocations = allocate(&context, &schedule, adopt)?;
        let mut steps = Vec::with_capacity(schedule.steps.len());
        for (i, step) in schedule.steps.iter().enumerate() {
            let label = &step.label;
            steps.push(match &step.action {
                Action::Clear(resource) => Prepared::Clear(*resource),
                Action::Dispatch(dispatch) => {
                    let kernel = kernel(&context, label, dispatch)?;
                    let groups = bind(
                        &context,
                        label,
                        &kernel,
                        dispatch,
                        &schedule.resources,
                        &allocations,
                    )?;
                    let (label, size) = (label.clone(), dispatch.size);
                    Prepared::Dispatch(Box::new(Dispatch {
                        step: i,
                        label,
                        kernel,
                        groups,
                        size,
                    }))
                }
            });
        }
        let timer = Timer::new(&context, schedule.dispatches().map(|(i, ..)| i).collect())?;
        Ok(Self {
            context,
            schedule,
            allocations,
            steps,
            parity: Parity::default(),
            readback: Readback::default(),
            timer,
            measuring: false,
        })
    }

    /// The backend with this context made it. (Devices cannot be compared: wgpu numbers them per instance.)
    pub(crate) fn runs_on(&self, context: &Arc<Context>) -> bool {
        Arc::ptr_eq(&self.context, context)
    }

    /// Records one frame into an engine's encoder, without submitting it. Uploads take effect when the queue is next
    /// submitted to, before everything in that submission: upload for one frame per submission.
    ///
    /// # Errors
    /// The device failed. What is wrong with the encoder itself shows when it is finished.
    pub fn record(&mut self, encoder: &mut wgpu::CommandEncoder) -> Result<(), BackendError> {
        self.parity = self.parity.other();
        let context = Arc::clone(&self.context);
        context.guard(|| {
            let timer = self.timer.as_ref().filter(|_| self.measuring);
            // A timed step has a pass of its own.
            let together = |a: &Prepared, b: &Prepared| {
                timer.is_none() && matches!((a, b), (Prepared::Dispatch(_), Prepared::Dispatch(_)))
            };
            for run in self.steps.chunk_by(together) {
                self.record_steps(encoder, run, timer);
            }
            if let Some(timer) = self.timer.as_mut().filter(|_| self.measuring) {
                timer.resolve(encoder);
            }
        })
    }

    /// The buffer of a resource for an engine to read from, or, of an input, to copy into; of a history, the one that
    /// the last recorded frame wrote. `None` where no stage sees it on the device.
    pub fn buffer(&self, resource: ResourceId) -> Option<&wgpu::Buffer> {
        self.allocations
            .get(resource as usize)?
            .current(self.parity)
    }

    /// Records either one clear, or dispatches in one pass.
    fn record_steps(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        run: &[Prepared],
        timer: Option<&Timer>,
    ) {
        match run {
            [] => {}
            [Prepared::Clear(resource), ..] => {
                if let Some(buffer) = self.buffer(*resource) {
                    encoder.clear_buffer(buffer, 0, None);
                }
            }
            [Prepared::Dispatch(first), ..] => {
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                    label: Some(&first.label),
                    timestamp_writes: timer.and_then(|timer| timer.writes(first.step)),
                });
                for step in run {
                    if let Prepared::Dispatch(dispatch) = step {
                        self.record_dispatch(&mut pass, dispatch);
                    }
                }
            }
        }
    }

    fn record_dispatch(&self, pass: &mut wgpu::ComputePass<'_>, dispatch: &Dispatch) {
        if matches!(dispatch.size, DispatchSize::Groups(groups) if groups.contains(&0)) {
            return;
        }
        pass.set_pipeline(&dispatch.kernel.pipeline);
        pass.set_bind_group(0, &dispatch.groups[self.parity.index()], &[]);
        match dispatch.size {
            DispatchSize::Groups([x, y, z]) => pass.dispatch_workgroups(x, y, z),
            DispatchSize::Indirect(args) => {
                if let Some(args) = self.buffer(args) {
                    pass.dispatch_workgroups_indirect(args, 0);
                }
            }
        }
    }

    /// Runs `record` on an encoder of its own and submits it.
    fn submit(
        &mut self,
        record: impl FnOnce(&mut Self, &mut wgpu::CommandEncoder) -> Result<(), BackendError>,
    ) -> Result<(), BackendError> {
        let context = Arc::clone(&self.context);
        context.guard(|| {
            let descriptor = wgpu::CommandEncoderDescriptor {
                label: Some(&context.info.name),
            };
            let mut encoder = context.device.create_command_encoder(&descriptor);
            record(self, &mut encoder)?;
            context.queue.submit([encoder.finish()]);
            Ok(())
        })?
    }
}

/// Takes over what both schedules keep, and allocates the rest.
fn allocate(
    context: &Context,
    schedule: &Schedule,
    adopt: Option<WgpuExecutable>,
) -> Result<Vec<Allocation>, BackendError> {
    let mut adopted: Vec<Option<Allocation>> = schedule.resources.iter().map(|_| None).collect();
    if let Some(mut old) = adopt {
        for (from, to) in schedule.adoptions(&old.schedule) {
            let allocation = std::mem::take(&mut old.allocations[from as usize]);
            if allocation.is_on_device() && schedule.resources[to as usize].usage.on_device() {
                adopted[to as usize] = Some(allocation.rebase(old.parity));
            }
        }
    }
    let resources = schedule.resources.iter();
    resources
        .zip(adopted)
        .map(|(r, kept)| kept.map_or_else(|| Allocation::new(context, r), Ok))
        .collect()
}

impl Executable for WgpuExecutable {
    fn schedule(&self) -> &Arc<Schedule> {
        &self.schedule
    }

    /// Of a resource that no stage sees on the device, the bytes are not needed and are dropped.
    fn upload(
        &mut self,
        resource: ResourceId,
        offset: u64,
        bytes: &[u8],
    ) -> Result<(), BackendError> {
        check_range(&self.schedule, resource, offset, bytes.len())?;
        let Some(buffer) = self.allocations[resource as usize].current(self.parity) else {
            return Ok(());
        };
        let key = &self.schedule.resources[resource as usize].key;
        let end = offset + bytes.len() as u64;
        if offset.is_multiple_of(4) && end.is_multiple_of(4) {
            return write(&self.context, buffer, key, offset, bytes);
        }
        // The queue writes whole words, so the bytes around come along.
        let mut words = self
            .readback
            .read(&self.context, buffer, key, end.next_multiple_of(4))?;
        words[offset as usize..end as usize].copy_from_slice(bytes);
        let first = offset / 4 * 4;
        write(&self.context, buffer, key, first, &words[first as usize..])
    }

    fn run(&mut self) -> Result<(), BackendError> {
        self.submit(Self::record)
    }

    fn run_step(&mut self, step: usize) -> Result<(), BackendError> {
        if step >= self.steps.len() {
            let message = format!(
                "there is no step {step}; the schedule has {}",
                self.steps.len()
            );
            return Err(BackendError::Kernel {
                stage: self.schedule.name.clone(),
                message,
            });
        }
        self.submit(|this, encoder| {
            this.record_steps(encoder, std::slice::from_ref(&this.steps[step]), None);
            Ok(())
        })
    }

    fn read(&mut self, resource: ResourceId) -> Result<Vec<u8>, BackendError> {
        check_range(&self.schedule, resource, 0, 0)?;
        let found = &self.schedule.resources[resource as usize];
        match self.allocations[resource as usize].current(self.parity) {
            Some(buffer) => self
                .readback
                .read(&self.context, buffer, &found.key, found.bytes),
            // Only wide CPU kernels see it, so the device has none of its bytes.
            None => Err(BackendError::Range {
                resource: found.key.clone(),
                bytes: 0,
                offset: 0,
                end: found.bytes,
            }),
        }
    }

    fn reset(&mut self) -> Result<(), BackendError> {
        self.parity = Parity::default();
        for (allocation, resource) in self.allocations.iter().zip(&self.schedule.resources) {
            if allocation.is_on_device() {
                allocation.reset(&self.context, resource)?;
            }
        }
        Ok(())
    }

    fn wait(&mut self) -> Result<(), BackendError> {
        self.context.wait(None)
    }

    fn measure(&mut self, on: bool) {
        self.measuring = on;
    }

    fn timings(&mut self) -> Result<Option<Vec<StepTime>>, BackendError> {
        self.timer
            .as_ref()
            .map_or(Ok(None), |timer| timer.read(&self.context))
    }

    fn into_any(self: Box<Self>) -> Box<dyn Any> {
        self
    }
}

impl std::fmt::Debug for WgpuExecutable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("WgpuExecutable")
            .field("schedule", &self.schedule.name)
            .field("device", &self.context.info.name)
            .finish_non_exhaustive()
    }
}
