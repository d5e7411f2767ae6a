//! Frames made of numbers, for random ones.
use super::oracle::{Recorded, Start};
use super::*;
use gibs_graph::{Buffer, Dispatch, DispatchArgs, Graph, Initial, Kind, Previous, Schedule, State};

/// A frame that is recorded twice: as a graph, and for the oracle.
pub struct Frame {
    pub graph: Graph,
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
    pub fn new(resources: &[u8]) -> Self {
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
    pub fn stage(&mut self, kind: u8, picks: [u8; 3]) -> Option<()> {
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
    pub fn compile(mut self, outputs: u16) -> (Schedule, Vec<Start>, Vec<Recorded>, Vec<usize>) {
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
            other => panic!("{other:?}"),
        };
        let mut starts: Vec<_> = self.kinds.iter().map(start).collect();
        starts.push(Start::Anew);
        let schedule = self.graph.compile(None).unwrap();
        (schedule, starts, self.stages, self.outputs)
    }
}

/// The frame that these numbers make; stages without resources for them are left out.
pub fn record(resources: &[u8], stages: &[(u8, [u8; 3])]) -> Frame {
    let mut frame = Frame::new(resources);
    for &(kind, picks) in stages {
        let _ = frame.stage(kind, picks);
    }
    frame
}
