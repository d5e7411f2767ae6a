//! Random frames, compiled, against the oracle.
mod common;

use common::oracle::{self, Recorded, Start};
use common::*;
use gibs_graph::{
    Action, Buffer, Dispatch, DispatchArgs, Graph, HazardKind, Initial, Kind, Previous, Schedule,
    State,
};
use proptest::prelude::*;
use std::collections::BTreeSet;

const LEN: u64 = 100;

/// A frame that is recorded twice: as a graph, and for the oracle.
struct Frame {
    graph: Graph,
    kinds: Vec<Kind>,
    buffers: Vec<Option<Buffer<u32>>>,
    versions: Vec<u32>,
    previous: Vec<Option<Previous<u32>>>,
    states: Vec<Option<State<u32>>>,
    /// The sizes of indirect dispatches; the oracle's last resource.
    args: Option<Buffer<DispatchArgs>>,
    stages: Vec<Recorded>,
    outputs: Vec<usize>,
}

impl Frame {
    fn new(resources: &[u8]) -> Self {
        let mut graph = Graph::new("random");
        // There is something to read in any frame.
        let mut frame = Self {
            kinds: vec![Kind::Input],
            buffers: vec![Some(graph.input("r0", LEN))],
            versions: vec![0],
            previous: vec![None],
            states: vec![None],
            args: Some(graph.zeroed("args", 1)),
            graph,
            stages: Vec::new(),
            outputs: Vec::new(),
        };
        for (i, kind) in resources.iter().enumerate() {
            frame.declare(&format!("r{}", i + 1), kind % 5);
        }
        frame
    }

    fn declare(&mut self, key: &str, kind: u8) {
        let g = &mut self.graph;
        let (kind, state, previous, buffer) = match kind {
            0 => (Kind::Input, None, None, g.input(key, LEN)),
            1 => (Kind::Transient, None, None, g.transient(key, LEN)),
            2 => (Kind::Zeroed, None, None, g.zeroed(key, LEN)),
            3 => {
                let (state, buffer) = g.state(key, LEN, Initial::Zero);
                (Kind::State(Initial::Zero), Some(state), None, buffer)
            }
            _ => {
                let (state, previous, buffer) = g.history(key, LEN, Initial::Zero);
                (
                    Kind::History(Initial::Zero),
                    Some(state),
                    Some(previous),
                    buffer,
                )
            }
        };
        self.kinds.push(kind);
        self.states.push(state);
        self.previous.push(previous);
        self.buffers.push(Some(buffer));
        self.versions.push(0);
    }

    /// The first resource from `from` on that `fits`.
    fn find(&self, from: u8, fits: impl Fn(usize) -> bool) -> Option<usize> {
        let count = self.buffers.len();
        (0..count)
            .map(|i| (i + usize::from(from)) % count)
            .find(|&i| fits(i))
    }

    fn readable(&self, i: usize) -> bool {
        self.versions[i] > 0 || !matches!(self.kinds[i], Kind::Transient | Kind::History(_))
    }

    fn writable(&self, i: usize) -> bool {
        self.kinds[i] != Kind::Input
    }

    /// Adds a stage, if there are resources for it.
    fn stage(&mut self, kind: u8, picks: [u8; 3]) -> Option<()> {
        let label = format!("group{}/stage{}", kind % 2, self.stages.len());
        let args = self.buffers.len();
        let first = self.find(picks[0], |i| self.readable(i))?;
        let mut stage = Recorded {
            label: label.clone(),
            ..Default::default()
        };
        let all = Dispatch::Elements(LEN);
        match kind % 7 {
            0 | 5 => {
                let target = self.find(picks[1], |i| i != first && self.writable(i))?;
                let buffer = self.buffers[target].take()?;
                let source = self.buffers[first].as_ref()?;
                let indirect = kind % 7 == 5;
                let size = if indirect {
                    Dispatch::Indirect(self.args.as_ref()?)
                } else {
                    all
                };
                let made = self.graph.add::<pass::Pass>(
                    &label,
                    pass::Inputs {
                        source,
                        target: buffer,
                    },
                    size,
                );
                self.made(target, made.target);
                stage.reads.push(first);
                stage.reads.extend(indirect.then_some(args));
                stage.writes.push(target);
            }
            1 => {
                let second = self.find(picks[1], |i| self.readable(i))?;
                let fits = |i| i != first && i != second && self.writable(i) && self.readable(i);
                let target = self.find(picks[2], fits)?;
                let buffer = self.buffers[target].take()?;
                let inputs = merge::Inputs {
                    first: self.buffers[first].as_ref()?,
                    second: self.buffers[second].as_ref()?,
                    target: buffer,
                };
                let made = self.graph.add::<merge::Merge>(&label, inputs, all);
                self.made(target, made.target);
                stage.reads.extend([first, second, target]);
                stage.writes.push(target);
            }
            2 => {
                let target = self.find(picks[1], |i| {
                    i != first && self.writable(i) && self.readable(i)
                })?;
                let buffer = self.buffers[target].take()?;
                let inputs = tally::Inputs {
                    source: self.buffers[first].as_ref()?,
                    target: buffer,
                };
                let made = self.graph.add::<tally::Tally>(&label, inputs, all);
                self.made(target, made.target);
                stage.reads.extend([first, target]);
                stage.writes.push(target);
            }
            3 => {
                let before = self.find(picks[0], |i| self.previous[i].is_some())?;
                let target = self.find(picks[1], |i| self.writable(i))?;
                let buffer = self.buffers[target].take()?;
                let inputs = recall::Inputs {
                    before: self.previous[before].as_ref()?,
                    target: buffer,
                };
                let made = self.graph.add::<recall::Recall>(&label, inputs, all);
                self.made(target, made.target);
                stage.reads_before.push(before);
                stage.writes.push(target);
            }
            4 => {
                let inputs = sizes::Inputs {
                    source: self.buffers[first].as_ref()?,
                    args: self.args.take()?,
                };
                let made = self
                    .graph
                    .add::<sizes::Sizes>(&label, inputs, Dispatch::Groups([1; 3]));
                self.args = Some(made.args);
                stage.reads.push(first);
                stage.writes.push(args);
            }
            _ => {
                let target = self.find(picks[1], |i| self.writable(i) && self.readable(i))?;
                let buffer = self.buffers[target].take()?;
                let batch = self.args.as_ref()?;
                let inputs = batched::Inputs {
                    batch,
                    target: buffer,
                };
                let made =
                    self.graph
                        .add::<batched::Batched>(&label, inputs, Dispatch::Indirect(batch));
                self.made(target, made.target);
                stage.reads.extend([args, target]);
                stage.writes.push(target);
            }
        }
        self.stages.push(stage);
        Some(())
    }

    fn made(&mut self, target: usize, buffer: Buffer<u32>) {
        self.buffers[target] = Some(buffer);
        self.versions[target] += 1;
    }

    /// Names outputs, keeps states and compiles.
    fn compile(mut self, outputs: u16) -> (Schedule, Vec<Start>, Vec<Recorded>, Vec<usize>) {
        for i in 0..self.buffers.len() {
            // Every history gets a new value.
            if matches!(self.kinds[i], Kind::History(_)) && self.versions[i] == 0 {
                let buffer = self.buffers[i].take().unwrap();
                let label = format!("last/stage{}", self.stages.len());
                let inputs = pass::Inputs {
                    source: self.buffers[0].as_ref().unwrap(),
                    target: buffer,
                };
                let made = self
                    .graph
                    .add::<pass::Pass>(&label, inputs, Dispatch::Elements(LEN));
                self.made(i, made.target);
                self.stages.push(Recorded {
                    label,
                    reads: vec![0],
                    writes: vec![i],
                    ..Default::default()
                });
            }
        }
        for i in 0..self.buffers.len() {
            let buffer = self.buffers[i].take().unwrap();
            if outputs >> (i % 16) & 1 == 1 && self.readable(i) {
                self.graph.output(&format!("out{i}"), &buffer);
                self.outputs.push(i);
            }
            if let Some(state) = self.states[i].take() {
                self.graph.keep(state, buffer);
            }
        }
        let start = |kind: &Kind| match kind {
            Kind::Input | Kind::State(_) => Start::Kept,
            Kind::Transient | Kind::Zeroed => Start::Anew,
            Kind::History(_) => Start::Rotated,
        };
        let mut starts: Vec<_> = self.kinds.iter().map(start).collect();
        starts.push(Start::Anew);
        let schedule = self.graph.compile(None).unwrap();
        (schedule, starts, self.stages, self.outputs)
    }
}

fn record(resources: &[u8], stages: &[(u8, [u8; 3])]) -> Frame {
    let mut frame = Frame::new(resources);
    for &(kind, picks) in stages {
        let _ = frame.stage(kind, picks);
    }
    frame
}

/// Which steps come before which, by the schedule's edges.
fn reachable(schedule: &Schedule) -> Vec<BTreeSet<usize>> {
    let mut before = vec![BTreeSet::new(); schedule.steps.len()];
    for later in 0..before.len() {
        for &(earlier, _, _) in schedule
            .edges
            .iter()
            .filter(|edge| edge.1 as usize == later)
        {
            let all = before[earlier as usize].clone();
            before[later].extend(all);
            before[later].insert(earlier as usize);
        }
    }
    before
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn schedules_agree_with_the_oracle(
        resources in prop::collection::vec(any::<u8>(), 1..9),
        stages in prop::collection::vec((any::<u8>(), any::<[u8; 3]>()), 0..24),
        outputs in any::<u16>(),
    ) {
        let (schedule, starts, stages, outputs) = record(&resources, &stages).compile(outputs);

        // What is live, in the order of insertion; the rest is named as removed.
        let live = oracle::traces(&starts, &stages, &outputs);
        let is_live = |(i, stage): (usize, &Recorded)| live.contains(&i).then(|| stage.label.clone());
        let is_dead = |(i, stage): (usize, &Recorded)| (!live.contains(&i)).then(|| stage.label.clone());
        let ran: Vec<_> = schedule.dispatches().map(|(_, step, _)| step.label.clone()).collect();
        prop_assert_eq!(ran, stages.iter().enumerate().filter_map(is_live).collect::<Vec<_>>());
        prop_assert_eq!(&schedule.removed, &stages.iter().enumerate().filter_map(is_dead).collect::<Vec<_>>());

        // Every conflict is settled, and no barrier could be left out.
        prop_assert_eq!(oracle::unsettled(&schedule), vec![]);
        for i in 0..schedule.steps.len() {
            let mut without = schedule.clone();
            if !std::mem::take(&mut without.steps[i].hazards).is_empty() {
                prop_assert!(!oracle::unsettled(&without).is_empty(), "the barrier before step {} is idle", i);
            }
        }

        // Hazards and edges are conflicts, each listed once, and edges lead from each step to all that it conflicts with.
        let conflicts = oracle::conflicts(&schedule);
        let mut listed = BTreeSet::new();
        for &(earlier, later, resource) in &schedule.edges {
            prop_assert!(listed.insert((earlier, later, resource)));
            prop_assert!(conflicts.contains(&(earlier as usize, later as usize, resource)));
        }
        let before = reachable(&schedule);
        for &(earlier, later, _) in &conflicts {
            prop_assert!(before[later].contains(&earlier), "{} -> {}", earlier, later);
        }
        for (i, step) in schedule.steps.iter().enumerate() {
            let mut listed = BTreeSet::new();
            for hazard in &step.hazards {
                prop_assert!(listed.insert((hazard.resource, hazard.after)));
                prop_assert!(conflicts.contains(&(hazard.after as usize, i, hazard.resource)));
                let does = |step: usize| {
                    let touches = oracle::touches(&schedule.steps[step]);
                    let here = touches.into_iter().filter(|touch| touch.0 == (hazard.resource, false));
                    here.fold((false, false), |all, touch| (all.0 || touch.1, all.1 || touch.2))
                };
                let kind = match (does(hazard.after as usize), does(i)) {
                    ((_, true), (true, _)) => HazardKind::ReadAfterWrite,
                    ((_, true), (false, _)) => HazardKind::WriteAfterWrite,
                    ((_, false), _) => HazardKind::WriteAfterRead,
                };
                prop_assert_eq!(hazard.kind, kind);
            }
        }

        // Zeroed resources, and only they, are cleared: once, and with nothing but clears between that and the first use.
        for (id, resource) in schedule.resources.iter().enumerate() {
            let clears = |i: &usize| matches!(schedule.steps[*i].action, Action::Clear(r) if r as usize == id);
            let touches =
                |i: &usize| oracle::touches(&schedule.steps[*i]).iter().any(|touch| touch.0.0 as usize == id);
            let steps = 0..schedule.steps.len();
            let cleared: Vec<_> = steps.clone().filter(clears).collect();
            let touched: Vec<_> = steps.filter(|i| touches(i) && !clears(i)).collect();
            match touched.first() {
                Some(&first) if resource.kind == Kind::Zeroed => {
                    prop_assert_eq!(cleared.len(), 1);
                    let between = &schedule.steps[cleared[0].min(first)..first];
                    prop_assert!(cleared[0] < first);
                    prop_assert!(between.iter().all(|step| matches!(step.action, Action::Clear(_))));
                }
                _ => prop_assert!(cleared.is_empty()),
            }
        }
    }

    #[test]
    fn compiling_is_reproducible(
        resources in prop::collection::vec(any::<u8>(), 1..9),
        stages in prop::collection::vec((any::<u8>(), any::<[u8; 3]>()), 0..24),
        outputs in any::<u16>(),
    ) {
        let first = record(&resources, &stages).compile(outputs).0;
        let second = record(&resources, &stages).compile(outputs).0;
        prop_assert_eq!(first.to_json().unwrap(), second.to_json().unwrap());
    }
}

/// `a` is written, read by two, and overwritten.
fn planted() -> Schedule {
    let mut g = Graph::new("planted");
    let source = g.input("source", LEN);
    let [a, b, c] = ["a", "b", "c"].map(|name| g.transient(name, LEN));
    let all = || Dispatch::Elements(LEN);
    let a = g
        .add::<pass::Pass>(
            "first",
            pass::Inputs {
                source: &source,
                target: a,
            },
            all(),
        )
        .target;
    let b = g
        .add::<pass::Pass>(
            "read",
            pass::Inputs {
                source: &a,
                target: b,
            },
            all(),
        )
        .target;
    let c = g
        .add::<pass::Pass>(
            "read again",
            pass::Inputs {
                source: &a,
                target: c,
            },
            all(),
        )
        .target;
    let a = g
        .add::<pass::Pass>(
            "second",
            pass::Inputs {
                source: &source,
                target: a,
            },
            all(),
        )
        .target;
    g.output("a", &a);
    g.output("b", &b);
    g.output("c", &c);
    g.compile(None).unwrap()
}

#[test]
fn the_oracle_finds_a_missing_barrier() {
    let schedule = planted();
    assert_eq!(barriers(&schedule), ".|.|");
    assert_eq!(oracle::unsettled(&schedule), []);
    let a = schedule.resource("a").unwrap();
    let without = |step: usize| {
        let mut schedule = planted();
        schedule.steps[step].hazards.clear();
        oracle::unsettled(&schedule)
    };
    assert_eq!(without(1), [(0, 1, a), (0, 2, a)]);
    assert_eq!(without(3), [(1, 3, a), (2, 3, a)]);
    assert_eq!(without(2), []);
}

#[test]
fn the_oracle_follows_traces_across_frames() {
    let stage = |reads: &[usize], reads_before: &[usize], writes: &[usize]| Recorded {
        label: String::new(),
        reads: reads.into(),
        reads_before: reads_before.into(),
        writes: writes.into(),
    };
    // Stage 0 reaches the output through two states against the order of the frame, stage 3 reaches nothing.
    let starts = [Start::Kept, Start::Rotated, Start::Anew, Start::Anew];
    let stages = [
        stage(&[0], &[], &[2]),
        stage(&[], &[1], &[0]),
        stage(&[], &[], &[1]),
        stage(&[2], &[], &[3]),
    ];
    assert_eq!(
        oracle::traces(&starts, &stages, &[2]),
        BTreeSet::from([0, 1, 2])
    );
    assert_eq!(
        oracle::traces(&starts, &stages, &[3]),
        BTreeSet::from([0, 1, 2, 3])
    );
    assert_eq!(oracle::traces(&starts, &stages, &[1]), BTreeSet::from([2]));
}
