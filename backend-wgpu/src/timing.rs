//! Time per step, from timestamps that the device writes.
//!
//! Where the device writes them anywhere, one stands before the first step and one after each, as in the Vulkan backend: a
//! step is charged with what it adds to the frame, and measuring leaves the commands as they are. Elsewhere they stand at
//! both ends of compute passes, so that every dispatch has a pass of its own while measuring, and clears have no time.
use crate::buffers::{create_readback, map};
use crate::context::Context;
use gibs_graph::{BackendError, Schedule, StepTime};
use std::time::Duration;
use wgpu::{BufferUsages, Features};

/// Bytes of one timestamp.
const STAMP: u64 = wgpu::QUERY_SIZE as u64;

/// Timestamps of the steps of a frame, and their way back to the host.
pub(crate) struct Timer {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readback: wgpu::Buffer,
    places: Places,
    /// Nanoseconds per tick.
    period: f32,
    /// A frame was measured.
    used: bool,
}

/// Where timestamps stand.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Places {
    /// Before the first of this many steps, and after each.
    Between(usize),
    /// At both ends of the passes of these steps.
    Passes(Vec<usize>),
}

impl Places {
    /// Of the steps that a query set has room for.
    fn new(anywhere: bool, schedule: &Schedule) -> Self {
        let most = wgpu::QUERY_SET_MAX_QUERIES as usize;
        match anywhere {
            true => Self::Between(schedule.steps.len().min(most - 1)),
            false => {
                let steps = schedule.dispatches().map(|(i, ..)| i);
                Self::Passes(steps.take(most / 2).collect())
            }
        }
    }

    /// Number of timestamps; none where there is nothing to time.
    fn count(&self) -> u32 {
        match self {
            Self::Between(0) => 0,
            Self::Between(steps) => *steps as u32 + 1,
            Self::Passes(steps) => steps.len() as u32 * 2,
        }
    }

    /// Timestamps as times; `period` in nanoseconds per tick.
    fn times(&self, stamps: &[u64], period: f32) -> Vec<StepTime> {
        // A clock that went back, as some do across power states, gives zero rather than centuries.
        let between = |from: u64, to: u64| {
            let ticks = to.saturating_sub(from);
            Duration::from_nanos((ticks as f64 * f64::from(period)) as u64)
        };
        let first = stamps.first().copied().unwrap_or_default();
        let time = |step, from, to| StepTime {
            step,
            start: between(first, from),
            time: between(from, to),
        };
        match self {
            Self::Between(_) => {
                let pairs = stamps.windows(2).enumerate();
                pairs.map(|(step, w)| time(step, w[0], w[1])).collect()
            }
            Self::Passes(steps) => {
                let pairs = steps.iter().zip(stamps.chunks_exact(2));
                pairs.map(|(&step, c)| time(step, c[0], c[1])).collect()
            }
        }
    }
}

impl Timer {
    /// A timer for the steps of a schedule; of more than a query set can hold, for the first ones. `None` where the
    /// device has no timestamps, or there is nothing to time.
    pub fn new(context: &Context, schedule: &Schedule) -> Result<Option<Self>, BackendError> {
        let anywhere =
            Features::TIMESTAMP_QUERY_INSIDE_ENCODERS | Features::TIMESTAMP_QUERY_INSIDE_PASSES;
        let places = Places::new(context.device.features().contains(anywhere), schedule);
        let count = places.count();
        if count == 0 || !context.info.timestamps {
            return Ok(None);
        }
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
                places,
                used: false,
            })
        })
    }

    /// Whether every dispatch needs a pass of its own.
    pub fn splits_passes(&self) -> bool {
        matches!(self.places, Places::Passes(_))
    }

    /// Where the timestamp before all steps goes.
    pub fn start(&self) -> Option<(&wgpu::QuerySet, u32)> {
        (!self.splits_passes()).then_some((&self.queries, 0))
    }

    /// Where the timestamp after a step goes.
    pub fn end(&self, step: usize) -> Option<(&wgpu::QuerySet, u32)> {
        match self.places {
            Places::Between(steps) if step < steps => Some((&self.queries, step as u32 + 1)),
            _ => None,
        }
    }

    /// Where the pass of a step writes its timestamps, if it does.
    pub fn writes(&self, step: usize) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let Places::Passes(steps) = &self.places else {
            return None;
        };
        let pair = steps.binary_search(&step).ok()? as u32;
        Some(wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(2 * pair),
            end_of_pass_write_index: Some(2 * pair + 1),
        })
    }

    /// Records the way back, after every timed step was recorded.
    pub fn resolve(&mut self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..self.places.count(), &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.readback, 0, self.resolved.size());
        self.used = true;
    }

    /// Waits for everything submitted so far and returns the times of the last measured frame.
    pub fn read(&self, context: &Context) -> Result<Option<Vec<StepTime>>, BackendError> {
        if !self.used {
            return Ok(None);
        }
        let bytes = map(context, &self.readback, self.readback.size(), None)?;
        Ok(Some(self.places.times(&stamps(&bytes), self.period)))
    }
}

/// Timestamps from their bytes.
fn stamps(bytes: &[u8]) -> Vec<u64> {
    let chunks = bytes.chunks_exact(STAMP as usize);
    chunks
        .map(|bytes| {
            let bytes = bytes.iter().rev();
            bytes.fold(0_u64, |value, &byte| (value << 8) | u64::from(byte))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn nanoseconds(places: &Places, stamps: &[u64], period: f32) -> Vec<(usize, u128, u128)> {
        let times = places.times(stamps, period);
        let times = times.iter();
        times
            .map(|t| (t.step, t.start.as_nanos(), t.time.as_nanos()))
            .collect()
    }

    #[test]
    fn bytes_become_timestamps() {
        let want = [1_000_u64, u64::MAX - 1];
        let bytes: Vec<u8> = want.iter().flat_map(|s| s.to_le_bytes()).collect();
        assert_eq!(stamps(&bytes), want);
    }

    #[test]
    fn ticks_of_passes_become_nanoseconds() {
        let places = Places::Passes(vec![4, 6]);
        assert_eq!(places.count(), 4);
        let got = nanoseconds(&places, &[1_000, 1_500, 1_700, 1_650], 2.0);
        assert_eq!(got, [(4, 0, 1_000), (6, 1_400, 0)]);
    }

    #[test]
    fn ticks_between_steps_become_nanoseconds() {
        let places = Places::Between(3);
        assert_eq!(places.count(), 4);
        let got = nanoseconds(&places, &[10, 15, 15, 40], 2.0);
        assert_eq!(got, [(0, 0, 10), (1, 10, 0), (2, 10, 50)]);
        assert_eq!(Places::Between(0).count(), 0, "nothing to time");
    }
}
