//! What a check found, and whether it looked everywhere.
use super::{Case, Difference, Participant};
use crate::{Comparator, DeviceInfo, Floats, Schedule};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;

/// What a check found.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Version of the library.
    pub version: &'static str,
    /// What took part, in order; the first one's values are what all went on from.
    pub lanes: Vec<Lane>,
    /// Case by case.
    pub cases: Vec<CaseReport>,
}

/// A participant.
#[derive(Clone, Debug, Serialize)]
pub struct Lane {
    /// Its name.
    pub name: String,
    /// Its device.
    pub device: DeviceInfo,
}

/// One case.
#[derive(Clone, Debug, Serialize)]
pub struct CaseReport {
    /// Its name.
    pub name: String,
    /// Frames that ran.
    pub frames: u32,
    /// Step by step, those that were compared.
    pub steps: Vec<StepReport>,
}

/// One step.
#[derive(Clone, Debug, Serialize)]
pub struct StepReport {
    /// Index in the schedule.
    pub step: usize,
    /// Name in the frame.
    pub label: String,
    /// Type name of the stage; empty for a clear.
    pub stage: String,
    /// What it writes, and then what it only reads and has to leave as it is.
    pub ports: Vec<PortReport>,
}

/// One port of a step.
#[derive(Clone, Debug, Serialize)]
pub struct PortReport {
    /// Port; `cleared` for a clear.
    pub port: String,
    /// Resource behind it.
    pub resource: String,
    /// How it was compared.
    pub comparator: Comparator,
    /// The step only reads it, and has to leave it as it is.
    pub only_read: bool,
    /// It holds no floats, so that the comparator's tolerance means nothing.
    pub integers: bool,
    /// Every pair of participants.
    pub pairs: Vec<PairReport>,
}

/// One pair of participants at one port, over all frames.
#[derive(Clone, Debug, Serialize)]
pub struct PairReport {
    /// First participant.
    pub a: String,
    /// Second participant.
    pub b: String,
    /// Compared to the bit, whatever the comparator allows.
    pub exact: bool,
    /// Frames in which it was compared.
    pub frames: u32,
    /// Elements that were compared, over all frames.
    pub elements: u64,
    /// Elements that were not, since their list did not fit: which are there is chance, and nothing reads them.
    pub skipped: u64,
    /// Elements of which a bit differs.
    pub unequal: u64,
    /// Elements that the comparator refuses, but which move as far when inputs are rounded once more.
    pub undecided: u64,
    /// Elements that differ for no such reason.
    pub refused: u64,
    /// Frame and difference of the worst number.
    pub worst: Option<(u32, Difference)>,
    /// First frame with a difference.
    pub differs_in: Option<u32>,
    /// What follows from that.
    pub verdict: Verdict,
}

/// What was found at a port.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Every bit is equal.
    Equal,
    /// Within what the comparator allows.
    Within,
    /// But for elements that a rounding decides about.
    Undecided,
    /// A difference that is listed as expected.
    Expected,
    /// A difference.
    Differs,
}

impl Report {
    /// The worst verdict of all.
    pub fn verdict(&self) -> Verdict {
        let verdicts = self.pairs().map(|(.., pair)| pair.verdict);
        verdicts.max().unwrap_or(Verdict::Differs)
    }

    /// Everything that was compared.
    pub fn pairs(
        &self,
    ) -> impl Iterator<Item = (&CaseReport, &StepReport, &PortReport, &PairReport)> {
        self.cases.iter().flat_map(|case| {
            case.steps.iter().flat_map(move |step| {
                let ports = step.ports.iter();
                ports.flat_map(move |port| {
                    port.pairs.iter().map(move |pair| (case, step, port, pair))
                })
            })
        })
    }

    /// Elements that were compared.
    pub fn elements(&self) -> u64 {
        self.pairs().map(|(.., pair)| pair.elements).sum()
    }

    /// Elements of lists that did not fit, which were not compared.
    pub fn skipped(&self) -> u64 {
        self.pairs().map(|(.., pair)| pair.skipped).sum()
    }

    /// What is not as a complete check of these cases on these participants would have left it: a step, a port or a pair of
    /// participants of which not all elements were compared in every frame, a comparator that is looser than the declared one, a
    /// verdict that the figures do not bear out. Empty for a check that says what it seems to say.
    ///
    /// Asks the schedules and the participants what should have been compared, not the code that compared it.
    pub fn gaps(&self, cases: &[Case<'_>], participants: &[Participant<'_>]) -> Vec<Gap> {
        let mut gaps = Vec::new();
        let names = participants.iter().map(|p| p.name);
        if !names
            .clone()
            .eq(self.lanes.iter().map(|lane| lane.name.as_str()))
        {
            let problem = "other participants than took part";
            gaps.push(Gap::new("", "", "", problem));
        }
        for case in cases {
            match self
                .cases
                .iter()
                .filter(|report| report.name == case.name)
                .collect::<Vec<_>>()[..]
            {
                [report] => gaps_of(
                    report,
                    &case.schedule,
                    participants,
                    case.frames.len() as u32,
                    &mut gaps,
                ),
                _ => gaps.push(Gap::new(&case.name, "", "", "the case is not there once")),
            }
        }
        gaps
    }
}

fn gaps_of(
    report: &CaseReport,
    schedule: &Schedule,
    participants: &[Participant<'_>],
    frames: u32,
    gaps: &mut Vec<Gap>,
) {
    let steps: BTreeMap<usize, &StepReport> =
        report.steps.iter().map(|step| (step.step, step)).collect();
    for (i, step) in schedule.steps.iter().enumerate() {
        let mut gap = |port: &str, problem: &str| {
            gaps.push(Gap::new(&report.name, &step.label, port, problem));
        };
        let Some(found) = steps.get(&i) else {
            gap("", "the step was not compared");
            continue;
        };
        for (name, resource, comparator) in super::judge::compared(schedule, i) {
            let Some(port) = found.ports.iter().find(|port| port.port == name) else {
                gap(name, "the port was not compared");
                continue;
            };
            if is_looser(&port.comparator, &comparator) {
                gap(name, "the comparator is looser than the declared one");
            }
            let in_lists = matches!(comparator.order, crate::Order::AnyWithin(_));
            let len = schedule.resources[resource as usize].len;
            for (a, b) in pairs_of(participants) {
                let pair = port.pairs.iter().find(|pair| pair.a == a && pair.b == b);
                match pair {
                    None => gap(name, &format!("{a} and {b} were not compared")),
                    Some(pair) => {
                        for problem in pair.inconsistencies(frames, len, in_lists) {
                            gap(name, &format!("{a} and {b}: {problem}"));
                        }
                    }
                }
            }
        }
    }
}

/// The names of every pair.
fn pairs_of<'a>(participants: &'a [Participant<'_>]) -> impl Iterator<Item = (&'a str, &'a str)> {
    let numbered = participants.iter().enumerate();
    numbered.flat_map(move |(i, a)| participants[i + 1..].iter().map(|b| (a.name, b.name)))
}

impl PairReport {
    /// `len` is the number of elements of the port, of which only those in lists may be skipped.
    fn inconsistencies(&self, frames: u32, len: u64, in_lists: bool) -> Vec<String> {
        let mut found = Vec::new();
        if self.frames != frames {
            found.push(format!("compared in {} of {frames} frames", self.frames));
        }
        let all = u64::from(frames) * len;
        let skipped = if in_lists { self.skipped } else { 0 };
        if self.elements + skipped != all {
            found.push(format!("compared {} of {all} elements", self.elements));
        }
        let bears_out = match self.verdict {
            Verdict::Equal => self.unequal + self.undecided + self.refused == 0,
            Verdict::Within => self.undecided + self.refused == 0,
            Verdict::Undecided => self.refused == 0,
            Verdict::Expected | Verdict::Differs => self.refused + self.undecided > 0,
        };
        if !bears_out {
            found.push(format!("the figures do not bear out `{:?}`", self.verdict));
        }
        found
    }
}

/// Something that a check did not look at.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Gap {
    /// Case; empty for the whole report.
    pub case: String,
    /// Step; empty for the whole case.
    pub step: String,
    /// Port; empty for the whole step.
    pub port: String,
    /// What is missing.
    pub problem: String,
}

impl Gap {
    fn new(case: &str, step: &str, port: &str, problem: &str) -> Self {
        let [case, step, port, problem] = [case, step, port, problem].map(str::to_owned);
        Self {
            case,
            step,
            port,
            problem,
        }
    }
}

impl fmt::Display for Gap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}: {} {}: {}",
            self.case, self.step, self.port, self.problem
        )
    }
}

/// Whether `used` may pass what `declared` would refuse.
fn is_looser(used: &Comparator, declared: &Comparator) -> bool {
    let floats = match (used.floats, declared.floats) {
        (Floats::Exact, _) => false,
        (Floats::Ulps(used), Floats::Ulps(declared) | Floats::Scaled(declared))
        | (Floats::Scaled(used), Floats::Scaled(declared)) => used > declared,
        (Floats::Absolute(used), Floats::Absolute(declared)) => used > declared,
        _ => true,
    };
    let order = used.order != declared.order && used.order != crate::Order::InOrder;
    floats || order || (used.non_finite && !declared.non_finite)
}
