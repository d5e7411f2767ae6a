//! Time per step, from timestamps that the device writes around each stage.
//!
//! Clears happen outside of compute passes, where plain timestamp queries cannot be written, so they have no time.
use crate::buffers::{create_readback, map};
use crate::context::Context;
use gibs_graph::{BackendError, StepTime};
use std::time::Duration;
use wgpu::BufferUsages;

/// Bytes of one timestamp.
const STAMP: u64 = wgpu::QUERY_SIZE as u64;

/// Two timestamps per dispatch step, and their way back to the host.
pub(crate) struct Timer {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readback: wgpu::Buffer,
    /// The step behind each pair of queries.
    steps: Vec<usize>,
    /// Nanoseconds per tick.
    period: f32,
    /// A frame was measured.
    used: bool,
}

impl Timer {
    /// A timer for these steps; of more than a query set can hold, for the first ones. `None` where the device has no
    /// timestamps, or there is nothing to time.
    pub fn new(context: &Context, mut steps: Vec<usize>) -> Result<Option<Self>, BackendError> {
        steps.truncate(wgpu::QUERY_SET_MAX_QUERIES as usize / 2);
        if steps.is_empty() || !context.info.timestamps {
            return Ok(None);
        }
        let count = steps.len() as u32 * 2;
        let size = u64::from(count) * STAMP;
        context.guard(|| {
            Some(Self {
                queries: context.device.create_query_set(&wgpu::QuerySetDescriptor {
                    label: Some("time per step"),
                    ty: wgpu::QueryType::Timestamp,
                    count,
                }),
                resolved: context.device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("time per step"),
                    size,
                    usage: BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC,
                    mapped_at_creation: false,
                }),
                readback: create_readback(&context.device, size),
                period: context.queue.get_timestamp_period(),
                steps,
                used: false,
            })
        })
    }

    /// Where the pass of a step writes its timestamps, if it is among those that are timed.
    pub fn writes(&self, step: usize) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let pair = self.steps.binary_search(&step).ok()? as u32;
        Some(wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(2 * pair),
            end_of_pass_write_index: Some(2 * pair + 1),
        })
    }

    /// Records the way back, after every timed step was recorded.
    pub fn resolve(&mut self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(
            &self.queries,
            0..self.steps.len() as u32 * 2,
            &self.resolved,
            0,
        );
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.readback, 0, self.resolved.size());
        self.used = true;
    }

    /// Waits for everything submitted so far and returns the times of the last measured frame.
    pub fn read(&self, context: &Context) -> Result<Option<Vec<StepTime>>, BackendError> {
        if !self.used {
            return Ok(None);
        }
        let bytes = map(context, &self.readback, self.readback.size(), None)?;
        Ok(Some(times(&self.steps, &bytes, self.period)))
    }
}

/// Pairs of timestamps as durations; `period` in nanoseconds per tick.
fn times(steps: &[usize], bytes: &[u8], period: f32) -> Vec<StepTime> {
    let stamp = |bytes: &[u8]| {
        bytes
            .iter()
            .rev()
            .fold(0_u64, |value, &byte| (value << 8) | u64::from(byte))
    };
    let pairs = bytes
        .chunks_exact(2 * STAMP as usize)
        .map(|pair| pair.split_at(STAMP as usize));
    steps
        .iter()
        .zip(pairs)
        .map(|(&step, (begin, end))| {
            // A clock that went back, as some do across power states, gives zero rather than centuries.
            let ticks = stamp(end).saturating_sub(stamp(begin));
            StepTime {
                step,
                time: Duration::from_nanos((ticks as f64 * f64::from(period)) as u64),
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_become_nanoseconds() {
        let stamps = [1_000_u64, 1_500, 7, 3];
        let bytes: Vec<u8> = stamps.iter().flat_map(|s| s.to_le_bytes()).collect();
        let got = times(&[4, 6], &bytes, 2.0);
        let want = [(4, 1_000), (6, 0)].map(|(step, ns)| StepTime {
            step,
            time: Duration::from_nanos(ns),
        });
        assert_eq!(got, want);
    }
}
