//! The order of work: command buffers that run once, and the count of what was submitted.
use crate::barriers::open;
use crate::device::Device;
use crate::pending::Pending;
use crate::transfer::Staging;
use ash::vk;
use gibs_graph::BackendError;
use std::sync::Arc;

/// Work of one executable, in order.
///
/// Uploads, read-backs and single steps are recorded into a *batch*, a command buffer that runs once. Submitting sends
/// the batch, and a frame after it. Submissions are numbered from 1; a timeline semaphore counts those that are done.
pub(crate) struct Stream {
    pub device: Arc<Device>,
    pool: vk::CommandPool,
    timeline: vk::Semaphore,
    submitted: u64,
    batch: Option<vk::CommandBuffer>,
    /// Command buffers for batches, and the submission that each was last part of.
    batches: Vec<(vk::CommandBuffer, u64)>,
    pub(crate) staging: Staging,
    pub(crate) pending: Pending,
}

impl Stream {
    /// A stream without work.
    pub fn new(device: &Arc<Device>) -> Result<Self, BackendError> {
        let mut stream = Self {
            device: Arc::clone(device),
            pool: vk::CommandPool::null(),
            timeline: vk::Semaphore::null(),
            submitted: 0,
            batch: None,
            batches: Vec::new(),
            staging: Staging::default(),
            pending: Pending::default(),
        };
        let info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(device.adapter.family)
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER);
        // SAFETY: the device is alive and has a queue of this family.
        stream.pool = unsafe { device.raw.create_command_pool(&info, None) }
            .map_err(device.fail("vkCreateCommandPool"))?;
        let mut kind = vk::SemaphoreTypeCreateInfo::default()
            .semaphore_type(vk::SemaphoreType::TIMELINE)
            .initial_value(0);
        let info = vk::SemaphoreCreateInfo::default().push_next(&mut kind);
        // SAFETY: the device is alive and has timeline semaphores.
        stream.timeline = unsafe { device.raw.create_semaphore(&info, None) }
            .map_err(device.fail("vkCreateSemaphore"))?;
        // As many as two frames under way and uploads for a third one need: how far the device lags behind then makes no
        // object.
        for _ in 0..3 {
            stream.batches.push((stream.allocate()?, 0));
        }
        Ok(stream)
    }

    /// A new command buffer.
    pub fn allocate(&self) -> Result<vk::CommandBuffer, BackendError> {
        let info = vk::CommandBufferAllocateInfo::default()
            .command_pool(self.pool)
            .level(vk::CommandBufferLevel::PRIMARY)
            .command_buffer_count(1);
        // SAFETY: the pool belongs to this device and, through `&self` of a value that is not shared, to this thread.
        let commands = unsafe { self.device.raw.allocate_command_buffers(&info) };
        Ok(commands.map_err(self.device.fail("vkAllocateCommandBuffers"))?[0])
    }

    /// The open batch, with everything in it that was held back. A new one starts behind everything that was submitted
    /// before.
    pub fn batch(&mut self) -> Result<vk::CommandBuffer, BackendError> {
        let commands = match self.batch {
            Some(commands) => commands,
            None => self.begin()?,
        };
        // SAFETY: the batch is being recorded; resources wait before they go.
        unsafe {
            self.pending
                .record(&self.device.raw, commands, &mut self.staging.written)
        };
        Ok(commands)
    }

    /// Something is recorded that was not submitted yet.
    pub fn is_open(&self) -> bool {
        self.batch.is_some()
    }

    fn begin(&mut self) -> Result<vk::CommandBuffer, BackendError> {
        let done = self.done()?;
        let number = self.number();
        let commands = match self.batches.iter_mut().find(|(_, last)| *last <= done) {
            Some((commands, last)) => {
                *last = number;
                *commands
            }
            None => {
                let commands = self.allocate()?;
                self.batches.push((commands, number));
                commands
            }
        };
        let info = vk::CommandBufferBeginInfo::default()
            .flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the command buffer is not pending: it is new, or its last submission is done.
        unsafe { self.device.raw.begin_command_buffer(commands, &info) }
            .map_err(self.device.fail("vkBeginCommandBuffer"))?;
        // SAFETY: recording began above.
        unsafe { open(&self.device.raw, commands) };
        self.staging.begin(done);
        self.batch = Some(commands);
        Ok(commands)
    }

    /// Number of the next submission: the one that the open batch will be part of.
    pub fn number(&self) -> u64 {
        self.submitted + 1
    }

    /// Number of the last submission that is done.
    pub fn done(&self) -> Result<u64, BackendError> {
        // SAFETY: the semaphore is a timeline of this device.
        unsafe { self.device.raw.get_semaphore_counter_value(self.timeline) }
            .map_err(self.device.fail("vkGetSemaphoreCounterValue"))
    }

    /// Sends what was held back or is open, if anything, and then `frame`, which must be recorded and not pending. Returns the
    /// number of the submission, or of the last one where there was nothing to send.
    pub fn submit(&mut self, frame: Option<vk::CommandBuffer>) -> Result<u64, BackendError> {
        if !self.pending.is_empty() {
            self.batch()?;
        }
        let batch = self.batch.take();
        if let Some(commands) = batch {
            // SAFETY: the batch is being recorded.
            unsafe { self.device.raw.end_command_buffer(commands) }
                .map_err(self.device.fail("vkEndCommandBuffer"))?;
        }
        let both = [batch.unwrap_or_default(), frame.unwrap_or_default()];
        let commands = match (batch, frame) {
            (None, None) => return Ok(self.submitted),
            (Some(_), None) => &both[..1],
            (None, Some(_)) => &both[1..],
            (Some(_), Some(_)) => &both[..],
        };
        let signal = [self.timeline];
        let values = [self.number()];
        let mut numbers =
            vk::TimelineSemaphoreSubmitInfo::default().signal_semaphore_values(&values);
        let submission = vk::SubmitInfo::default()
            .command_buffers(commands)
            .signal_semaphores(&signal)
            .push_next(&mut numbers);
        self.device.submit(&submission)?;
        self.submitted += 1;
        Ok(self.submitted)
    }

    /// Waits until submission `number` is done.
    pub fn wait(&self, number: u64) -> Result<(), BackendError> {
        if number == 0 {
            return Ok(());
        }
        let semaphores = [self.timeline];
        let values = [number];
        let info = vk::SemaphoreWaitInfo::default()
            .semaphores(&semaphores)
            .values(&values);
        // SAFETY: the semaphore is a timeline of this device.
        unsafe { self.device.raw.wait_semaphores(&info, u64::MAX) }
            .map_err(self.device.fail("vkWaitSemaphores"))
    }

    /// Sends what is open and waits for everything.
    pub fn finish(&mut self) -> Result<(), BackendError> {
        let last = self.submit(None)?;
        self.wait(last)
    }
}

impl Drop for Stream {
    fn drop(&mut self) {
        // A lost device has no work left to wait for, so the error does not matter.
        let _ = self.wait(self.submitted);
        // SAFETY: nothing submitted is under way any more; a batch that is still open is freed with its pool.
        unsafe {
            self.device.raw.destroy_semaphore(self.timeline, None);
            self.device.raw.destroy_command_pool(self.pool, None);
        }
    }
}
