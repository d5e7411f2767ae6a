//! A schedule that is ready to run.
use crate::buffers::{Parity, Readback, write};
use crate::context::Context;
use crate::kernels::{Kernel, bind, kernel};
use crate::stores::{Import, Stores};
use crate::timing::Timer;
use gibs_graph::{
    Action, BackendError, DispatchSize, DispatchStep, Executable, Kind, ResourceId, Schedule,
    StepTime, check_image, check_range,
};
use std::any::Any;
use std::sync::Arc;

/// A schedule with its buffers, pipelines and bind groups.
pub struct WgpuExecutable {
    context: Arc<Context>,
    schedule: Arc<Schedule>,
    stores: Stores,
    steps: Vec<Prepared>,
    /// Stages bind something that no bind group has yet.
    unbound: bool,
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
    /// Every set of bind groups that was needed so far, with what it has from the host.
    groups: Vec<(Vec<Import>, [wgpu::BindGroup; 2])>,
    /// Index of the set for the next frame.
    chosen: usize,
    /// What it binds that a host may give.
    imports: Vec<ResourceId>,
    size: DispatchSize,
}

impl WgpuExecutable {
    pub(crate) fn new(
        context: Arc<Context>,
        schedule: Arc<Schedule>,
        adopt: Option<WgpuExecutable>,
    ) -> Result<Self, BackendError> {
        context.capabilities.check(&context.info.name, &schedule)?;
        // All kernels before any memory: what is wrong with them is the likelier and the cheaper failure.
        for (_, step, dispatch) in schedule.dispatches() {
            kernel(&context, &step.label, dispatch)?;
        }
        let old = adopt.map(|old| (old.stores, old.parity));
        let stores = Stores::new(&context, &schedule, old)?;
        let mut steps = Vec::with_capacity(schedule.steps.len());
        for (i, step) in schedule.steps.iter().enumerate() {
            let label = &step.label;
            steps.push(match &step.action {
                Action::Clear(resource) => Prepared::Clear(*resource),
                Action::Dispatch(dispatch) => Prepared::Dispatch(Box::new(Dispatch {
                    step: i,
                    label: label.clone(),
                    kernel: kernel(&context, label, dispatch)?,
                    groups: Vec::new(),
                    chosen: 0,
                    imports: importable(&schedule, dispatch),
                    size: dispatch.size,
                })),
            });
        }
        let timer = Timer::new(&context, schedule.dispatches().map(|(i, ..)| i).collect())?;
        Ok(Self {
            context,
            schedule,
            stores,
            steps,
            unbound: true,
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

    /// Takes an image of the engine for an imported or exported one, from the next recorded frame on: a view of the
    /// first mip level of a two-dimensional texture. One that is read needs `TEXTURE_BINDING` and a format of its class
    /// (a depth view needs the aspect `DepthOnly`), one that is written needs `STORAGE_BINDING` and the very format.
    /// Images that come again and again, as those of a swapchain do, cost bind groups only the first time.
    ///
    /// # Errors
    /// [`BackendError::Refused`]; what else does not fit shows when a frame is recorded.
    pub fn import_image(
        &mut self,
        resource: ResourceId,
        view: &wgpu::TextureView,
    ) -> Result<(), BackendError> {
        let changed = self
            .stores
            .set_import(resource, Import::Image(view.clone()))?;
        self.unbound |= changed;
        Ok(())
    }

    /// Takes a buffer of the engine for an input or an output, from the next recorded frame on. It needs the usage
    /// `STORAGE`, or `UNIFORM` or `INDIRECT`, as stages use it. What is uploaded goes to it as well, and needs
    /// `COPY_DST`.
    ///
    /// # Errors
    /// [`BackendError::Refused`]; what else does not fit shows when a frame is recorded.
    pub fn import_buffer(
        &mut self,
        resource: ResourceId,
        buffer: &wgpu::Buffer,
    ) -> Result<(), BackendError> {
        let changed = self
            .stores
            .set_import(resource, Import::Buffer(buffer.clone()))?;
        self.unbound |= changed;
        Ok(())
    }

    /// Forgets the bind groups of images and buffers that are not in use now: after a resize of the engine's images.
    pub fn forget_imports(&mut self) {
        for step in &mut self.steps {
            if let Prepared::Dispatch(dispatch) = step {
                dispatch.groups.clear();
            }
        }
        self.unbound = true;
    }

    /// Makes or finds the bind groups for what stages bind now.
    fn bind(&mut self) -> Result<(), BackendError> {
        if !std::mem::take(&mut self.unbound) {
            return Ok(());
        }
        // Until all is bound, another call starts over.
        self.unbound = true;
        for (step, prepared) in self.schedule.steps.iter().zip(&mut self.steps) {
            let (Action::Dispatch(declared), Prepared::Dispatch(dispatch)) =
                (&step.action, prepared)
            else {
                continue;
            };
            let now = |dispatch: &Dispatch| {
                let imports = dispatch.imports.iter();
                imports
                    .filter_map(|&r| self.stores.import(r))
                    .cloned()
                    .collect()
            };
            let known = dispatch.groups.iter().position(|(imports, _)| {
                let now = dispatch
                    .imports
                    .iter()
                    .filter_map(|&r| self.stores.import(r));
                imports.iter().eq(now)
            });
            if let Some(known) = known {
                dispatch.chosen = known;
                continue;
            }
            let imports = now(dispatch);
            for binding in declared.bindings.iter().filter(|b| b.access.is_image()) {
                if self.stores.import(binding.resource).is_none() {
                    self.stores.own_image(&self.context, binding.resource)?;
                }
            }
            let groups = bind(
                &self.context,
                &dispatch.label,
                &dispatch.kernel,
                declared,
                &self.schedule,
                &self.stores,
            )?;
            dispatch.chosen = dispatch.groups.len();
            dispatch.groups.push((imports, groups));
        }
        self.unbound = false;
        Ok(())
    }

    /// Records one frame into an engine's encoder, without submitting it. Uploads take effect when the queue is next
    /// submitted to, before everything in that submission: upload for one frame per submission. wgpu orders the frame
    /// behind what the engine recorded before it, and what comes after it behind the frame.
    ///
    /// # Errors
    /// The device failed. What is wrong with the encoder itself shows when it is finished.
    pub fn record(&mut self, encoder: &mut wgpu::CommandEncoder) -> Result<(), BackendError> {
        self.bind()?;
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
        self.stores.current(resource, self.parity)
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
                let bytes = self.schedule.resources[*resource as usize].bytes;
                if let Some(buffer) = self.buffer(*resource) {
                    encoder.clear_buffer(buffer, 0, Some(bytes.next_multiple_of(4)));
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
        let Some((_, groups)) = dispatch.groups.get(dispatch.chosen) else {
            return;
        };
        pass.set_bind_group(0, &groups[self.parity.index()], &[]);
        match dispatch.size {
            DispatchSize::Groups([x, y, z]) => pass.dispatch_workgroups(x, y, z),
            DispatchSize::Indirect(args) => {
                if let Some(args) = self.buffer(args) {
                    pass.dispatch_workgroups_indirect(args, 0);
                }
            }
        }
    }

    fn upload_image(&mut self, resource: ResourceId, bytes: &[u8]) -> Result<(), BackendError> {
        let found = &self.schedule.resources[resource as usize];
        if self.stores.import(resource).is_some() {
            return Err(hosts_image(&found.key));
        }
        check_image(found, bytes.len())?;
        match self.stores.own_image(&self.context, resource)? {
            Some(image) => image.write(&self.context, bytes),
            None => Ok(()),
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

/// What a stage binds that a host may give.
fn importable(schedule: &Schedule, dispatch: &DispatchStep) -> Vec<ResourceId> {
    let bound = dispatch.bindings.iter().filter(|b| b.access.is_bound());
    let mut found: Vec<ResourceId> = bound.map(|b| b.resource).collect();
    found.retain(|&r| {
        !matches!(
            schedule.resources[r as usize].kind,
            Kind::State(_) | Kind::History(_)
        )
    });
    found
}

fn hosts_image(key: &str) -> BackendError {
    BackendError::Refused {
        what: format!("reading or writing `{key}`"),
        reason: "the image is the host's".into(),
        remedy: "use it without the backend".into(),
    }
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
        let found = &self.schedule.resources[resource as usize];
        if found.image.is_some() {
            return self.upload_image(resource, bytes);
        }
        let Some(buffer) = self.stores.current(resource, self.parity) else {
            return Ok(());
        };
        let key = &found.key;
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
        self.bind()?;
        self.submit(|this, encoder| {
            this.record_steps(encoder, std::slice::from_ref(&this.steps[step]), None);
            Ok(())
        })
    }

    fn read(&mut self, resource: ResourceId) -> Result<Vec<u8>, BackendError> {
        check_range(&self.schedule, resource, 0, 0)?;
        let found = &self.schedule.resources[resource as usize];
        if found.image.is_some() {
            return match self.stores.import(resource) {
                Some(_) => Err(hosts_image(&found.key)),
                None => match self.stores.own_image(&self.context, resource)? {
                    Some(image) => image.read(&self.context),
                    None => Ok(Vec::new()),
                },
            };
        }
        match self.stores.current(resource, self.parity) {
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
        for (allocation, resource) in self.stores.allocations.iter().zip(&self.schedule.resources) {
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
