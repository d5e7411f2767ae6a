//! Texels between host and device.
use crate::image::{Image, turn};
use crate::stream::Stream;
use ash::vk;
use gibs_graph::BackendError;

/// Texels in the order of memory, row by row, as a rectangle: column, row, width, height.
type Rectangle = [u32; 4];

/// The largest rectangle that starts at texel `first` of an image and has its texels in a row in memory: whole rows, or
/// a part of one. It has at most `most` texels, and at least one.
fn rectangle([width, height]: [u32; 2], first: u64, most: u64) -> Rectangle {
    let wide = u64::from(width.max(1));
    let (x, y) = ((first % wide) as u32, (first / wide) as u32);
    match most / wide {
        rows @ 1.. if x == 0 => [0, y, width, rows.min(u64::from(height - y)) as u32],
        _ => [x, y, most.clamp(1, u64::from(width - x)) as u32, 1],
    }
}

fn texels([_, _, width, height]: Rectangle) -> u64 {
    u64::from(width) * u64::from(height)
}

/// A copy between a rectangle and the bytes from `offset` on of a buffer.
fn region(offset: u64, [x, y, width, height]: Rectangle) -> [vk::BufferImageCopy; 1] {
    [vk::BufferImageCopy {
        buffer_offset: offset,
        image_subresource: vk::ImageSubresourceLayers {
            aspect_mask: vk::ImageAspectFlags::COLOR,
            layer_count: 1,
            ..Default::default()
        },
        // Limits keep sides far below 2^31.
        image_offset: vk::Offset3D {
            x: x as i32,
            y: y as i32,
            z: 0,
        },
        image_extent: vk::Extent3D {
            width,
            height,
            depth: 1,
        },
        ..Default::default()
    }]
}

impl Stream {
    /// Records a copy of all texels, encoded, to `target`.
    pub fn write_image(&mut self, target: &Image, mut bytes: &[u8]) -> Result<(), BackendError> {
        let mut first = 0;
        let size = target.shape.size;
        let texel = u64::from(target.shape.format.texel_bytes());
        while !bytes.is_empty() {
            let mut part = [0; 4];
            let piece = self.stage(bytes, |room| {
                part = rectangle(size, first, room as u64 / texel);
                (texels(part) * texel) as usize
            })?;
            let device = &self.device.raw;
            let (image, general) = (target.raw, vk::ImageLayout::GENERAL);
            let (commands, source) = (piece.commands, piece.source);
            let region = region(piece.from, part);
            let during = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
            // SAFETY: the batch is being recorded; the texels are inside the page and the image, which live until the
            // submission is done. The image is in the layout `GENERAL` between transfers, which these barriers order.
            unsafe {
                turn(device, commands, image, general, during);
                device.cmd_copy_buffer_to_image(commands, source, image, during, &region);
                turn(device, commands, image, during, general);
            }
            first += texels(part);
            bytes = &bytes[piece.size as usize..];
        }
        Ok(())
    }

    /// Submits, waits, and returns all texels of `source`, encoded.
    pub fn read_image(&mut self, source: &Image) -> Result<Vec<u8>, BackendError> {
        let size = source.shape.size;
        let texel = u64::from(source.shape.format.texel_bytes());
        let bytes = u64::from(size[0]) * u64::from(size[1]) * texel;
        self.read_with(bytes, |device, commands, window, offset, room| {
            let part = rectangle(size, offset / texel, room / texel);
            let (image, general) = (source.raw, vk::ImageLayout::GENERAL);
            let region = region(0, part);
            let during = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
            // SAFETY: as in `write_image`, and the work is waited for before either can go.
            unsafe {
                turn(device, commands, image, general, during);
                device.cmd_copy_image_to_buffer(commands, image, during, window, &region);
                turn(device, commands, image, during, general);
            }
            texels(part) * texel
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// However many texels are taken at once, together they are the image, in order.
    #[test]
    fn rectangles_cover_an_image_once() {
        for size in [[1, 1], [7, 3], [3, 7], [1, 9], [9, 1]] {
            let all = u64::from(size[0]) * u64::from(size[1]);
            for most in 1..=all + 2 {
                let mut first = 0;
                while first < all {
                    let part = rectangle(size, first, most);
                    let [x, y, width, height] = part;
                    assert_eq!(u64::from(y) * u64::from(size[0]) + u64::from(x), first);
                    assert!(x + width <= size[0] && y + height <= size[1]);
                    assert!(height == 1 || width == size[0], "in a row in memory");
                    assert!((1..=most).contains(&texels(part)));
                    first += texels(part);
                }
                assert_eq!(first, all);
            }
        }
    }
}
