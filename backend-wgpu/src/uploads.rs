//! Small uploads, held back until something is recorded that they go in front of.
//!
//! What goes to the queue takes effect before everything in the next submission. A host that records several frames
//! into one submission uploads between them, so small uploads wait here, as bytes, and are recorded as copies.
use crate::buffers::write;
use crate::context::Context;
use crate::patch::{PATCH, Patch, WORD};
use gibs_graph::BackendError;
use std::ops::Range;
use wgpu::BufferSize;
use wgpu::util::StagingBelt;

/// Most bytes of one upload to a buffer that is recorded with the next frame. A larger one takes effect before
/// everything in the next submission; see [`WgpuExecutable::record`](crate::WgpuExecutable::record).
pub const RECORDED_UPLOAD: usize = 16 << 10;

/// Most bytes that wait for the next frame in all. An upload beyond has everything before it submitted at once, ahead
/// of frames that were recorded and are not submitted yet; see [`WgpuExecutable::record`](crate::WgpuExecutable::record).
/// Of an upload that starts or ends inside a word of 4 bytes, 16 more are counted.
pub const RECORDED_UPLOADS: usize = 1 << 20;

/// Least bytes of a staging buffer: more than most frames upload.
const CHUNK: u64 = 64 << 10;

/// Writes that are not recorded yet, in order. Its vectors and staging buffers are kept, so that a frame makes none
/// after a while.
#[derive(Default)]
pub(crate) struct Uploads {
    bytes: Vec<u8>,
    writes: Vec<Write>,
    belt: Option<StagingBelt>,
    patch: Option<Patch>,
}

struct Write {
    target: wgpu::Buffer,
    /// In the target; whole words.
    offset: u64,
    /// In the bytes that wait: the content, or what [`Patch`] takes.
    source: Range<usize>,
    /// Only a part of one word is replaced.
    is_part: bool,
}

impl Uploads {
    /// Nothing waits.
    pub fn is_empty(&self) -> bool {
        self.writes.is_empty()
    }

    /// What waits has to be submitted before an upload of `len` bytes to `target`: because there is no room beside it,
    /// or because the upload would overtake it.
    pub fn must_go_before(&self, target: &wgpu::Buffer, len: usize) -> bool {
        let is_small = len <= RECORDED_UPLOAD;
        let held = if is_small { len } else { 0 };
        self.bytes.len() + held + 2 * PATCH > RECORDED_UPLOADS
            || !is_small && self.writes.iter().any(|write| write.target == *target)
    }

    /// Replaces bytes of `target` from `offset` on. Nothing [must go before](Self::must_go_before) it.
    pub fn put(
        &mut self,
        context: &Context,
        target: &wgpu::Buffer,
        key: &str,
        offset: u64,
        bytes: &[u8],
    ) -> Result<(), BackendError> {
        let inside = (offset % WORD as u64) as usize;
        let before = (WORD - inside) % WORD;
        let (head, rest) = bytes.split_at(before.min(bytes.len()));
        let (words, tail) = rest.split_at(rest.len() / WORD * WORD);
        let has_parts = !head.is_empty() || !tail.is_empty();
        if has_parts && self.patch.is_none() {
            self.patch = Some(Patch::new(context)?);
        }
        let start = offset + head.len() as u64;
        if bytes.len() > RECORDED_UPLOAD {
            write(context, target, key, start, words)?;
        } else if !words.is_empty() {
            self.hold(target, start, false, words);
        }
        self.hold_part(target, offset, head);
        self.hold_part(target, start + words.len() as u64, tail);
        Ok(())
    }

    fn hold(&mut self, target: &wgpu::Buffer, offset: u64, is_part: bool, bytes: &[u8]) {
        let start = self.bytes.len();
        self.bytes.extend_from_slice(bytes);
        self.writes.push(Write {
            target: target.clone(),
            offset,
            source: start..self.bytes.len(),
            is_part,
        });
    }

    /// Holds back bytes inside one word.
    fn hold_part(&mut self, target: &wgpu::Buffer, offset: u64, bytes: &[u8]) {
        if bytes.is_empty() {
            return;
        }
        let inside = (offset % WORD as u64) as usize;
        self.hold(
            target,
            offset - inside as u64,
            true,
            &Patch::bytes(inside, bytes),
        );
    }

    /// Records everything that waits. Within [`Context::guard`], which knows more about what went wrong.
    pub fn record(
        &mut self,
        context: &Context,
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<(), BackendError> {
        // Few sizes, so that the staging buffers of one frame fit the next one.
        let room = (self.bytes.len() as u64).next_power_of_two().max(CHUNK);
        let (false, Some(room)) = (self.is_empty(), BufferSize::new(room)) else {
            return Ok(());
        };
        let belt = self
            .belt
            .get_or_insert_with(|| StagingBelt::new(context.device.clone(), CHUNK));
        let staged = belt.allocate(room, BufferSize::MIN);
        match staged.get_mapped_range_mut() {
            Ok(mut view) => view.slice(..self.bytes.len()).copy_from_slice(&self.bytes),
            Err(error) => {
                // The belt would hand out this buffer again and again.
                self.belt = None;
                return Err(context.failed(&error.to_string()));
            }
        }
        for write in self.writes.drain(..) {
            let (buffer, at) = (staged.buffer(), staged.offset() + write.source.start as u64);
            match &self.patch {
                Some(patch) if write.is_part => {
                    patch.record(encoder, (buffer, at), (&write.target, write.offset));
                }
                _ => {
                    let (target, len) = (&write.target, write.source.len() as u64);
                    encoder.copy_buffer_to_buffer(buffer, at, target, write.offset, len);
                }
            }
        }
        self.bytes.clear();
        // If the encoder is dropped, so is the staging buffer.
        belt.finish_and_recall_on_submit(encoder);
        Ok(())
    }
}
