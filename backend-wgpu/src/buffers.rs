//! Memory of resources on the device.
use crate::context::{Context, said};
use gibs_graph::{BackendError, Initial, Kind, Resource};
use std::sync::mpsc;
use wgpu::BufferUsages;

/// What every buffer may be used for: one set for all, so that an allocation can move from one schedule to another
/// that binds it in another way.
const USAGES: BufferUsages = BufferUsages::STORAGE
    .union(BufferUsages::UNIFORM)
    .union(BufferUsages::INDIRECT)
    .union(BufferUsages::COPY_SRC)
    .union(BufferUsages::COPY_DST);

/// Which allocation of a history this frame writes: 0 or 1. The other one is the frame before's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Parity(bool);

impl Parity {
    pub const BOTH: [Parity; 2] = [Parity(false), Parity(true)];

    pub fn other(self) -> Self {
        Parity(!self.0)
    }

    pub fn index(self) -> usize {
        usize::from(self.0)
    }
}

/// The buffers of one resource: two for a history, one otherwise, none where no stage sees it on the device.
#[derive(Clone, Default)]
pub(crate) struct Allocation(Vec<wgpu::Buffer>);

impl Allocation {
    /// Allocates, and writes the initial value.
    pub fn new(context: &Context, resource: &Resource) -> Result<Self, BackendError> {
        let count = match resource.kind {
            // An image has no buffer, and what is at home elsewhere uses that one.
            // Nor has an acceleration structure.
            _ if resource.usage.acceleration => 0,
            _ if !resource.usage.on_device() || resource.image.is_some() || resource.room == 0 => 0,
            Kind::History(_) => 2,
            _ => 1,
        };
        let made = Self(
            (0..count)
                .map(|_| create(context, resource))
                .collect::<Result<_, _>>()?,
        );
        // wgpu makes new buffers zero.
        if let Some(initial) = initial(resource).filter(|initial| **initial != Initial::Zero) {
            made.fill(context, resource, initial)?;
        }
        Ok(made)
    }

    /// What the frame of this parity writes, or has written.
    pub fn current(&self, parity: Parity) -> Option<&wgpu::Buffer> {
        self.0
            .get(if self.is_history() { parity.index() } else { 0 })
    }

    /// The value of the frame before.
    pub fn previous(&self, parity: Parity) -> Option<&wgpu::Buffer> {
        self.current(parity.other())
    }

    /// The buffers depend on the parity.
    pub fn is_history(&self) -> bool {
        self.0.len() == 2
    }

    /// Some stage sees it on the device.
    pub fn is_on_device(&self) -> bool {
        !self.0.is_empty()
    }

    /// Turns an allocation that was current at `parity` into one that is current at the default parity.
    pub fn rebase(mut self, parity: Parity) -> Self {
        if self.is_history() && parity != Parity::default() {
            self.0.swap(0, 1);
        }
        self
    }

    /// Copies the first `bytes` bytes of a shorter allocation, behind everything that was submitted.
    pub fn begin_with(
        &self,
        context: &Context,
        old: &Self,
        bytes: u64,
    ) -> Result<(), BackendError> {
        context.guard(|| {
            let mut encoder = context
                .device
                .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            for (new, old) in self.0.iter().zip(&old.0) {
                encoder.copy_buffer_to_buffer(old, 0, new, 0, bytes.next_multiple_of(4));
            }
            context.queue.submit([encoder.finish()]);
        })
    }

    /// Sets a state or a history to its initial value.
    pub fn reset(&self, context: &Context, resource: &Resource) -> Result<(), BackendError> {
        match initial(resource) {
            Some(initial) => self.fill(context, resource, initial),
            None => Ok(()),
        }
    }

    fn fill(
        &self,
        context: &Context,
        resource: &Resource,
        initial: &Initial,
    ) -> Result<(), BackendError> {
        if *initial == Initial::Zero {
            return context.guard(|| {
                let mut encoder = context
                    .device
                    .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                self.0
                    .iter()
                    .for_each(|buffer| encoder.clear_buffer(buffer, 0, None));
                context.queue.submit([encoder.finish()]);
            });
        }
        let bytes = initial.bytes(to_usize(context, resource.bytes)?);
        for buffer in &self.0 {
            write(context, buffer, &resource.key, 0, &bytes)?;
        }
        Ok(())
    }
}

/// Content after a reset, where the resource has one.
fn initial(resource: &Resource) -> Option<&Initial> {
    match &resource.kind {
        Kind::State(initial) | Kind::History(initial) => Some(initial),
        _ => None,
    }
}

fn create(context: &Context, resource: &Resource) -> Result<wgpu::Buffer, BackendError> {
    // Copies and clears go by words; 16 bytes are the least that any binding may ask for.
    let size = resource.room.next_multiple_of(4).max(16);
    let descriptor = wgpu::BufferDescriptor {
        label: Some(&resource.key),
        size,
        usage: match resource.usage.triangles {
            true => USAGES | BufferUsages::BLAS_INPUT,
            false => USAGES,
        },
        mapped_at_creation: false,
    };
    context.guard_as(
        || context.device.create_buffer(&descriptor),
        |error| out_of_memory(context, &resource.key, size, &error),
    )
}

/// Replaces bytes from `offset` on, before whatever is submitted next. `offset` and the length are multiples of 4.
pub(crate) fn write(
    context: &Context,
    buffer: &wgpu::Buffer,
    key: &str,
    offset: u64,
    bytes: &[u8],
) -> Result<(), BackendError> {
    context.guard_as(
        || context.queue.write_buffer(buffer, offset, bytes),
        |error| out_of_memory(context, key, bytes.len() as u64, &error),
    )
}

/// Brings bytes back to the host; keeps its buffer between calls.
#[derive(Default)]
pub(crate) struct Readback(Option<wgpu::Buffer>);

impl Readback {
    /// Waits for everything submitted so far and returns the first `size` bytes of `buffer`.
    pub fn read(
        &mut self,
        context: &Context,
        buffer: &wgpu::Buffer,
        key: &str,
        size: u64,
    ) -> Result<Vec<u8>, BackendError> {
        let words = size.next_multiple_of(4);
        let staging = match self.0.take().filter(|kept| kept.size() >= words) {
            Some(kept) => kept,
            None => context.guard_as(
                || create_readback(&context.device, words),
                |error| out_of_memory(context, key, words, &error),
            )?,
        };
        let submission = context.guard(|| {
            let mut encoder = context
                .device
                .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, words);
            context.queue.submit([encoder.finish()])
        })?;
        let bytes = map(context, &staging, size, Some(submission))?;
        self.0 = Some(staging);
        Ok(bytes)
    }
}

/// A buffer that the host can map.
pub(crate) fn create_readback(device: &wgpu::Device, size: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("readback"),
        size,
        usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
        mapped_at_creation: false,
    })
}

/// Maps a buffer of [`create_readback`] once `submission` has finished, and copies its first `size` bytes.
pub(crate) fn map(
    context: &Context,
    buffer: &wgpu::Buffer,
    size: u64,
    submission: Option<wgpu::SubmissionIndex>,
) -> Result<Vec<u8>, BackendError> {
    let (sender, receiver) = mpsc::channel();
    context.guard(|| {
        buffer.map_async(
            wgpu::MapMode::Read,
            ..size.next_multiple_of(4),
            move |mapped| {
                // The receiver lives until the map is done or has failed; then nobody wants to know.
                let _ = sender.send(mapped);
            },
        );
    })?;
    context.wait(submission)?;
    match receiver.try_recv() {
        Ok(Ok(())) => {}
        Ok(Err(error)) => return Err(context.failed(&error.to_string())),
        Err(_) => return Err(context.failed("a buffer was not mapped although its work is done")),
    }
    let bytes = match buffer.get_mapped_range(..size) {
        Ok(view) => Ok(view.to_vec()),
        Err(error) => Err(context.failed(&error.to_string())),
    };
    buffer.unmap();
    bytes
}

/// What an error while memory is made means.
pub(crate) fn out_of_memory(
    context: &Context,
    key: &str,
    bytes: u64,
    error: &wgpu::Error,
) -> BackendError {
    match error {
        wgpu::Error::OutOfMemory { .. } => BackendError::OutOfMemory {
            device: context.info.name.clone(),
            resource: key.into(),
            bytes,
        },
        other => context.failed(&said(other)),
    }
}

fn to_usize(context: &Context, bytes: u64) -> Result<usize, BackendError> {
    usize::try_from(bytes).map_err(|_| {
        context.failed(&format!(
            "{bytes} bytes are more than this machine can address"
        ))
    })
}
