//! Running a capture alone.
use super::Capture;
use super::compare::{Comparison, compare};
use super::error::CaptureError;
use crate::{Action, Backend, BackendError, Executable, Order, Ports, Schedule, StageInfo};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// What a backend made of a capture.
#[derive(Clone, Debug)]
pub struct Replayed {
    /// The step alone.
    pub schedule: Arc<Schedule>,
    /// Content of the written buffers after the step, in the order of [`Capture::written`].
    pub outputs: Vec<Vec<u8>>,
    /// Time of each run: on the device where it has a clock, else from submission until it was done.
    pub times: Vec<Duration>,
    /// Whether every run gave the bits of the first.
    pub repeatable: bool,
    /// Buffers that the step only reads and that did not hold the same bytes after it, by their keys.
    pub scribbled: Vec<String>,
}

/// Runs a capture's step on a backend, `runs` times from the same inputs.
///
/// # Errors
/// [`CaptureError::UnknownStage`], [`CaptureError::Changed`], [`CaptureError::Backend`].
pub fn replay(
    capture: &Capture,
    stages: &[StageInfo],
    backend: &dyn Backend,
    runs: u32,
) -> Result<Replayed, CaptureError> {
    let schedule = capture.schedule(stages)?;
    let run = || {
        let mut exec = backend.prepare(schedule.clone())?;
        let mut replayed = Replayed {
            schedule: schedule.clone(),
            outputs: Vec::new(),
            times: Vec::new(),
            repeatable: true,
            scribbled: Vec::new(),
        };
        for n in 0..runs.max(1) {
            let (outputs, time) = once(exec.as_mut(), capture)?;
            replayed.times.push(time);
            if n == 0 {
                replayed.outputs = outputs;
                replayed.scribbled = scribbled(exec.as_mut(), capture)?;
            } else {
                replayed.repeatable &= outputs == replayed.outputs;
            }
        }
        Ok(replayed)
    };
    run().map_err(|source: BackendError| CaptureError::Backend {
        stage: capture.label.clone(),
        backend: backend.name().into(),
        source: Box::new(source),
    })
}

fn once(
    exec: &mut dyn Executable,
    capture: &Capture,
) -> Result<(Vec<Vec<u8>>, Duration), BackendError> {
    for (id, buffer) in (0..).zip(&capture.buffers) {
        exec.upload(id, 0, &buffer.bytes)?;
    }
    exec.wait()?;
    exec.measure(true);
    let start = Instant::now();
    exec.run()?;
    exec.wait()?;
    let elapsed = start.elapsed();
    let measured = exec
        .timings()?
        .and_then(|times| times.first().map(|first| first.time));
    let outputs = capture.written().into_iter().map(|id| exec.read(id));
    Ok((
        outputs.collect::<Result<_, _>>()?,
        measured.unwrap_or(elapsed),
    ))
}

/// What a run has changed of what the step only reads. Images come back as their format rounds them, and are left out.
fn scribbled(exec: &mut dyn Executable, capture: &Capture) -> Result<Vec<String>, BackendError> {
    let written = capture.written();
    let schedule = exec.schedule().clone();
    let mut found = Vec::new();
    for (id, buffer) in (0..).zip(&capture.buffers) {
        let resource = &schedule.resources[id as usize];
        let is_there = resource.usage.uniform || resource.usage.storage;
        if written.contains(&id) || resource.image.is_some() || !is_there {
            continue;
        }
        if exec.read(id)? != buffer.bytes {
            found.push(buffer.key.clone());
        }
    }
    Ok(found)
}

/// Holds what was made against another result of the same capture, port by port, as the ports' comparators say.
pub fn verify(
    capture: &Capture,
    schedule: &Schedule,
    expected: &[Vec<u8>],
    found: &[Vec<u8>],
) -> Vec<(String, Comparison)> {
    let Some(Action::Dispatch(dispatch)) = schedule.steps.first().map(|step| &step.action) else {
        return Vec::new();
    };
    let written = capture.written();
    let mut ports = Ports::default();
    for binding in &dispatch.bindings {
        let buffer = &capture.buffers[binding.resource as usize];
        let after = written.iter().position(|&id| id == binding.resource);
        let bytes = after.and_then(|i| expected.get(i)).unwrap_or(&buffer.bytes);
        ports.push(binding.port, &buffer.element, bytes);
    }
    let bound = dispatch.ports.iter().zip(&dispatch.bindings);
    bound
        .filter(|(port, _)| port.access.writes())
        .map(|(port, binding)| {
            let lists = match port.comparator.order {
                Order::AnyWithin(lists) => (lists.of)(&ports),
                _ => Vec::new(),
            };
            // The file's ports may stand in another order.
            let place = written.iter().position(|&id| id == binding.resource);
            let of = |outputs: &[Vec<u8>]| {
                let bytes = place.and_then(|i| outputs.get(i));
                bytes.cloned().unwrap_or_default()
            };
            let (a, b) = (of(expected), of(found));
            let len = capture.buffers[binding.resource as usize].len;
            let found = compare(&port.element, len, &port.comparator, &a, &b, &lists);
            (port.name.to_owned(), found)
        })
        .collect()
}
