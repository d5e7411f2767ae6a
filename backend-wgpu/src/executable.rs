//! A schedule that is ready to run.
mod engine;

use crate::buffers::{Parity, Readback};
use crate::context::Context;
use crate::record::Recorder;
use crate::steps::Steps;
use crate::stores::Stores;
use crate::timing::Timer;
use crate::uploads::Uploads;
use gibs_graph::{
    BackendError, Executable, ResourceId, Schedule, StepTime, check_image, check_range, check_step,
    lent,
};
use std::sync::Arc;

/// A schedule with its buffers, pipelines and bind groups.
pub struct WgpuExecutable {
    context: Arc<Context>,
    schedule: Arc<Schedule>,
    stores: Stores,
    steps: Steps,
    /// Of the last frame. A frame starts by turning it over, so that what was current becomes the frame before's.
    parity: Parity,
    uploads: Uploads,
    /// The last two submissions made here, the older one first.
    under_way: [Option<wgpu::SubmissionIndex>; 2],
    readback: Readback,
    timer: Option<Timer>,
    measuring: bool,
}

impl WgpuExecutable {
    pub(crate) fn new(
        context: Arc<Context>,
        schedule: Arc<Schedule>,
        old: Option<(&Stores, Parity)>,
    ) -> Result<Self, BackendError> {
        context.capabilities.check(&context.info.name, &schedule)?;
        // All kernels before any memory: what is wrong with them is the likelier and the cheaper failure.
        let steps = Steps::new(&context, &schedule)?;
        let stores = Stores::new(&context, &schedule, old)?;
        let timer = Timer::new(&context, &schedule)?;
        Ok(Self {
            context,
            schedule,
            stores,
            steps,
            parity: Parity::default(),
            uploads: Uploads::default(),
            under_way: [None, None],
            readback: Readback::default(),
            timer,
            measuring: false,
        })
    }

    /// Records what waits and a frame, whose steps are bound.
    fn record_frame(&mut self, encoder: &mut wgpu::CommandEncoder) -> Result<(), BackendError> {
        self.record_uploads_and_builds(encoder)?;
        self.parity = self.parity.other();
        let mut timer = self.timer.as_mut().filter(|_| self.measuring);
        let recorder = Recorder {
            stores: &self.stores,
            parity: self.parity,
            timer: timer.as_deref(),
        };
        recorder.record(encoder, self.steps.all());
        if let Some(timer) = &mut timer {
            timer.resolve(encoder);
        }
        Ok(())
    }

    /// Records what waits, and builds the acceleration structures that it changes.
    fn record_uploads_and_builds(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<(), BackendError> {
        self.stores.structures.prepare(&self.context)?;
        self.uploads.record(&self.context, encoder)?;
        self.stores.record_structures(encoder);
        Ok(())
    }

    /// Runs `record` on an encoder of its own and submits it. At most two such submissions are under way: a host that
    /// never waits would pile up work, and the staging memory of its uploads.
    fn submit(
        &mut self,
        record: impl FnOnce(&mut Self, &mut wgpu::CommandEncoder) -> Result<(), BackendError>,
    ) -> Result<(), BackendError> {
        if let Some(oldest) = self.under_way[0].take() {
            self.context.wait(Some(oldest))?;
        }
        let context = Arc::clone(&self.context);
        let submitted = context.guard(|| {
            let descriptor = wgpu::CommandEncoderDescriptor {
                label: Some(&context.info.name),
            };
            let mut encoder = context.device.create_command_encoder(&descriptor);
            record(self, &mut encoder)?;
            Ok(context.queue.submit([encoder.finish()]))
        })??;
        self.under_way = [self.under_way[1].take(), Some(submitted)];
        Ok(())
    }

    /// Submits the uploads that wait.
    fn submit_uploads(&mut self) -> Result<(), BackendError> {
        if self.uploads.is_empty() {
            return Ok(());
        }
        self.submit(|this, encoder| this.uploads.record(&this.context, encoder))
    }

    /// Fails where the host has the memory of a resource.
    fn refuse_lent(&self, resource: ResourceId, done: &str) -> Result<(), BackendError> {
        match self.stores.import(resource) {
            None => Ok(()),
            Some(_) => Err(lent(&self.schedule.resources[resource as usize], done)),
        }
    }

    fn upload_image(&mut self, resource: ResourceId, bytes: &[u8]) -> Result<(), BackendError> {
        let found = &self.schedule.resources[resource as usize];
        check_image(found, bytes.len())?;
        match self.stores.own_image(&self.context, resource)? {
            Some(image) => image.write(&self.context, bytes),
            None => Ok(()),
        }
    }
}

impl Executable for WgpuExecutable {
    fn schedule(&self) -> &Arc<Schedule> {
        &self.schedule
    }

    /// Of a resource that no stage sees on the device, the bytes are not needed and are dropped. See
    /// [`WgpuExecutable::record`] for uploads between recorded frames.
    fn upload(
        &mut self,
        resource: ResourceId,
        offset: u64,
        bytes: &[u8],
    ) -> Result<(), BackendError> {
        check_range(&self.schedule, resource, offset, bytes.len())?;
        self.refuse_lent(resource, "written")?;
        if self.schedule.resources[resource as usize].image.is_some() {
            return self.upload_image(resource, bytes);
        }
        if self.stores.structures.write(resource, offset, bytes) {
            return Ok(());
        }
        let Some(buffer) = self.stores.current(resource, self.parity).cloned() else {
            return Ok(());
        };
        if self.uploads.must_go_before(&buffer, bytes.len()) {
            self.submit_uploads()?;
        }
        let key = &self.schedule.resources[resource as usize].key;
        self.uploads.put(&self.context, &buffer, key, offset, bytes)
    }

    fn run(&mut self) -> Result<(), BackendError> {
        self.steps.bind(&self.context, &mut self.stores)?;
        self.submit(Self::record_frame)
    }

    fn rotate(&mut self) -> Result<(), BackendError> {
        self.parity = self.parity.other();
        Ok(())
    }

    fn run_step(&mut self, step: usize) -> Result<(), BackendError> {
        check_step(&self.schedule, step)?;
        self.steps.bind(&self.context, &mut self.stores)?;
        self.submit(|this, encoder| {
            this.record_uploads_and_builds(encoder)?;
            let recorder = Recorder {
                stores: &this.stores,
                parity: this.parity,
                timer: None,
            };
            recorder.record(encoder, std::slice::from_ref(&this.steps.all()[step]));
            Ok(())
        })
    }

    fn read(&mut self, resource: ResourceId) -> Result<Vec<u8>, BackendError> {
        check_range(&self.schedule, resource, 0, 0)?;
        self.refuse_lent(resource, "read")?;
        if self.schedule.resources[resource as usize].image.is_some() {
            return match self.stores.own_image(&self.context, resource)? {
                Some(image) => image.read(&self.context),
                None => Ok(Vec::new()),
            };
        }
        if let Some(instances) = self.stores.structures.read(resource) {
            return Ok(instances);
        }
        self.submit_uploads()?;
        let found = &self.schedule.resources[resource as usize];
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
        self.submit_uploads()?;
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

    fn lent(&self, resource: ResourceId) -> bool {
        self.stores.import(resource).is_some()
    }

    /// Uploads that wait come in front of the first frame. A state that grows is copied now, ahead of frames that were
    /// recorded and are not submitted yet.
    fn adopt(&mut self, schedule: Arc<Schedule>) -> Result<(), BackendError> {
        let grows = |(from, to): (ResourceId, ResourceId)| {
            let old = &self.schedule.resources[from as usize];
            old.len < schedule.resources[to as usize].len
        };
        if schedule.adoptions(&self.schedule).into_iter().any(grows) {
            self.submit_uploads()?;
        }
        let old = Some((&self.stores, self.parity));
        let new = Self::new(Arc::clone(&self.context), schedule, old)?;
        *self = Self {
            uploads: std::mem::take(&mut self.uploads),
            under_way: std::mem::take(&mut self.under_way),
            measuring: self.measuring,
            ..new
        };
        Ok(())
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
