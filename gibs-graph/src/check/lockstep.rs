//! Frames in lockstep: every step from equal inputs on every backend.
use super::case::distinct;
use super::compare::{UNWRITTEN, compare};
use super::condition::{Condition, undecided_cap};
use super::isolate::isolate;
use super::report::{CaseReport, Lane, PairReport, PortReport, Report, StepReport, Verdict};
use super::{Capture, Case, CheckError, Participant};
use crate::{
    Access, Action, Backend, BackendError, Comparator, Executable, Kind, Order, Ports, Resource,
    ResourceId, Schedule, Step,
};
use std::ops::Range;

/// What is checked how.
#[derive(Clone, Debug, Default)]
pub struct CheckOptions {
    /// Report only steps and stages of which the name contains this.
    pub stage: Option<String>,
    /// Pairs of participants that have to be equal to the bit wherever elements have an order.
    pub exact: Vec<(String, String)>,
    /// Most captures of differences to keep.
    pub captures: usize,
}

/// What a check gives.
#[derive(Debug)]
pub struct Checked {
    /// What was found.
    pub report: Report,
    /// The first difference of each step that has one, as far as was asked for.
    pub captures: Vec<Capture>,
}

/// A port that a step writes.
pub(crate) struct Written {
    pub port: &'static str,
    pub resource: ResourceId,
    pub comparator: Comparator,
}

/// What a step writes.
pub(crate) fn written(step: &Step) -> Vec<Written> {
    match &step.action {
        Action::Clear(resource) => vec![Written {
            port: "cleared",
            resource: *resource,
            comparator: Comparator::exact("a clear writes zeros"),
        }],
        Action::Dispatch(dispatch) => dispatch
            .ports
            .iter()
            .zip(&dispatch.bindings)
            .filter(|(port, _)| port.access.writes())
            .map(|(port, binding)| Written {
                port: binding.port,
                resource: binding.resource,
                comparator: port.comparator,
            })
            .collect(),
    }
}

/// Runs each case on all participants and holds every pair of them against each other after every step. The first one is
/// the oracle: all go on from its values, and it tells what a rounding decides. `progress` hears of finished frames of a
/// case.
///
/// # Errors
/// [`CheckError::TooFew`], [`CheckError::Same`], [`CheckError::Mislabelled`]; [`CheckError::Shared`];
/// [`CheckError::NoStage`]; [`CheckError::Backend`] and [`CheckError::Feed`] of what failed on the way. A difference is none.
pub fn check(
    cases: &mut [Case<'_>],
    participants: &[Participant<'_>],
    options: &CheckOptions,
    mut progress: impl FnMut(&str, u32, u32),
) -> Result<Checked, CheckError> {
    distinct(participants)?;
    let lanes = participants.iter().map(|p| Lane {
        name: p.name.into(),
        device: p.backend.device().clone(),
    });
    let mut checked = Checked {
        report: Report {
            version: env!("CARGO_PKG_VERSION"),
            lanes: lanes.collect(),
            cases: Vec::new(),
        },
        captures: Vec::new(),
    };
    for case in cases.iter_mut() {
        case.keeps_transients()?;
        let mut run = Lockstep::new(case, participants, options)?;
        for frame in 0..case.frames {
            run.frame(case, frame, &mut checked.captures)?;
            progress(&case.name, frame + 1, case.frames);
        }
        checked.report.cases.push(run.report);
    }
    if let Some(stage) = &options.stage
        && checked
            .report
            .cases
            .iter()
            .all(|case| case.steps.is_empty())
    {
        let names: Vec<_> = cases.iter().map(|case| case.name.as_str()).collect();
        return Err(CheckError::NoStage {
            case: names.join("`, `"),
            stage: stage.clone(),
        });
    }
    Ok(checked)
}

/// Backends in lockstep.
pub(crate) struct Lockstep<'a> {
    schedule: std::sync::Arc<Schedule>,
    participants: &'a [Participant<'a>],
    options: &'a CheckOptions,
    execs: Vec<Box<dyn Executable>>,
    /// What each resource holds on all of them.
    contents: Contents,
    pub report: CaseReport,
}

/// What the resources of a schedule hold.
#[derive(Clone)]
pub(crate) struct Contents {
    pub current: Vec<Vec<u8>>,
    /// Of histories.
    pub previous: Vec<Vec<u8>>,
}

impl Contents {
    /// What they start with.
    pub fn new(schedule: &Schedule) -> Self {
        let first = |resource: &Resource| match &resource.kind {
            Kind::State(initial) | Kind::History(initial) => initial.bytes(resource.bytes as usize),
            _ => vec![0; resource.bytes as usize],
        };
        let current: Vec<_> = schedule.resources.iter().map(first).collect();
        let resources = schedule.resources.iter().zip(&current);
        let previous = resources.map(|(resource, current)| match resource.kind {
            Kind::History(_) => current.clone(),
            _ => Vec::new(),
        });
        Self {
            previous: previous.collect(),
            current,
        }
    }

    /// What the host writes.
    pub fn write(&mut self, uploads: &[super::Upload]) {
        for upload in uploads {
            let from = upload.offset as usize;
            self.current[upload.resource as usize][from..from + upload.bytes.len()]
                .copy_from_slice(&upload.bytes);
        }
    }

    /// Begins a frame.
    pub fn rotate(&mut self, schedule: &Schedule) {
        for (id, resource) in schedule.resources.iter().enumerate() {
            if let Kind::History(_) = resource.kind {
                std::mem::swap(&mut self.current[id], &mut self.previous[id]);
            }
        }
    }

    /// The contents of an isolated step's resources.
    pub fn of(&self, sources: &[(ResourceId, bool)]) -> Vec<&[u8]> {
        let one = |&(id, previous): &(ResourceId, bool)| match previous {
            true => self.previous[id as usize].as_slice(),
            false => self.current[id as usize].as_slice(),
        };
        sources.iter().map(one).collect()
    }
}

/// Resources that a frame starts without a value of, and what stands there until one is written.
pub(crate) fn poison(schedule: &Schedule) -> Vec<(ResourceId, Vec<u8>)> {
    let undefined = (0..).zip(&schedule.resources).filter(|(_, resource)| {
        matches!(resource.kind, Kind::Transient) && resource.image.is_none()
    });
    undefined
        .map(|(id, resource)| {
            let pattern = UNWRITTEN.to_ne_bytes().into_iter().cycle();
            (id, pattern.take(resource.bytes as usize).collect())
        })
        .collect()
}

impl<'a> Lockstep<'a> {
    pub fn new(
        case: &Case<'_>,
        participants: &'a [Participant<'a>],
        options: &'a CheckOptions,
    ) -> Result<Self, CheckError> {
        let schedule = &case.schedule;
        let prepare = |p: &Participant<'_>| {
            let exec = p.backend.prepare(schedule.clone());
            exec.map_err(|source| CheckError::Backend {
                case: case.name.clone(),
                frame: 0,
                step: "prepare".into(),
                backend: p.name.into(),
                source: Box::new(source),
            })
        };
        Ok(Self {
            execs: participants.iter().map(prepare).collect::<Result<_, _>>()?,
            contents: Contents::new(schedule),
            report: CaseReport {
                name: case.name.clone(),
                frames: 0,
                steps: steps(schedule, participants, options),
            },
            schedule: schedule.clone(),
            participants,
            options,
        })
    }

    /// Goes on from these contents, as those after a frame.
    pub fn restore(&mut self, contents: &Contents) -> Result<(), BackendError> {
        for (id, bytes) in (0..).zip(&contents.current) {
            if self.schedule.resources[id as usize].kind.persists() {
                self.give(id, bytes)?;
            }
        }
        self.contents = contents.clone();
        Ok(())
    }

    fn give(&mut self, id: ResourceId, bytes: &[u8]) -> Result<(), BackendError> {
        self.execs
            .iter_mut()
            .try_for_each(|exec| exec.upload(id, 0, bytes))
    }

    /// Runs the next frame and compares.
    pub fn frame(
        &mut self,
        case: &mut Case<'_>,
        frame: u32,
        captures: &mut Vec<Capture>,
    ) -> Result<(), CheckError> {
        let name = case.name.clone();
        let failed = |backend: &str, step: &str, source| CheckError::Backend {
            case: name.clone(),
            frame,
            step: step.into(),
            backend: backend.into(),
            source: Box::new(source),
        };
        let uploads = case.uploads(frame).map_err(|source| CheckError::Feed {
            case: name.clone(),
            frame,
            source: Box::new(source),
        })?;
        for (exec, participant) in self.execs.iter_mut().zip(self.participants) {
            let mut begin = || {
                for upload in uploads {
                    exec.upload(upload.resource, upload.offset, &upload.bytes)?;
                }
                exec.rotate()
            };
            begin().map_err(|source| failed(participant.name, "upload", source))?;
        }
        self.contents.write(uploads);
        let schedule = self.schedule.clone();
        self.contents.rotate(&schedule);
        for (id, bytes) in poison(&schedule) {
            self.give(id, &bytes)
                .map_err(|source| failed("all", "fill", source))?;
            self.contents.current[id as usize] = bytes;
        }
        for (i, step) in schedule.steps.iter().enumerate() {
            for (exec, participant) in self.execs.iter_mut().zip(self.participants) {
                exec.run_step(i)
                    .map_err(|source| failed(participant.name, &step.label, source))?;
            }
            let outputs = self
                .outputs(step)
                .map_err(|(backend, source)| failed(backend, &step.label, source))?;
            self.judge(&name, frame, i, &outputs, captures)
                .map_err(|source| failed(self.participants[0].name, &step.label, source))?;
            self.settle(step, outputs)
                .map_err(|source| failed("all", &step.label, source))?;
        }
        self.report.frames = frame + 1;
        Ok(())
    }

    /// For each port that the step writes, what each participant has.
    fn outputs(&mut self, step: &Step) -> Result<Vec<Vec<Vec<u8>>>, (&'a str, BackendError)> {
        let mut outputs = Vec::new();
        for written in written(step) {
            let lanes = self.execs.iter_mut().zip(self.participants);
            let read: Result<Vec<_>, _> = lanes
                .map(|(exec, participant)| {
                    let read = exec.read(written.resource);
                    read.map_err(|source| (participant.name, source))
                })
                .collect();
            outputs.push(read?);
        }
        Ok(outputs)
    }

    /// All go on from what the first one made.
    fn settle(&mut self, step: &Step, outputs: Vec<Vec<Vec<u8>>>) -> Result<(), BackendError> {
        for (written, mut lanes) in written(step).into_iter().zip(outputs) {
            for (exec, bytes) in self.execs.iter_mut().zip(&lanes).skip(1) {
                if *bytes != lanes[0] {
                    exec.upload(written.resource, 0, &lanes[0])?;
                }
            }
            self.contents.current[written.resource as usize] = lanes.swap_remove(0);
        }
        Ok(())
    }

    /// Compares what the participants made of a step, while `contents` are still those before it.
    fn judge(
        &mut self,
        case: &str,
        frame: u32,
        index: usize,
        outputs: &[Vec<Vec<u8>>],
        captures: &mut Vec<Capture>,
    ) -> Result<(), BackendError> {
        let schedule = self.schedule.clone();
        let step = &schedule.steps[index];
        let Some(report) = self
            .report
            .steps
            .iter_mut()
            .find(|report| report.step == index)
        else {
            return Ok(());
        };
        let judge = Judge {
            schedule: &schedule,
            index,
            contents: &self.contents,
            oracle: self.participants[0].backend,
        };
        let mut condition = None;
        let mut differs = None;
        let ports = written(step).into_iter().zip(&mut report.ports);
        for ((written, port), lanes) in ports.zip(outputs) {
            let lists = judge.lists(&written.comparator, outputs);
            for pair in &mut port.pairs {
                let [a, b] = [&pair.a, &pair.b].map(|name| {
                    self.participants
                        .iter()
                        .position(|p| p.name == name)
                        .unwrap_or_default()
                });
                let mut comparator = written.comparator;
                if pair.exact && comparator.order == Order::InOrder {
                    comparator.floats = crate::Floats::Exact;
                }
                let element = &schedule.resources[written.resource as usize].element;
                let found = compare(element, &comparator, &lanes[a], &lanes[b], &lists);
                let undecided = match found.refused.is_empty() || pair.exact {
                    true => 0,
                    false => judge.undecided(
                        &mut condition,
                        &written,
                        &found.refused,
                        [&lanes[a], &lanes[b]],
                    )?,
                };
                if record(pair, frame, found, undecided) {
                    differs.get_or_insert((a, b));
                }
            }
        }
        let known = captures
            .iter()
            .any(|c| c.case == case && c.label == step.label);
        if let Some((a, b)) = differs
            && captures.len() < self.options.captures
            && !known
            && let Some(isolated) = isolate(&schedule, index)
        {
            let names = [a, b].map(|lane| self.participants[lane]);
            let contents = self.contents.of(&isolated.sources);
            let mut capture = Capture::new(case, frame, &isolated, &contents);
            for (lane, participant) in [a, b].into_iter().zip(names) {
                let results = outputs.iter().map(|lanes| lanes[lane].clone());
                capture.add_results(participant, results.collect());
            }
            captures.push(capture);
        }
        Ok(())
    }
}

/// A step under judgement.
struct Judge<'a> {
    schedule: &'a Schedule,
    index: usize,
    contents: &'a Contents,
    oracle: &'a dyn Backend,
}

impl Judge<'_> {
    /// The lists of a port whose elements have an order only across them, as the first participant has them.
    fn lists(&self, comparator: &Comparator, outputs: &[Vec<Vec<u8>>]) -> Vec<Range<usize>> {
        let Order::AnyWithin(lists) = comparator.order else {
            return Vec::new();
        };
        let step = &self.schedule.steps[self.index];
        let Action::Dispatch(dispatch) = &step.action else {
            return Vec::new();
        };
        let after: Vec<(ResourceId, &[u8])> = written(step)
            .iter()
            .zip(outputs)
            .map(|(written, lanes)| (written.resource, lanes[0].as_slice()))
            .collect();
        let mut ports = Ports::default();
        for binding in &dispatch.bindings {
            let id = binding.resource as usize;
            let changed = after.iter().find(|(id, _)| *id == binding.resource);
            let bytes = match (binding.access, changed) {
                (Access::Previous, _) => &self.contents.previous[id],
                (_, Some((_, bytes))) => *bytes,
                (_, None) => &self.contents.current[id],
            };
            ports.push(binding.port, &self.schedule.resources[id].element, bytes);
        }
        (lists.of)(&ports)
    }

    /// How many of the refused elements a rounding of the inputs explains.
    fn undecided(
        &self,
        condition: &mut Option<Condition>,
        written: &super::lockstep::Written,
        refused: &[u64],
        [a, b]: [&[u8]; 2],
    ) -> Result<u64, BackendError> {
        let element = &self.schedule.resources[written.resource as usize].element;
        let elements = (a.len() / element.size() as usize) as u64;
        // More could not be excused anyway; and elements without an order have no counterpart in another run.
        if refused.len() as u64 > undecided_cap(elements)
            || written.comparator.order != Order::InOrder
        {
            return Ok(0);
        }
        let Some(isolated) = isolate(self.schedule, self.index) else {
            return Ok(0);
        };
        let place = (0..)
            .zip(&isolated.sources)
            .find(|(_, s)| **s == (written.resource, false));
        let Some((place, _)) = place else {
            return Ok(0);
        };
        if condition.is_none() {
            let contents = self.contents.of(&isolated.sources);
            *condition = Some(Condition::measure(self.oracle, &isolated, &contents)?);
        }
        let explained = |index: &&u64| {
            let found = condition.as_ref();
            found.is_some_and(|c| {
                c.explains(
                    place,
                    element,
                    **index,
                    [a, b],
                    written.comparator.non_finite,
                )
            })
        };
        Ok(refused.iter().filter(explained).count() as u64)
    }
}

/// Adds a frame to a pair; whether it has a difference.
fn record(pair: &mut PairReport, frame: u32, found: super::Comparison, undecided: u64) -> bool {
    let refused = found.refused.len() as u64;
    let differs = refused > undecided || undecided > undecided_cap(found.elements);
    pair.frames += 1;
    pair.elements += found.elements;
    pair.unequal += found.unequal;
    pair.undecided += undecided;
    pair.refused += refused - undecided;
    if let Some(new) = found.worst {
        let beats =
            |(_, old): &(u32, super::Difference)| (new.refused, new.ulps) > (old.refused, old.ulps);
        if pair.worst.as_ref().is_none_or(beats) {
            pair.worst = Some((frame, new));
        }
    }
    let verdict = match (differs, refused, found.unequal) {
        (true, ..) => Verdict::Differs,
        (_, 0, 0) => Verdict::Equal,
        (_, 0, _) => Verdict::Within,
        _ => Verdict::Undecided,
    };
    if differs {
        pair.differs_in.get_or_insert(frame);
    }
    pair.verdict = pair.verdict.max(verdict);
    differs
}

/// The steps to report, with nothing found yet.
fn steps(
    schedule: &Schedule,
    participants: &[Participant<'_>],
    options: &CheckOptions,
) -> Vec<StepReport> {
    let stage = |step: &Step| match &step.action {
        Action::Clear(_) => "",
        Action::Dispatch(dispatch) => dispatch.stage,
    };
    let asked = |step: &Step| {
        let wanted = options.stage.as_deref();
        wanted.is_none_or(|wanted| step.label.contains(wanted) || stage(step).contains(wanted))
    };
    let numbered = schedule.steps.iter().enumerate();
    numbered
        .filter(|(_, step)| asked(step))
        .map(|(i, step)| StepReport {
            step: i,
            label: step.label.clone(),
            stage: stage(step).into(),
            ports: written(step)
                .into_iter()
                .map(|written| PortReport {
                    port: written.port.into(),
                    resource: schedule.resources[written.resource as usize].key.clone(),
                    comparator: written.comparator,
                    pairs: pairs(participants, options),
                })
                .collect(),
        })
        .collect()
}

fn pairs(participants: &[Participant<'_>], options: &CheckOptions) -> Vec<PairReport> {
    let numbered = participants.iter().enumerate();
    numbered
        .flat_map(|(i, a)| participants[i + 1..].iter().map(move |b| (a, b)))
        .map(|(a, b)| PairReport {
            a: a.name.into(),
            b: b.name.into(),
            exact: options
                .exact
                .iter()
                .any(|(x, y)| (x == a.name && y == b.name) || (x == b.name && y == a.name)),
            frames: 0,
            elements: 0,
            unequal: 0,
            undecided: 0,
            refused: 0,
            worst: None,
            differs_in: None,
            verdict: Verdict::Equal,
        })
        .collect()
}
