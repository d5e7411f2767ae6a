//! Small uploads, held back until something is recorded that they go in front of.
//!
//! What a host records into a command buffer of its own has to bring its uploads along, since nothing is submitted for
//! it. So small uploads wait here, as bytes, and become part of whatever is recorded next: a batch or a host's frame.
use crate::image::{COLOR, Image, turn};
use crate::memory::Buffer;
use crate::transfer::Written;
use ash::vk;
use ash::vk::Handle;
use std::ops::Range;

/// Bytes of one upload that can be held back: what `vkCmdUpdateBuffer` takes.
const SMALL: usize = 64 << 10;
/// Bytes that are held back in all.
const MOST: usize = 1 << 20;

/// Writes that are not recorded yet, in order. Its vectors are kept, so that holding back allocates nothing after a
/// while.
#[derive(Default)]
pub(crate) struct Pending {
    bytes: Vec<u8>,
    writes: Vec<Write>,
}

enum Write {
    Bytes {
        target: vk::Buffer,
        offset: u64,
        source: Range<usize>,
    },
    /// A new image leaves its undefined layout, and becomes zero.
    Zero(vk::Image),
}

impl Pending {
    /// Nothing waits.
    pub fn is_empty(&self) -> bool {
        self.writes.is_empty()
    }

    /// An upload of `len` bytes can be held back, if not beside the others.
    pub fn takes(offset: u64, len: usize) -> bool {
        len <= SMALL && len.is_multiple_of(4) && offset.is_multiple_of(4)
    }

    /// There is room for `len` bytes more.
    pub fn has_room(&self, len: usize) -> bool {
        self.bytes.len() + len <= MOST
    }

    /// Holds back an upload that [`Pending::takes`] allows.
    pub fn hold(&mut self, target: &Buffer, offset: u64, bytes: &[u8]) {
        let start = self.bytes.len();
        self.bytes.extend_from_slice(bytes);
        self.writes.push(Write::Bytes {
            target: target.raw,
            offset,
            source: start..self.bytes.len(),
        });
    }

    /// Has a new image set to zero.
    pub fn zero(&mut self, image: &Image) {
        self.writes.push(Write::Zero(image.raw));
    }

    /// Records everything that waits, in order with what `written` lists.
    ///
    /// # Safety
    /// `commands` is a command buffer of `device` that is being recorded; the targets live until its work is done.
    pub unsafe fn record(
        &mut self,
        device: &ash::Device,
        commands: vk::CommandBuffer,
        written: &mut Written,
    ) {
        for write in self.writes.drain(..) {
            // SAFETY: the caller's promise; ranges were checked when they were held back.
            unsafe {
                match write {
                    Write::Bytes {
                        target,
                        offset,
                        source,
                    } => {
                        let bytes = &self.bytes[source];
                        let end = offset + bytes.len() as u64;
                        written.order(device, commands, target.as_raw(), offset, end);
                        device.cmd_update_buffer(commands, target, offset, bytes);
                    }
                    Write::Zero(image) => zero(device, commands, image),
                }
            }
        }
        self.bytes.clear();
    }
}

/// # Safety
/// `commands` is being recorded; `image` is new and lives until its work is done.
unsafe fn zero(device: &ash::Device, commands: vk::CommandBuffer, image: vk::Image) {
    let (new, general) = (vk::ImageLayout::UNDEFINED, vk::ImageLayout::GENERAL);
    // SAFETY: the caller's promise. All bits zero is zero in every format.
    unsafe {
        turn(device, commands, image, new, general);
        let zero = vk::ClearColorValue::default();
        device.cmd_clear_color_image(commands, image, general, &zero, &[COLOR]);
    }
}
