//! Frames as a trace that Chrome's `about:tracing` and Perfetto open: Google, "Trace Event Format".
use crate::stages::group_of;
use gibs_graph::{Schedule, StepTime};
use serde_json::{Value, json};
use std::time::Duration;

/// A frame whose steps were timed.
#[derive(Clone, Debug, PartialEq)]
pub struct TimedFrame {
    /// From the start of the run to that of the frame.
    pub start: Duration,
    /// From then until the device was done.
    pub wall: Duration,
    /// The steps, by the device's clock.
    pub steps: Vec<StepTime>,
}

/// Tracks of a backend's process.
const HOST: u32 = 1;
const GROUPS: u32 = 2;
const STEPS: u32 = 3;

/// Frames of several backends, each with its schedule, as JSON. Each backend is a process with three tracks: frames as the
/// host sees them, groups of stages, and steps. The device's clock is not the host's: the first step of a frame is drawn
/// where the frame starts on the host.
pub fn chrome_trace(backends: &[(&str, &Schedule, &[TimedFrame])]) -> String {
    let mut events = Vec::new();
    for (process, &(name, schedule, frames)) in (1_u32..).zip(backends) {
        let named = |what: &str, thread: u32, name: &str| json!({ "ph": "M", "name": what, "pid": process, "tid": thread, "args": { "name": name } });
        events.push(named("process_name", 0, name));
        events.push(named("thread_name", HOST, "frames"));
        events.push(named("thread_name", GROUPS, "groups"));
        events.push(named("thread_name", STEPS, "steps"));
        let slice = |thread: u32, name: &str, start: Duration, time: Duration| {
            json!({
                "ph": "X", "name": name, "pid": process, "tid": thread,
                "ts": microseconds(start), "dur": microseconds(time),
            })
        };
        for (number, frame) in frames.iter().enumerate() {
            events.push(slice(
                HOST,
                &format!("frame {number}"),
                frame.start,
                frame.wall,
            ));
            for run in frame
                .steps
                .chunk_by(|a, b| group_of(schedule, a.step) == group_of(schedule, b.step))
            {
                if let (Some(first), Some(last)) = (run.first(), run.last()) {
                    let time = (last.start + last.time).saturating_sub(first.start);
                    let group = group_of(schedule, first.step);
                    events.push(slice(GROUPS, &group, frame.start + first.start, time));
                }
            }
            for step in &frame.steps {
                let label = schedule.steps.get(step.step).map_or("?", |s| &s.label);
                events.push(slice(STEPS, label, frame.start + step.start, step.time));
            }
        }
    }
    let trace: Value = json!({ "displayTimeUnit": "ms", "traceEvents": events });
    trace.to_string()
}

fn microseconds(time: Duration) -> f64 {
    time.as_nanos() as f64 / 1e3
}
