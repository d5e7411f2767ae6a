//! Bytes between host and device: staging pages, recorded copies, read-backs.
use crate::barriers::Barrier;
use crate::memory::Buffer;
use crate::stream::Stream;
use ash::vk;
use ash::vk::Handle;
use gibs_graph::BackendError;

/// Bytes of one page. Larger uploads are cut into pieces.
const PAGE: u64 = 2 << 20;
/// Most pages; with all of them under way, an upload waits for the oldest.
const PAGES: usize = 8;
/// Bytes read back at once.
const WINDOW: u64 = 8 << 20;
/// Writes of a batch that are remembered one by one.
const REMEMBERED: usize = 64;

/// Memory between host and device, kept and used again.
#[derive(Default)]
pub(crate) struct Staging {
    pages: Vec<Page>,
    /// Index of the page that is being filled.
    open: usize,
    /// What the open batch wrote.
    pub written: Written,
    window: Option<Buffer>,
}

struct Page {
    buffer: Buffer,
    used: u64,
    /// Submission that last reads it.
    last: u64,
}

/// What transfers wrote since the last barrier: handle of the buffer or image, first byte, end. Writes to places apart
/// need no order.
#[derive(Default)]
pub(crate) struct Written(Vec<(u64, u64, u64)>);

impl Written {
    /// Forgets everything: a barrier was recorded.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// Puts a barrier before a write that meets an earlier one.
    ///
    /// # Safety
    /// `commands` is a command buffer of `device` that is being recorded.
    pub unsafe fn order(
        &mut self,
        device: &ash::Device,
        commands: vk::CommandBuffer,
        target: u64,
        start: u64,
        end: u64,
    ) {
        let meets = self
            .0
            .iter()
            .any(|&(t, s, e)| t == target && s < end && start < e);
        if meets || self.0.len() >= REMEMBERED {
            let transfers = Barrier {
                from: vk::AccessFlags::TRANSFER_WRITE,
                to: vk::AccessFlags::TRANSFER_WRITE,
            };
            // SAFETY: the caller's promise.
            unsafe { transfers.record(device, commands) };
            self.clear();
        }
        self.0.push((target, start, end));
    }
}

/// Bytes in a page that the open batch is to copy from there.
pub(crate) struct Staged {
    pub commands: vk::CommandBuffer,
    pub source: vk::Buffer,
    pub from: u64,
    pub size: u64,
}

impl Staging {
    /// A batch begins, with submissions up to `done` finished.
    pub fn begin(&mut self, done: u64) {
        self.written.clear();
        // A page that nobody reads any more is filled from its start, so that small uploads stay in one page.
        if let Some(page) = self
            .pages
            .get_mut(self.open)
            .filter(|page| page.last <= done)
        {
            page.used = 0;
        }
    }
}

impl Stream {
    /// Records a copy of `bytes` to `target` from `offset` on.
    pub fn write(
        &mut self,
        target: &Buffer,
        mut offset: u64,
        mut bytes: &[u8],
    ) -> Result<(), BackendError> {
        while !bytes.is_empty() {
            let piece = self.stage(bytes, |room| room)?;
            let device = &self.device.raw;
            let region = [vk::BufferCopy {
                src_offset: piece.from,
                dst_offset: offset,
                size: piece.size,
            }];
            let (commands, end) = (piece.commands, offset + piece.size);
            // SAFETY: the batch is being recorded; both ranges are inside their buffers, which live until the
            // submission is done (pages are kept, resources wait before they go).
            unsafe {
                let written = &mut self.staging.written;
                written.order(device, commands, target.raw.as_raw(), offset, end);
                device.cmd_copy_buffer(commands, piece.source, target.raw, &region);
            };
            offset = end;
            bytes = &bytes[piece.size as usize..];
        }
        Ok(())
    }

    /// Puts the start of `bytes` into a page: of what has room there, as much as `fit` says. Rooms are multiples of 16.
    pub fn stage(
        &mut self,
        bytes: &[u8],
        fit: impl FnOnce(usize) -> usize,
    ) -> Result<Staged, BackendError> {
        let index = self.page()?;
        // Opens the batch, which may rewind the page.
        let commands = self.batch()?;
        let number = self.number();
        let page = &mut self.staging.pages[index];
        let size = fit(bytes.len().min((PAGE - page.used) as usize));
        let (source, from) = (page.buffer.raw, page.used);
        let start = from as usize;
        page.buffer.mapped()[start..start + size].copy_from_slice(&bytes[..size]);
        page.used = (from + size as u64).next_multiple_of(16).min(PAGE);
        page.last = number;
        Ok(Staged {
            commands,
            source,
            from,
            size: size as u64,
        })
    }

    /// Records a copy of the first `bytes` bytes of `source`, which nothing changes any more, to `target`.
    pub fn copy(
        &mut self,
        source: &Buffer,
        target: &Buffer,
        bytes: u64,
    ) -> Result<(), BackendError> {
        let commands = self.batch()?;
        let device = &self.device.raw;
        let region = [vk::BufferCopy {
            src_offset: 0,
            dst_offset: 0,
            size: bytes,
        }];
        let written = &mut self.staging.written;
        // SAFETY: the batch is being recorded; both buffers are as long as the resource at least, and the caller waits for
        // the copy before either can go.
        unsafe {
            written.order(device, commands, target.raw.as_raw(), 0, bytes);
            device.cmd_copy_buffer(commands, source.raw, target.raw, &region);
        };
        Ok(())
    }

    /// Records that all of `target` becomes `word`.
    pub fn fill(&mut self, target: &Buffer, word: u32) -> Result<(), BackendError> {
        let commands = self.batch()?;
        let device = &self.device.raw;
        let written = &mut self.staging.written;
        // SAFETY: the batch is being recorded; the size is a multiple of 4 and that of the buffer.
        unsafe {
            written.order(device, commands, target.raw.as_raw(), 0, target.size);
            device.cmd_fill_buffer(commands, target.raw, 0, target.size, word);
        };
        Ok(())
    }

    /// Submits, waits, and returns the first `bytes` bytes of `source`.
    pub fn read(&mut self, source: &Buffer, bytes: u64) -> Result<Vec<u8>, BackendError> {
        self.read_with(bytes, |device, commands, window, offset, room| {
            let size = room.min(bytes - offset);
            let region = [vk::BufferCopy {
                src_offset: offset,
                dst_offset: 0,
                size,
            }];
            // SAFETY: the batch is being recorded; both ranges are inside their buffers, and the work is waited for
            // before either can go.
            unsafe { device.cmd_copy_buffer(commands, source.raw, window, &region) };
            size
        })
    }

    /// Submits, waits, and returns `bytes` bytes. `copy` records the copy of the next of them, those from its fourth
    /// argument on and at most as many as its last, to the start of a buffer, and says how many they are.
    pub fn read_with(
        &mut self,
        bytes: u64,
        copy: impl Fn(&ash::Device, vk::CommandBuffer, vk::Buffer, u64, u64) -> u64,
    ) -> Result<Vec<u8>, BackendError> {
        let mut window = match self.staging.window.take() {
            Some(window) => window,
            None => Buffer::readback(&self.device, WINDOW)?,
        };
        let mut content = Vec::with_capacity(bytes as usize);
        while (content.len() as u64) < bytes {
            let commands = self.batch()?;
            let device = &self.device.raw;
            let visible = [vk::MemoryBarrier::default()
                .src_access_mask(vk::AccessFlags::TRANSFER_WRITE)
                .dst_access_mask(vk::AccessFlags::HOST_READ)];
            // SAFETY: the batch is being recorded.
            let size = unsafe {
                // Behind the uploads of the same batch.
                Barrier::FULL.record(device, commands);
                let offset = content.len() as u64;
                let size = copy(device, commands, window.raw, offset, WINDOW);
                device.cmd_pipeline_barrier(
                    commands,
                    vk::PipelineStageFlags::TRANSFER,
                    vk::PipelineStageFlags::HOST,
                    vk::DependencyFlags::empty(),
                    &visible,
                    &[],
                    &[],
                );
                size
            };
            self.finish()?;
            content.extend_from_slice(&window.mapped()[..size as usize]);
        }
        self.staging.window = Some(window);
        Ok(content)
    }

    /// A page with room.
    fn page(&mut self) -> Result<usize, BackendError> {
        let open = self.staging.open;
        if self
            .staging
            .pages
            .get(open)
            .is_some_and(|page| page.used < PAGE)
        {
            return Ok(open);
        }
        let mut done = self.done()?;
        let free = |pages: &[Page], done| pages.iter().position(|page| page.last <= done);
        let mut found = free(&self.staging.pages, done);
        if found.is_none() && self.staging.pages.len() < PAGES {
            let buffer = Buffer::staging(&self.device, PAGE)?;
            self.staging.pages.push(Page {
                buffer,
                used: 0,
                last: 0,
            });
            found = Some(self.staging.pages.len() - 1);
        }
        while found.is_none() {
            self.submit(None)?;
            if let Some(oldest) = self.staging.pages.iter().map(|page| page.last).min() {
                self.wait(oldest)?;
            }
            done = self.done()?;
            found = free(&self.staging.pages, done);
        }
        let index = found.unwrap_or_default();
        self.staging.pages[index].used = 0;
        self.staging.open = index;
        Ok(index)
    }
}
