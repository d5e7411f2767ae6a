//! Frames in lockstep: every step from equal inputs on every backend.
use super::compare::compare;
use super::contents::{Contents, poison};
use super::isolate::isolate;
use super::judge::{Judge, steps, tally};
use super::report::{CaseReport, PairReport};
use super::run::{Captures, CheckOptions};
use super::{Capture, Case, CheckError, Participant};
use crate::{
    Action, BackendError, Comparator, DispatchStep, Executable, Kind, Order, ResourceId, Schedule,
    Step,
};

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

/// Where the two of a pair stand.
pub(super) fn places(participants: &[Participant<'_>], pair: &PairReport) -> [usize; 2] {
    [&pair.a, &pair.b].map(|name| {
        let place = participants.iter().position(|p| p.name == name);
        place.unwrap_or_default()
    })
}

/// Backends in lockstep.
pub(crate) struct Lockstep<'a> {
    pub(super) schedule: std::sync::Arc<Schedule>,
    pub(super) participants: &'a [Participant<'a>],
    options: &'a CheckOptions,
    execs: Vec<Box<dyn Executable>>,
    /// What each resource holds on all of them.
    contents: Contents,
    /// The next frame.
    next: u32,
    pub report: CaseReport,
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
            next: 0,
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

    /// Runs frames on the first participant alone, up to this one, which comes next on all.
    pub fn skip_to(&mut self, case: &mut Case<'_>, frame: u32) -> Result<(), CheckError> {
        if self.next >= frame {
            return Ok(());
        }
        let name = case.name.clone();
        let first = self.participants[0].name;
        for number in self.next..frame {
            let failed = |backend: &str, source| CheckError::Backend {
                case: name.clone(),
                frame: number,
                step: "frame".into(),
                backend: backend.into(),
                source: Box::new(source),
            };
            let uploads = case.uploads(number).map_err(|source| CheckError::Feed {
                case: name.clone(),
                frame: number,
                source: Box::new(source),
            })?;
            for (exec, participant) in self.execs.iter_mut().zip(self.participants) {
                let uploaded = uploads
                    .iter()
                    .try_for_each(|up| exec.upload(up.resource, up.offset, &up.bytes));
                uploaded.map_err(|source| failed(participant.name, source))?;
            }
            self.contents.write(uploads);
            self.execs[0]
                .run()
                .map_err(|source| failed(first, source))?;
        }
        let schedule = self.schedule.clone();
        let mut settle = || {
            self.contents.keep(&schedule, self.execs[0].as_mut())?;
            for (id, resource) in (0..).zip(&schedule.resources) {
                if !matches!(resource.kind, Kind::State(_) | Kind::History(_)) {
                    continue;
                }
                for exec in &mut self.execs[1..] {
                    exec.upload(id, 0, &self.contents.current[id as usize])?;
                }
            }
            Ok(())
        };
        settle().map_err(|source| CheckError::Backend {
            case: name.clone(),
            frame,
            step: "state".into(),
            backend: first.into(),
            source: Box::new(source),
        })?;
        self.next = frame;
        Ok(())
    }

    fn give(&mut self, id: ResourceId, bytes: &[u8]) -> Result<(), BackendError> {
        self.execs
            .iter_mut()
            .try_for_each(|exec| exec.upload(id, 0, bytes))
    }

    /// Runs the next frame and compares. Of steps that are `wanted`, by their names, there is a capture in any case.
    pub fn frame(
        &mut self,
        case: &mut Case<'_>,
        frame: u32,
        captures: &mut Captures,
        wanted: &mut dyn FnMut(&str, &DispatchStep) -> bool,
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
            if let Action::Dispatch(dispatch) = &step.action
                && wanted(&step.label, dispatch)
            {
                let all: Vec<usize> = (0..self.participants.len()).collect();
                captures
                    .wanted
                    .extend(self.capture(&name, frame, i, &outputs, &all));
            }
            self.judge(&name, frame, i, &outputs, &mut captures.differing)
                .map_err(|source| failed(self.participants[0].name, &step.label, source))?;
            self.look_after(&name, frame, i, &outputs, &mut captures.differing)
                .map_err(|(backend, source)| failed(backend, &step.label, source))?;
            self.settle(step, outputs)
                .map_err(|source| failed("all", &step.label, source))?;
        }
        self.report.frames += 1;
        self.next = frame + 1;
        Ok(())
    }

    /// For each port that the step writes, what each participant has.
    fn outputs(&mut self, step: &Step) -> Result<Vec<Vec<Vec<u8>>>, (&'a str, BackendError)> {
        let written = written(step).into_iter();
        written.map(|written| self.read(written.resource)).collect()
    }

    /// What each participant has of a resource.
    pub(super) fn read(
        &mut self,
        resource: ResourceId,
    ) -> Result<Vec<Vec<u8>>, (&'a str, BackendError)> {
        let lanes = self.execs.iter_mut().zip(self.participants);
        lanes
            .map(|(exec, participant)| {
                let read = exec.read(resource);
                read.map_err(|source| (participant.name, source))
            })
            .collect()
    }

    /// All go on from what the first one made.
    fn settle(&mut self, step: &Step, outputs: Vec<Vec<Vec<u8>>>) -> Result<(), BackendError> {
        for (written, lanes) in written(step).into_iter().zip(outputs) {
            self.settle_one(written.resource, lanes)?;
        }
        Ok(())
    }

    pub(super) fn settle_one(
        &mut self,
        resource: ResourceId,
        mut lanes: Vec<Vec<u8>>,
    ) -> Result<(), BackendError> {
        for (exec, bytes) in self.execs.iter_mut().zip(&lanes).skip(1) {
            if *bytes != lanes[0] {
                exec.upload(resource, 0, &lanes[0])?;
            }
        }
        self.contents.current[resource as usize] = lanes.swap_remove(0);
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
                let [a, b] = places(self.participants, pair);
                // What the report says is what was used.
                let mut comparator = port.comparator;
                if pair.exact && comparator.order == Order::InOrder {
                    comparator.floats = crate::Floats::Exact;
                }
                let resource = &schedule.resources[written.resource as usize];
                let [x, y] = [&lanes[a], &lanes[b]];
                let found = compare(&resource.element, resource.len, &comparator, x, y, &lists);
                let undecided = match found.refused.is_empty() || pair.exact {
                    true => 0,
                    false => judge.undecided(&mut condition, &written, &found.refused, [x, y])?,
                };
                if tally(pair, frame, found, undecided) {
                    differs.get_or_insert((a, b));
                }
            }
        }
        if let Some((a, b)) = differs {
            self.keep_capture(case, frame, index, outputs, [a, b], captures);
        }
        Ok(())
    }

    /// Adds a capture of a step to those of others, as far as there is room.
    pub(super) fn keep_capture(
        &self,
        case: &str,
        frame: u32,
        index: usize,
        outputs: &[Vec<Vec<u8>>],
        lanes: [usize; 2],
        captures: &mut Vec<Capture>,
    ) {
        let label = &self.schedule.steps[index].label;
        let known = captures.iter().any(|c| c.case == case && c.label == *label);
        if captures.len() < self.options.captures && !known {
            captures.extend(self.capture(case, frame, index, outputs, &lanes));
        }
    }

    /// A step with what it read, and what some participants made of it; `None` for a clear.
    fn capture(
        &self,
        case: &str,
        frame: u32,
        index: usize,
        outputs: &[Vec<Vec<u8>>],
        lanes: &[usize],
    ) -> Option<Capture> {
        let isolated = isolate(&self.schedule, index)?;
        let contents = self.contents.of(&isolated.sources);
        let mut capture = Capture::new(case, frame, &isolated, &contents);
        for &lane in lanes {
            let results = outputs.iter().map(|lanes| lanes[lane].clone());
            capture.add_results(self.participants[lane], results.collect());
        }
        Some(capture)
    }
}
