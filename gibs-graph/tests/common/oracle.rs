//! A second, slow opinion on schedules, which shares no code and no data structure with compilation.
use gibs_graph::{Access, Action, DispatchSize, Kind, Schedule, Step};
use std::collections::BTreeSet;

/// A place in memory: a resource, and whether it is the allocation of the frame before.
type Place = (u32, bool);

/// What a step does to memory, as `(place, reads, writes)`.
pub fn touches(step: &Step) -> Vec<(Place, bool, bool)> {
    let dispatch = match &step.action {
        Action::Clear(resource) => return vec![((*resource, false), false, true)],
        Action::Dispatch(dispatch) => dispatch,
        other => panic!("{other:?}"),
    };
    let mut touches: Vec<_> = dispatch
        .bindings
        .iter()
        .map(|binding| match binding.access {
            Access::Uniform
            | Access::Read
            | Access::HostOnly
            | Access::Sampled
            | Access::Indirect => ((binding.resource, false), true, false),
            Access::Previous => ((binding.resource, true), true, false),
            Access::Write | Access::Stored => ((binding.resource, false), false, true),
            Access::ReadWrite | Access::Atomic => ((binding.resource, false), true, true),
            other => panic!("{other:?}"),
        })
        .collect();
    if let DispatchSize::Indirect(resource) = dispatch.size {
        touches.push(((resource, false), true, false));
    }
    touches
}

/// Every pair of steps of which one writes memory that the other one touches, with what the later one calls it.
pub fn conflicts(schedule: &Schedule) -> BTreeSet<(usize, usize, u32)> {
    let touched: Vec<_> = schedule.steps.iter().map(touches).collect();
    let mut found = BTreeSet::new();
    for later in 0..touched.len() {
        for earlier in 0..later {
            for (a, _, a_writes) in &touched[earlier] {
                for (b, _, b_writes) in &touched[later] {
                    let home = |place: &Place| schedule.resources[place.0 as usize].home;
                    if home(a) == home(b) && a.1 == b.1 && (*a_writes || *b_writes) {
                        found.insert((earlier, later, b.0));
                    }
                }
            }
        }
    }
    found
}

/// Conflicts that no barrier settles: a barrier before a step settles what stands before it with what does not.
pub fn unsettled(schedule: &Schedule) -> Vec<(usize, usize, u32)> {
    let barrier = |step: usize| !schedule.steps[step].hazards.is_empty();
    let settled = |earlier: usize, later: usize| (earlier + 1..=later).any(barrier);
    conflicts(schedule)
        .into_iter()
        .filter(|&(earlier, later, _)| !settled(earlier, later))
        .collect()
}

/// Pairs of resources that are in each other's way in memory: both at home in one place, and one of them in use between
/// the first and the last use of the other, needed after the frame, or larger than the place.
pub fn collisions(schedule: &Schedule) -> Vec<(u32, u32)> {
    let uses = |id: u32| -> Vec<usize> {
        let steps = schedule.steps.iter().enumerate();
        let touching = steps.filter(|(_, step)| touches(step).iter().any(|t| t.0.0 == id));
        touching.map(|(i, _)| i).collect()
    };
    let passes = |id: u32| {
        let kind = &schedule.resources[id as usize].kind;
        matches!(kind, Kind::Transient | Kind::Zeroed)
            && schedule.outputs.iter().all(|output| output.resource != id)
    };
    let all = 0..schedule.resources.len() as u32;
    let mut found = Vec::new();
    for a in all.clone() {
        for b in all.clone().filter(|b| *b != a) {
            let [one, other] = [a, b].map(|id| &schedule.resources[id as usize]);
            if one.home != other.home {
                continue;
            }
            let (first, then) = (uses(a), uses(b));
            let apart = first.last() < then.first() || then.last() < first.first();
            let fits = schedule.resources[one.home as usize].room >= one.bytes;
            if !(apart && passes(a) && passes(b) && fits) {
                found.push((a, b));
            }
        }
    }
    found
}

/// Some step reads a transient that no step before it has written: the order is wrong.
pub fn reads_unwritten(schedule: &Schedule) -> bool {
    let mut written = BTreeSet::new();
    for step in &schedule.steps {
        for ((id, before), reads, _) in touches(step) {
            let transient = schedule.resources[id as usize].kind == Kind::Transient;
            if transient && reads && !before && !written.contains(&id) {
                return true;
            }
        }
        written.extend(touches(step).iter().filter(|t| t.2).map(|t| t.0.0));
    }
    false
}

/// How a resource of a recorded frame starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// With what the frame before left.
    Kept,
    /// Anew.
    Anew,
    /// Anew, with what the frame before made beside it.
    Rotated,
}

/// A stage as recorded: what it reads and what it writes a part of.
#[derive(Clone, Debug, Default)]
pub struct Recorded {
    pub label: String,
    pub reads: Vec<usize>,
    pub reads_before: Vec<usize>,
    pub writes: Vec<usize>,
}

/// Stages that leave a trace in an output, found by running frames: every stage adds itself and the traces in what it
/// reads to what it writes.
pub fn traces(starts: &[Start], stages: &[Recorded], outputs: &[usize]) -> BTreeSet<usize> {
    let mut now = vec![BTreeSet::new(); starts.len()];
    let mut before = now.clone();
    // A trace crosses from frame to frame through a resource that it has not been in.
    for _ in 0..starts.len() + 2 {
        for (i, start) in starts.iter().enumerate() {
            match start {
                Start::Kept => {}
                Start::Anew => now[i].clear(),
                Start::Rotated => before[i] = std::mem::take(&mut now[i]),
            }
        }
        for (i, stage) in stages.iter().enumerate() {
            let mut trace = BTreeSet::from([i]);
            trace.extend(stage.reads.iter().flat_map(|&r| now[r].iter().copied()));
            trace.extend(
                stage
                    .reads_before
                    .iter()
                    .flat_map(|&r| before[r].iter().copied()),
            );
            for &resource in &stage.writes {
                now[resource].extend(trace.iter().copied());
            }
        }
    }
    outputs
        .iter()
        .flat_map(|&output| now[output].iter().copied())
        .collect()
}
