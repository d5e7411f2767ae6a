//! What is to be said of a step on a pair of participants.
use super::compare::Comparison;
use super::condition::{Condition, undecided_cap};
use super::contents::Contents;
use super::isolate::isolate;
use super::leaves::leaves;
use super::lockstep::{Written, written};
use super::report::{PairReport, PortReport, StepReport, Verdict};
use super::run::CheckOptions;
use super::untouched::{UNTOUCHED, only_read};
use super::{Difference, Participant};
use crate::{
    Access, Action, Backend, BackendError, Comparator, Order, Ports, ResourceId, Scalar, Schedule,
    Step,
};
use std::ops::Range;

/// A step under judgement.
pub(crate) struct Judge<'a> {
    pub schedule: &'a Schedule,
    pub index: usize,
    pub contents: &'a Contents,
    pub oracle: &'a dyn Backend,
}

impl Judge<'_> {
    /// The lists of a port whose elements have an order only across them, as the first participant has them.
    pub fn lists(&self, comparator: &Comparator, outputs: &[Vec<Vec<u8>>]) -> Vec<Range<usize>> {
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
    pub fn undecided(
        &self,
        condition: &mut Option<Condition>,
        written: &Written,
        refused: &[u64],
        [a, b]: [&[u8]; 2],
    ) -> Result<u64, BackendError> {
        let element = &self.schedule.resources[written.resource as usize].element;
        let elements = (a.len() / element.size() as usize) as u64;
        // More could not be excused anyway; where every bit counts, nothing is; and elements without an order have no
        // counterpart in another run.
        if refused.len() as u64 > undecided_cap(elements)
            || written.comparator.is_exact()
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
            found.is_some_and(|c| c.explains(place, element, **index, [a, b], &written.comparator))
        };
        Ok(refused.iter().filter(explained).count() as u64)
    }
}

/// Adds a frame to a pair; whether it has a difference.
pub(crate) fn tally(pair: &mut PairReport, frame: u32, found: Comparison, undecided: u64) -> bool {
    let refused = found.refused.len() as u64;
    pair.frames += 1;
    pair.elements += found.elements;
    pair.skipped += found.skipped;
    // Over all frames as well, so that a port of one element cannot be undecided in each.
    let too_many = undecided > undecided_cap(found.elements)
        || pair.undecided + undecided > undecided_cap(pair.elements);
    let differs = refused > undecided || too_many;
    pair.unequal += found.unequal;
    pair.undecided += undecided;
    pair.refused += refused - undecided;
    if let Some(new) = found.worst {
        let beats =
            |(_, old): &(u32, Difference)| (new.refused, new.ulps) > (old.refused, old.ulps);
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
pub(crate) fn steps(
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
            ports: compared(schedule, i)
                .map(|(port, resource, comparator)| PortReport {
                    port: port.into(),
                    resource: schedule.resources[resource as usize].key.clone(),
                    comparator,
                    only_read: comparator == UNTOUCHED,
                    integers: leaves(&schedule.resources[resource as usize].element)
                        .iter()
                        .all(|leaf| leaf.scalar != Scalar::F32),
                    pairs: pairs(participants, options),
                })
                .collect(),
        })
        .collect()
}

/// What is compared of a step: what it writes, then what it has to leave as it is.
pub(crate) fn compared(
    schedule: &Schedule,
    index: usize,
) -> impl Iterator<Item = (&'static str, ResourceId, Comparator)> {
    let written = written(&schedule.steps[index]).into_iter();
    let read = only_read(schedule, index).into_iter();
    written
        .map(|port| (port.port, port.resource, port.comparator))
        .chain(read.map(|port| (port.port, port.resource, UNTOUCHED)))
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
            skipped: 0,
            unequal: 0,
            undecided: 0,
            refused: 0,
            worst: None,
            differs_in: None,
            verdict: Verdict::Equal,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair() -> PairReport {
        let frames = 0;
        PairReport {
            a: "a".into(),
            b: "b".into(),
            exact: false,
            frames,
            elements: 0,
            skipped: 0,
            unequal: 0,
            undecided: 0,
            refused: 0,
            worst: None,
            differs_in: None,
            verdict: Verdict::Equal,
        }
    }

    #[test]
    fn a_port_of_one_element_is_undecided_once() {
        let wrong = || Comparison {
            elements: 1,
            unequal: 1,
            refused: vec![0],
            ..Comparison::default()
        };
        let mut pair = pair();
        assert!(!tally(&mut pair, 0, wrong(), 1));
        assert_eq!(pair.verdict, Verdict::Undecided);
        assert!(tally(&mut pair, 1, wrong(), 1), "one of two");
        assert_eq!((pair.verdict, pair.differs_in), (Verdict::Differs, Some(1)));
    }

    #[test]
    fn what_is_skipped_is_not_compared() {
        let half = Comparison {
            elements: 6,
            skipped: 4,
            ..Comparison::default()
        };
        let mut pair = pair();
        tally(&mut pair, 0, half, 0);
        assert_eq!((pair.elements, pair.skipped), (6, 4));
    }
}
