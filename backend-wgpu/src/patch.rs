//! Replaces a part of a word on the device.
//!
//! Copies go by whole words. The bytes around those that change may come from a frame that is not submitted yet, so the
//! host cannot know them.
use crate::context::Context;
use gibs_graph::BackendError;
use std::borrow::Cow;
use wgpu::BufferUsages;

/// Bytes that a patch takes: which bits stay, and the new ones.
pub(crate) const PATCH: usize = 8;

/// Bytes of a word, the unit of copies between buffers.
pub(crate) const WORD: usize = wgpu::COPY_BUFFER_ALIGNMENT as usize;

const KERNEL: &str = "
    @group(0) @binding(0) var<storage, read_write> words: array<u32, 3>;
    @compute @workgroup_size(1) fn main() { words[0] = (words[0] & words[1]) | words[2]; }";

/// A place to which words are brought, changed, and brought back, one after another.
pub(crate) struct Patch {
    /// The word, and the bytes of the patch.
    words: wgpu::Buffer,
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
}

impl Patch {
    pub fn new(context: &Context) -> Result<Self, BackendError> {
        let label = Some("part of a word");
        let device = &context.device;
        context.guard(|| {
            let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label,
                source: wgpu::ShaderSource::Wgsl(Cow::Borrowed(KERNEL)),
            });
            let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label,
                layout: None,
                module: &module,
                entry_point: Some("main"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            });
            let words = device.create_buffer(&wgpu::BufferDescriptor {
                label,
                size: (WORD + PATCH) as u64,
                usage: BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label,
                layout: &pipeline.get_bind_group_layout(0),
                entries: &[wgpu::BindGroupEntry {
                    binding: 0,
                    resource: words.as_entire_binding(),
                }],
            });
            Self {
                words,
                pipeline,
                group,
            }
        })
    }

    /// The patch that puts `part` at byte `inside` of a word, where it fits.
    pub fn bytes(inside: usize, part: &[u8]) -> [u8; PATCH] {
        let mut patch = [0; PATCH];
        let (keep, new) = patch.split_at_mut(WORD);
        keep.fill(0xff);
        for ((keep, new), byte) in keep.iter_mut().zip(new).skip(inside).zip(part) {
            (*keep, *new) = (0, *byte);
        }
        patch
    }

    /// Records a patch, whose bytes are at `source`, of the word at `target`.
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        source: (&wgpu::Buffer, u64),
        target: (&wgpu::Buffer, u64),
    ) {
        let (word, patch) = (WORD as u64, PATCH as u64);
        encoder.copy_buffer_to_buffer(target.0, target.1, &self.words, 0, word);
        encoder.copy_buffer_to_buffer(source.0, source.1, &self.words, word, patch);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.dispatch_workgroups(1, 1, 1);
        drop(pass);
        encoder.copy_buffer_to_buffer(&self.words, 0, target.0, target.1, word);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_patch_keeps_the_bytes_around() {
        assert_eq!(
            Patch::bytes(1, &[0xaa, 0xbb]),
            [0xff, 0, 0, 0xff, 0, 0xaa, 0xbb, 0]
        );
        assert_eq!(Patch::bytes(3, &[7]), [0xff, 0xff, 0xff, 0, 0, 0, 0, 7]);
    }
}
