//! Where two backends part that run on their own.
use super::case::distinct;
use super::compare::compare;
use super::contents::Contents;
use super::lockstep::{Lockstep, written};
use super::report::Verdict;
use super::run::{Captures, CheckOptions};
use super::{Capture, Case, CheckError, Difference, Participant};
use crate::{BackendError, Executable, Order, Schedule};

/// The first place where two backends part.
#[derive(Debug)]
pub struct Parting {
    /// Frame, from 0.
    pub frame: u32,
    /// Name of the step.
    pub label: String,
    /// Type name of the stage; empty for a clear.
    pub stage: String,
    /// Port.
    pub port: String,
    /// Resource behind it.
    pub resource: String,
    /// The worst number there.
    pub difference: Difference,
    /// Elements that the comparator refuses.
    pub refused: u64,
    /// Elements of the port.
    pub elements: u64,
    /// How it came to that.
    pub way: Way,
    /// The step with its inputs; `None` for a clear.
    pub capture: Option<Capture>,
}

/// How two backends came to part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// From equal inputs, the stage gives something else.
    Stage,
    /// From equal inputs every stage of the frame agrees: differences that each is allowed have added up.
    Accumulated,
}

/// Runs two backends on their own, from the same start, until what steps have written last to a resource differs by more than
/// their comparators allow, where elements have an order; then goes through that frame in lockstep, from what the first one had before it, and
/// gives the first step that differs. `None` where they agree to the end.
///
/// All frames up to the last one of the case are looked at. With `exact`, the first bit that differs counts, where elements have an order.
///
/// # Errors
/// As [`check`](super::check).
pub fn bisect(
    case: &mut Case<'_>,
    participants: [Participant<'_>; 2],
    exact: bool,
    mut progress: impl FnMut(u32, u32),
) -> Result<Option<Parting>, CheckError> {
    distinct(&participants)?;
    case.keeps_transients()?;
    let schedule = case.schedule.clone();
    let options = CheckOptions {
        exact: match exact {
            true => vec![(participants[0].name.into(), participants[1].name.into())],
            false => Vec::new(),
        },
        captures: 1,
        ..CheckOptions::default()
    };
    let name = case.name.clone();
    let failed = |frame, step: &str, backend: &str, source| CheckError::Backend {
        case: name.clone(),
        frame,
        step: step.into(),
        backend: backend.into(),
        source: Box::new(source),
    };
    let mut execs = Vec::new();
    for participant in participants {
        let exec = participant.backend.prepare(schedule.clone());
        execs.push(exec.map_err(|source| failed(0, "prepare", participant.name, source))?);
    }
    let mut before = Contents::new(&schedule);
    let frames = case.frames.last().map_or(0, |last| last + 1);
    for frame in 0..frames {
        let uploads = case.uploads(frame).map_err(|source| CheckError::Feed {
            case: name.clone(),
            frame,
            source: Box::new(source),
        })?;
        for (exec, participant) in execs.iter_mut().zip(participants) {
            let mut run = || {
                for upload in uploads {
                    exec.upload(upload.resource, upload.offset, &upload.bytes)?;
                }
                exec.run()
            };
            run().map_err(|source| failed(frame, "frame", participant.name, source))?;
        }
        let [a, b] = &mut execs[..] else {
            return Ok(None);
        };
        let parted = part(&schedule, a.as_mut(), b.as_mut(), exact)
            .map_err(|source| failed(frame, "frame", participants[1].name, source))?;
        if let Some(parted) = parted {
            return lockstep(case, &participants, &options, frame, &before, parted).map(Some);
        }
        // Again from the case, which would not lend them over the search above.
        let uploads = case.uploads(frame).map_err(|source| CheckError::Feed {
            case: name.clone(),
            frame,
            source: Box::new(source),
        })?;
        before.write(uploads);
        before
            .keep(&schedule, a.as_mut())
            .map_err(|source| failed(frame, "frame", participants[0].name, source))?;
        progress(frame + 1, frames);
    }
    Ok(None)
}

/// The first step of a frame whose last word on a resource differs between two executables that have run it.
fn part(
    schedule: &Schedule,
    a: &mut dyn Executable,
    b: &mut dyn Executable,
    exact: bool,
) -> Result<Option<Parting>, BackendError> {
    let mut last = vec![0; schedule.resources.len()];
    for (i, step) in schedule.steps.iter().enumerate() {
        for written in written(step) {
            last[written.resource as usize] = i;
        }
    }
    for (i, step) in schedule.steps.iter().enumerate() {
        for written in written(step) {
            let mut comparator = written.comparator;
            // Where order is free within lists, other steps will have made something of them.
            if last[written.resource as usize] != i || comparator.order != Order::InOrder {
                continue;
            }
            if exact {
                comparator.floats = crate::Floats::Exact;
            }
            let resource = &schedule.resources[written.resource as usize];
            let [x, y] = [a.read(written.resource)?, b.read(written.resource)?];
            let found = compare(&resource.element, resource.len, &comparator, &x, &y, &[]);
            if let (false, Some(worst)) = (found.refused.is_empty(), found.worst) {
                return Ok(Some(Parting {
                    frame: 0,
                    label: step.label.clone(),
                    stage: String::new(),
                    port: written.port.into(),
                    resource: resource.key.clone(),
                    difference: worst,
                    refused: found.refused.len() as u64,
                    elements: found.elements,
                    way: Way::Accumulated,
                    capture: None,
                }));
            }
        }
    }
    Ok(None)
}

/// Goes through one frame in lockstep.
fn lockstep(
    case: &mut Case<'_>,
    participants: &[Participant<'_>],
    options: &CheckOptions,
    frame: u32,
    before: &Contents,
    parted: Parting,
) -> Result<Parting, CheckError> {
    let mut run = Lockstep::new(case, participants, options)?;
    run.restore(before).map_err(|source| CheckError::Backend {
        case: case.name.clone(),
        frame,
        step: "upload".into(),
        backend: participants[0].name.into(),
        source: Box::new(source),
    })?;
    let mut captures = Captures::default();
    run.frame(case, frame, &mut captures, &mut |_, _| false)?;
    let mut ports = run.report.steps.iter().flat_map(|step| {
        step.ports
            .iter()
            .flat_map(move |port| port.pairs.iter().map(move |pair| (step, port, pair)))
    });
    let Some((step, port, pair)) = ports.find(|(.., pair)| pair.verdict == Verdict::Differs) else {
        return Ok(Parting { frame, ..parted });
    };
    Ok(Parting {
        frame,
        label: step.label.clone(),
        stage: step.stage.clone(),
        port: port.port.clone(),
        resource: port.resource.clone(),
        refused: pair.refused,
        elements: pair.elements,
        difference: pair
            .worst
            .clone()
            .map_or(parted.difference, |(_, worst)| worst),
        way: Way::Stage,
        capture: captures.differing.pop(),
    })
}
