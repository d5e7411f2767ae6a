//! Bytes between host and device: staging pages, recorded copies, read-backs.
use crate::barriers::Barrier;
use crate::memory::Buffer;
use crate::stream::Stream;
use ash::vk;
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
    /// What the open batch wrote since its last barrier: buffer, first byte, end.
    written: Vec<(vk::Buffer, u64, u64)>,
    window: Option<Buffer>,
}

struct Page {
    buffer: Buffer,
    used: u64,
    /// Submission that last reads it.
    last: u64,
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
            let index = self.page()?;
            // Opens the batch, which may rewind the page.
            let commands = self.batch()?;
            let number = self.number();
            let page = &mut self.staging.pages[index];
            let (piece, rest) = bytes.split_at(bytes.len().min((PAGE - page.used) as usize));
            let (from, size) = (page.used, piece.len() as u64);
            let start = from as usize;
            page.buffer.mapped()[start..start + piece.len()].copy_from_slice(piece);
            page.used = (from + size).next_multiple_of(16).min(PAGE);
            page.last = number;
            let source = page.buffer.raw;
            self.order(commands, target.raw, offset, offset + size);
            let region = [vk::BufferCopy {
                src_offset: from,
                dst_offset: offset,
                size,
            }];
            // SAFETY: the batch is being recorded; both ranges are inside their buffers, which live until the
            // submission is done (pages are kept, resources wait before they go).
            unsafe {
                self.device
                    .raw
                    .cmd_copy_buffer(commands, source, target.raw, &region)
            };
            offset += size;
            bytes = rest;
        }
        Ok(())
    }

    /// Records that all of `target` becomes `word`.
    pub fn fill(&mut self, target: &Buffer, word: u32) -> Result<(), BackendError> {
        let commands = self.batch()?;
        self.order(commands, target.raw, 0, target.size);
        // SAFETY: the batch is being recorded; the size is a multiple of 4 and that of the buffer.
        unsafe {
            self.device
                .raw
                .cmd_fill_buffer(commands, target.raw, 0, target.size, word)
        };
        Ok(())
    }

    /// Submits, waits, and returns the first `bytes` bytes of `source`.
    pub fn read(&mut self, source: &Buffer, bytes: u64) -> Result<Vec<u8>, BackendError> {
        let mut window = match self.staging.window.take() {
            Some(window) => window,
            None => Buffer::readback(&self.device, WINDOW)?,
        };
        let mut content = Vec::with_capacity(bytes as usize);
        while (content.len() as u64) < bytes {
            let offset = content.len() as u64;
            let size = WINDOW.min(bytes - offset);
            let commands = self.batch()?;
            let region = [vk::BufferCopy {
                src_offset: offset,
                dst_offset: 0,
                size,
            }];
            let visible = [vk::MemoryBarrier::default()
                .src_access_mask(vk::AccessFlags::TRANSFER_WRITE)
                .dst_access_mask(vk::AccessFlags::HOST_READ)];
            // SAFETY: the batch is being recorded; both ranges are inside their buffers, and the work is waited for
            // before either can go.
            unsafe {
                // Behind the uploads of the same batch.
                Barrier::FULL.record(&self.device.raw, commands);
                self.device
                    .raw
                    .cmd_copy_buffer(commands, source.raw, window.raw, &region);
                self.device.raw.cmd_pipeline_barrier(
                    commands,
                    vk::PipelineStageFlags::TRANSFER,
                    vk::PipelineStageFlags::HOST,
                    vk::DependencyFlags::empty(),
                    &visible,
                    &[],
                    &[],
                );
            }
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

    /// Puts a barrier before a write that meets an earlier one of the same batch.
    fn order(&mut self, commands: vk::CommandBuffer, buffer: vk::Buffer, start: u64, end: u64) {
        let written = &mut self.staging.written;
        let meets = written
            .iter()
            .any(|&(b, s, e)| b == buffer && s < end && start < e);
        if meets || written.len() >= REMEMBERED {
            let transfers = Barrier {
                from: vk::AccessFlags::TRANSFER_WRITE,
                to: vk::AccessFlags::TRANSFER_WRITE,
            };
            // SAFETY: the batch is being recorded.
            unsafe { transfers.record(&self.device.raw, commands) };
            written.clear();
        }
        written.push((buffer, start, end));
    }
}
