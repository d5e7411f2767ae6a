//! A schedule that is ready to run on a Vulkan device.
use crate::descriptors::Descriptors;
use crate::device::Device;
use crate::kernels;
use crate::record::Program;
use crate::storage::{Store, allocate};
use crate::stream::Stream;
use crate::timing::Timer;
use ash::vk;
use gibs_graph::{
    BackendError, Executable, Kind, Resource, ResourceId, Schedule, StepTime, check_range,
};
use std::any::Any;
use std::sync::Arc;

/// A schedule with its buffers, pipelines and command buffers.
///
/// Frames alternate between even and odd parity, which decides which allocation of a history is the current one. Each
/// parity has its command buffer, recorded once, so that up to two frames are under way.
pub struct VulkanExecutable {
    schedule: Arc<Schedule>,
    /// First, so that it waits for all work before anything else goes.
    stream: Stream,
    program: Program,
    frames: [Frame; 2],
    /// Parity of the last frame.
    parity: usize,
    measuring: bool,
    timer: Option<Timer>,
    /// Held for as long as the program refers to them.
    _descriptors: Descriptors,
    stores: Vec<Option<Store>>,
}

/// The command buffer for frames of one parity.
struct Frame {
    commands: vk::CommandBuffer,
    /// Submission that it was last part of.
    last: u64,
    /// Recorded, and whether with timestamps.
    recorded: Option<bool>,
}

impl VulkanExecutable {
    /// Builds everything that `schedule` needs, with the state of `old` where the two agree.
    pub(crate) fn new(
        device: &Arc<Device>,
        schedule: Arc<Schedule>,
        old: Option<Self>,
    ) -> Result<Self, BackendError> {
        device.adapter.limits.check(&schedule)?;
        let kernels = kernels::build(device, &schedule)?;
        let mut adopted = Vec::new();
        if let Some(mut old) = old {
            old.stream.finish()?;
            for (from, to) in schedule.adoptions(&old.schedule) {
                if let Some(mut store) = old.stores[from as usize].take() {
                    // The first frame after this one is odd, so what is current now is current for even parity.
                    if old.parity == 1 {
                        store.swap();
                    }
                    adopted.push((to, store));
                }
            }
            // The rest goes here, before anything new is allocated.
        }
        // Before the stream, so that after an error below the stream goes first and waits for its work.
        let mut stores = Vec::with_capacity(schedule.resources.len());
        let mut stream = Stream::new(device)?;
        allocate(device, &schedule, adopted, &mut stream, &mut stores)?;
        stream.submit(None)?;
        let descriptors = Descriptors::new(device, &schedule, &kernels, &stores)?;
        let program = Program::new(&schedule, &kernels, &stores, &descriptors);
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
            _descriptors: descriptors,
            stores,
        })
    }

    /// The device that it was made for.
    pub(crate) fn device(&self) -> &Arc<Device> {
        &self.stream.device
    }

    /// The Vulkan buffer of a resource, of a history the current allocation, for engines that use it in place. `None`
    /// where the device has none. It stays valid until the executable is dropped or adopted from, and its content is
    /// that of the last frame once [`Executable::wait`] returned.
    pub fn buffer(&self, resource: ResourceId) -> Option<vk::Buffer> {
        let store = self.stores.get(resource as usize)?.as_ref()?;
        Some(store.current(self.parity).raw)
    }

    fn record(&mut self, parity: usize) -> Result<(), BackendError> {
        if self.measuring && self.timer.is_none() {
            self.timer = Timer::new(&self.stream.device, self.schedule.steps.len())?;
        }
        let timer = self.timer.as_ref().filter(|_| self.measuring);
        let device = &self.stream.device;
        let frame = &mut self.frames[parity];
        frame.recorded = None;
        // SAFETY: the command buffer is not pending (its last submission was waited for), recording it again resets
        // it, and everything that the program refers to lives as long as this value, which waits when it is dropped.
        unsafe {
            device
                .raw
                .begin_command_buffer(frame.commands, &vk::CommandBufferBeginInfo::default())
                .map_err(device.fail("vkBeginCommandBuffer"))?;
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
        match &self.stores[resource as usize] {
            Some(store) => self.stream.write(store.current(self.parity), offset, bytes),
            // Only CPU kernels read it.
            None => Ok(()),
        }
    }

    fn run(&mut self) -> Result<(), BackendError> {
        let parity = 1 - self.parity;
        self.stream.wait(self.frames[parity].last)?;
        if self.frames[parity].recorded != Some(self.measuring) {
            self.record(parity)?;
        }
        let frame = &mut self.frames[parity];
        frame.last = self.stream.submit(Some(frame.commands))?;
        if let Some(timer) = self.timer.as_mut().filter(|_| self.measuring) {
            timer.submitted(parity, frame.last);
        }
        self.parity = parity;
        Ok(())
    }

    fn run_step(&mut self, step: usize) -> Result<(), BackendError> {
        let steps = self.schedule.steps.len();
        if step >= steps {
            return Err(BackendError::Range {
                resource: format!("the steps of {}", self.schedule.name),
                bytes: steps as u64,
                offset: step as u64,
                end: step as u64,
            });
        }
        let commands = self.stream.batch()?;
        // SAFETY: the batch is being recorded; as for frames, everything outlives the work.
        unsafe {
            self.program
                .record_step(&self.stream.device, commands, self.parity, step)
        };
        self.stream.submit(None).map(drop)
    }

    fn read(&mut self, resource: ResourceId) -> Result<Vec<u8>, BackendError> {
        check_range(&self.schedule, resource, 0, 0)?;
        let Resource { key, bytes, .. } = &self.schedule.resources[resource as usize];
        match &self.stores[resource as usize] {
            Some(store) => self.stream.read(store.current(self.parity), *bytes),
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
        for (store, resource) in self.stores.iter().zip(&self.schedule.resources) {
            if let (Some(store), Kind::State(_) | Kind::History(_)) = (store, &resource.kind) {
                store.initialize(&mut self.stream, resource)?;
            }
        }
        Ok(())
    }

    fn wait(&mut self) -> Result<(), BackendError> {
        self.stream.finish()
    }

    fn measure(&mut self, on: bool) {
        self.measuring = on;
    }

    fn timings(&mut self) -> Result<Option<Vec<StepTime>>, BackendError> {
        let Some(timer) = &self.timer else {
            return Ok(None);
        };
        match timer.last() {
            Some(number) => self.stream.wait(number)?,
            None => return Ok(None),
        }
        timer.read()
    }

    fn into_any(self: Box<Self>) -> Box<dyn Any> {
        self
    }
}
