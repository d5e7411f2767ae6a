//! A schedule that is ready to run on a Vulkan device.
use crate::barriers::open;
use crate::bound::Bound;
use crate::descriptors::Descriptors;
use crate::device::Device;
use crate::imports::Imports;
use crate::kernels;
use crate::pending::Pending;
use crate::record::{Program, known};
use crate::storage::Stores;
use crate::stream::Stream;
use crate::timing::Timer;
use ash::vk;
use gibs_graph::{
    BackendError, Executable, Resource, ResourceId, Schedule, StepTime, check_range, check_step,
};
use std::sync::Arc;

/// A schedule with its buffers, images, pipelines and command buffers.
///
/// Frames alternate between even and odd parity, which decides which allocation of a history is the current one. Each
/// parity has its command buffer, recorded once, so that up to two frames are under way.
///
/// A host may lend images and buffers ([`VulkanExecutable::import_image`], [`VulkanExecutable::import_buffer`]) and
/// have frames recorded into command buffers of its own ([`VulkanExecutable::record`]).
pub struct VulkanExecutable {
    pub(crate) schedule: Arc<Schedule>,
    /// First, so that it waits for all work before anything else goes.
    pub(crate) stream: Stream,
    pub(crate) program: Program,
    pub(crate) frames: [Frame; 2],
    /// Parity of the last frame.
    pub(crate) parity: usize,
    pub(crate) measuring: bool,
    pub(crate) timer: Option<Timer>,
    pub(crate) descriptors: Descriptors,
    pub(crate) imports: Imports,
    /// What the host does after a frame that it has recorded.
    pub(crate) exit: (vk::PipelineStageFlags, vk::AccessFlags),
    pub(crate) stores: Stores,
}

/// The command buffer for frames of one parity.
pub(crate) struct Frame {
    commands: vk::CommandBuffer,
    /// Submission that it was last part of.
    last: u64,
    /// Recorded, and whether with timestamps.
    pub recorded: Option<bool>,
}

impl VulkanExecutable {
    /// Builds everything that `schedule` needs.
    pub(crate) fn new(device: &Arc<Device>, schedule: Arc<Schedule>) -> Result<Self, BackendError> {
        let adapter = &device.adapter;
        adapter.capabilities.check(&adapter.info.name, &schedule)?;
        known(&schedule)?;
        let kernels = kernels::build(device, &schedule)?;
        // Before the stream, so that after an error below the stream goes first and waits for its work.
        let mut stores = Stores::new(&schedule);
        let mut stream = Stream::new(device)?;
        stores.fill(&schedule, &mut stream)?;
        stream.submit(None)?;
        let imports = Imports::default();
        let bound = Bound {
            stores: &stores,
            imports: &imports,
        };
        let program = Program::new(&schedule, &kernels, bound);
        let descriptors = Descriptors::new(device, &schedule, kernels, bound)?;
        let frame = |stream: &Stream| {
            let commands = stream.allocate()?;
            Ok(Frame {
                commands,
                last: 0,
                recorded: None,
            })
        };
        Ok(Self {
            frames: [frame(&stream)?, frame(&stream)?],
            schedule,
            stream,
            program,
            parity: 0,
            measuring: false,
            timer: None,
            descriptors,
            imports,
            exit: (
                vk::PipelineStageFlags::ALL_COMMANDS,
                vk::AccessFlags::MEMORY_READ,
            ),
            stores,
        })
    }

    /// Makes what frames of this parity refer to what is bound now.
    pub(crate) fn resolve(&mut self, parity: usize) -> Result<(), BackendError> {
        if self.program.is_resolved(parity, &self.imports) {
            return Ok(());
        }
        for (id, resource) in (0..).zip(&self.schedule.resources) {
            if resource.image.is_some() && self.imports.get(id).is_none() {
                self.stores.make_image(id, resource, &mut self.stream)?;
            }
        }
        // What is recorded refers to the bindings before.
        self.frames[parity].recorded = None;
        let bound = Bound {
            stores: &self.stores,
            imports: &self.imports,
        };
        self.program
            .resolve(&self.schedule, &mut self.descriptors, bound, parity)
    }

    /// The timer, where frames are measured and the device can.
    pub(crate) fn start_timer(&mut self) -> Result<(), BackendError> {
        if self.measuring && self.timer.is_none() {
            self.timer = Timer::new(&self.stream.device, self.schedule.steps.len())?;
        }
        Ok(())
    }

    /// Records the command buffer for frames of this parity.
    fn prepare_frame(&mut self, parity: usize) -> Result<(), BackendError> {
        self.start_timer()?;
        let timer = self.timer.as_ref().filter(|_| self.measuring);
        let device = &self.stream.device;
        let frame = &mut self.frames[parity];
        frame.recorded = None;
        // SAFETY: the command buffer is not pending (its last submission was waited for), recording it again resets
        // it, and everything that the program refers to lives as long as this value, which waits when it is dropped,
        // or was lent for as long as frames may use it.
        unsafe {
            device
                .raw
                .begin_command_buffer(frame.commands, &vk::CommandBufferBeginInfo::default())
                .map_err(device.fail("vkBeginCommandBuffer"))?;
            open(&device.raw, frame.commands);
            self.program
                .record_frame(device, frame.commands, parity, timer);
            device
                .raw
                .end_command_buffer(frame.commands)
                .map_err(device.fail("vkEndCommandBuffer"))?;
        }
        frame.recorded = Some(self.measuring);
        Ok(())
    }
}

impl Executable for VulkanExecutable {
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
        self.refuse_lent(resource, "written")?;
        if self.schedule.resources[resource as usize].image.is_some() {
            return self.upload_image(resource, bytes);
        }
        if bytes.is_empty() {
            return Ok(());
        }
        if self.stores.structures.write(resource, offset, bytes) {
            return Ok(());
        }
        let Some(target) = self.stores.buffer(resource, self.parity) else {
            // Only CPU kernels read it.
            return Ok(());
        };
        if !Pending::takes(offset, bytes.len()) {
            return self.stream.write(target, offset, bytes);
        }
        if !self.stream.pending.has_room(bytes.len()) {
            self.stream.batch()?;
        }
        self.stream.pending.hold(target, offset, bytes);
        Ok(())
    }

    fn run(&mut self) -> Result<(), BackendError> {
        let parity = 1 - self.parity;
        self.stores.build_structures(&mut self.stream)?;
        self.stream.wait(self.frames[parity].last)?;
        self.resolve(parity)?;
        if self.frames[parity].recorded != Some(self.measuring) {
            self.prepare_frame(parity)?;
        }
        let frame = &mut self.frames[parity];
        frame.last = self.stream.submit(Some(frame.commands))?;
        if let Some(timer) = self.timer.as_mut().filter(|_| self.measuring) {
            timer.submitted(parity, Some(frame.last));
        }
        self.parity = parity;
        Ok(())
    }

    fn rotate(&mut self) -> Result<(), BackendError> {
        self.parity = 1 - self.parity;
        Ok(())
    }

    fn run_step(&mut self, step: usize) -> Result<(), BackendError> {
        check_step(&self.schedule, step)?;
        self.stores.build_structures(&mut self.stream)?;
        self.resolve(self.parity)?;
        let commands = self.stream.batch()?;
        // SAFETY: the batch is being recorded; as for frames, everything outlives the work.
        unsafe {
            let device = &self.stream.device;
            open(&device.raw, commands);
            self.program
                .record_step(device, commands, self.parity, step)
        };
        self.stream.submit(None).map(drop)
    }

    fn read(&mut self, resource: ResourceId) -> Result<Vec<u8>, BackendError> {
        check_range(&self.schedule, resource, 0, 0)?;
        self.refuse_lent(resource, "read")?;
        let Resource {
            key, bytes, image, ..
        } = &self.schedule.resources[resource as usize];
        if image.is_some() {
            return self.read_image(resource);
        }
        if let Some(instances) = self.stores.structures.read(resource) {
            return Ok(instances);
        }
        match self.stores.buffer(resource, self.parity) {
            Some(buffer) => self.stream.read(buffer, *bytes),
            None => {
                // The device has no byte of it.
                let (resource, end) = (key.clone(), *bytes);
                Err(BackendError::Range {
                    resource,
                    bytes: 0,
                    offset: 0,
                    end,
                })
            }
        }
    }

    fn reset(&mut self) -> Result<(), BackendError> {
        self.stores.reset(&self.schedule, &mut self.stream)
    }

    fn wait(&mut self) -> Result<(), BackendError> {
        self.stores.build_structures(&mut self.stream)?;
        self.stream.finish()
    }

    fn measure(&mut self, on: bool) {
        self.measuring = on;
    }

    fn timings(&mut self) -> Result<Option<Vec<StepTime>>, BackendError> {
        let Some(timer) = &self.timer else {
            return Ok(None);
        };
        if let Some(Some(number)) = timer.last() {
            self.stream.wait(number)?;
        }
        timer.read()
    }

    fn lent(&self, resource: ResourceId) -> bool {
        self.imports.get(resource).is_some()
    }

    /// Copies what carries over, so that until the end nothing of the old schedule changes.
    fn adopt(&mut self, schedule: Arc<Schedule>) -> Result<(), BackendError> {
        self.stream.finish()?;
        let mut new = Self::new(&self.stream.device, schedule)?;
        let pairs = new.schedule.adoptions(&self.schedule);
        for &(from, to) in &pairs {
            let structures = &mut new.stores.structures;
            structures.adopt(to, &self.stores.structures, from);
            let resource = &self.schedule.resources[from as usize];
            for other in 0..resource.kind.allocations() as usize {
                // The first frame is an odd one, so what is current now is so for even parity.
                let source = self.stores.buffer(from, self.parity ^ other);
                let target = new.stores.buffer(to, other);
                if let (Some(source), Some(target)) = (source, target) {
                    new.stream.copy(source, target, resource.bytes)?;
                }
            }
        }
        new.stream.finish()?;
        for (from, to) in pairs {
            new.stores.take_image(to, &mut self.stores, from);
        }
        (new.measuring, new.exit) = (self.measuring, self.exit);
        *self = new;
        Ok(())
    }
}
