//! Time per step, from timestamps that the device writes between steps.
use crate::device::Device;
use ash::vk;
use gibs_graph::{BackendError, StepTime};
use std::sync::Arc;
use std::time::Duration;

/// Timestamps of frames of both parities.
///
/// One stands before the first step and one after each, written when everything before it is done. So a step is charged
/// with what it adds to the frame, and the steps add up to the frame.
pub(crate) struct Timer {
    pools: [vk::QueryPool; 2],
    steps: usize,
    /// Parity and submission of the last frame that was measured; no submission where a host submits it.
    last: Option<(usize, Option<u64>)>,
    device: Arc<Device>,
}

impl Timer {
    /// A timer for frames of `steps` steps; `None` where the device has no timestamps.
    pub fn new(device: &Arc<Device>, steps: usize) -> Result<Option<Self>, BackendError> {
        if device.adapter.timestamp_bits == 0 {
            return Ok(None);
        }
        let pools = [vk::QueryPool::null(); 2];
        let mut timer = Self {
            pools,
            steps,
            last: None,
            device: Arc::clone(device),
        };
        for pool in &mut timer.pools {
            let info = vk::QueryPoolCreateInfo::default()
                .query_type(vk::QueryType::TIMESTAMP)
                .query_count(steps as u32 + 1);
            // SAFETY: the device is alive and its queue has timestamps.
            *pool = unsafe { device.raw.create_query_pool(&info, None) }
                .map_err(device.fail("vkCreateQueryPool"))?;
        }
        Ok(Some(timer))
    }

    /// Starts the frame of this parity.
    ///
    /// # Safety
    /// `commands` is being recorded.
    pub unsafe fn start(&self, commands: vk::CommandBuffer, parity: usize) {
        // SAFETY: the caller's promise; the pool has this many queries.
        unsafe {
            let count = self.steps as u32 + 1;
            self.device
                .raw
                .cmd_reset_query_pool(commands, self.pools[parity], 0, count);
            self.stamp(commands, parity, 0);
        }
    }

    /// Ends a step.
    ///
    /// # Safety
    /// `commands` is being recorded, and `step` is one of the frame's.
    pub unsafe fn end_step(&self, commands: vk::CommandBuffer, parity: usize, step: usize) {
        // SAFETY: the caller's promise.
        unsafe { self.stamp(commands, parity, step as u32 + 1) };
    }

    unsafe fn stamp(&self, commands: vk::CommandBuffer, parity: usize, query: u32) {
        let when = vk::PipelineStageFlags::BOTTOM_OF_PIPE;
        // SAFETY: the callers' promise.
        unsafe {
            self.device
                .raw
                .cmd_write_timestamp(commands, when, self.pools[parity], query)
        };
    }

    /// A frame with timestamps was submitted, or recorded for a host to submit.
    pub fn submitted(&mut self, parity: usize, number: Option<u64>) {
        self.last = Some((parity, number));
    }

    /// Submission of the last frame that was measured.
    pub fn last(&self) -> Option<Option<u64>> {
        self.last.map(|(_, number)| number)
    }

    /// Times of the last measured frame, which must be done where it was submitted here; `None` where it is a host's
    /// and not done.
    pub fn read(&self) -> Result<Option<Vec<StepTime>>, BackendError> {
        let Some((parity, number)) = self.last else {
            return Ok(None);
        };
        let mut stamps = vec![0u64; self.steps + 1];
        let mut flags = vk::QueryResultFlags::TYPE_64;
        if number.is_some() {
            flags |= vk::QueryResultFlags::WAIT;
        }
        // SAFETY: the pool has this many queries, and the frame that writes them was submitted.
        let read = unsafe {
            self.device
                .raw
                .get_query_pool_results(self.pools[parity], 0, &mut stamps, flags)
        };
        if read == Err(vk::Result::NOT_READY) {
            return Ok(None);
        }
        read.map_err(self.device.fail("vkGetQueryPoolResults"))?;
        let adapter = &self.device.adapter;
        Ok(Some(durations(
            &stamps,
            adapter.timestamp_bits,
            adapter.timestamp_period,
        )))
    }
}

/// Differences of neighbours, for counters of `bits` bits that tick every `period` nanoseconds.
fn durations(stamps: &[u64], bits: u32, period: f32) -> Vec<StepTime> {
    let mask = u64::MAX.checked_shr(64 - bits.min(64)).unwrap_or(0);
    let nanoseconds = |ticks: u64| Duration::from_nanos((ticks as f64 * f64::from(period)) as u64);
    // A counter that ran over is ahead by little, one that ran backwards by nearly all that it can count: that is no time.
    let ahead = |ticks: u64| if ticks > mask / 2 { 0 } else { ticks };
    let ticks = stamps
        .windows(2)
        .map(|pair| ahead(pair[1].wrapping_sub(pair[0]) & mask));
    let mut before = 0_u64;
    ticks
        .enumerate()
        .map(|(step, ticks)| {
            let start = nanoseconds(before);
            before = before.wrapping_add(ticks);
            StepTime {
                step,
                start,
                time: nanoseconds(ticks),
            }
        })
        .collect()
}

impl Drop for Timer {
    fn drop(&mut self) {
        for pool in self.pools {
            // SAFETY: the executable waited for its work before dropping the timer; null handles are ignored.
            unsafe { self.device.raw.destroy_query_pool(pool, None) };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counters_wrap_and_scale() {
        let nanoseconds = |stamps: &[u64], bits, period| -> Vec<u128> {
            durations(stamps, bits, period)
                .iter()
                .map(|t| t.time.as_nanos())
                .collect()
        };
        assert_eq!(nanoseconds(&[10, 15, 15], 64, 2.0), [10, 0]);
        let starts = durations(&[0xffff_fff0, 0x10, 0x18, 0x20], 32, 2.0);
        let starts: Vec<u128> = starts.iter().map(|t| t.start.as_nanos()).collect();
        assert_eq!(starts, [0, 0x40, 0x50], "across the end of the counter");
        assert_eq!(
            nanoseconds(&[0xffff_fff0, 0x10], 32, 1.0),
            [0x20],
            "a 32-bit counter ran over"
        );
        assert_eq!(nanoseconds(&[u64::MAX, 1], 64, 1.0), [2]);
        // Of a counter that went back nothing is known; the next step has its time again.
        assert_eq!(nanoseconds(&[100, 90, 97], 64, 1.0), [0, 7]);
        assert_eq!(nanoseconds(&[100, 90, 97], 36, 1.0), [0, 7]);
        assert_eq!(nanoseconds(&[5], 64, 1.0), []);
    }
}
