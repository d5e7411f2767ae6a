//! Graphs from random bytes: buffers of every kind, and stages that connect whatever fits.
use crate::graph_pool::Pool;
use crate::graph_stages::*;
use crate::graph_steps::{lower, mark, pack, plan, raise, turn, unpack};
use gibs_graph::glam::{UVec4, Vec4};
use gibs_graph::{Buffer, Dispatch, DispatchArgs, Graph, Rgba32Float, Uint};
use proptest::collection::vec;
use proptest::prelude::*;

/// What a graph is made of.
#[derive(Clone, Debug)]
pub struct Recipe {
    /// Kind and length of each buffer of numbers.
    pub buffers: Vec<(u8, u8)>,
    /// Stages: which, and what they take.
    pub stages: Vec<(u8, [u8; 4])>,
    /// Which last versions are outputs.
    pub outputs: u16,
    /// What the host writes.
    pub seed: u32,
}

pub fn recipes() -> impl Strategy<Value = Recipe> {
    let buffers = vec((any::<u8>(), any::<u8>()), 2..7);
    let stages = vec((any::<u8>(), any::<[u8; 4]>()), 1..14);
    (buffers, stages, any::<u16>(), any::<u32>()).prop_map(|(buffers, stages, outputs, seed)| {
        Recipe {
            buffers,
            stages,
            outputs,
            seed,
        }
    })
}

/// Records a graph.
pub fn record(recipe: &Recipe) -> Graph {
    let mut g = Graph::new("fuzz");
    let amount = g.input::<UVec4>("amount", 1);
    let ids = g.import_image::<Uint>("ids", [9, 5]);
    let mut shown = Some(g.export_image::<Rgba32Float>("shown", [9, 5]));
    let mut words = Pool::<u32>(Vec::new());
    // Something can always be read, something always be written, and something outlives the frame.
    for (i, &(kind, len)) in [(0, 70), (1, 33), (6, 100)]
        .iter()
        .chain(&recipe.buffers)
        .enumerate()
    {
        words.add(&mut g, format!("words{i}"), kind, 1 + u64::from(len) % 200);
    }
    let (mut waves, mut rows, mut args) = (
        Pool::<Vec4>(Vec::new()),
        Pool::<Row>(Vec::new()),
        Pool::<DispatchArgs>(Vec::new()),
    );
    waves.add(&mut g, "waves0".into(), 1, 65);
    waves.add(&mut g, "waves1".into(), 5, 20);
    rows.add(&mut g, "rows".into(), 2, 40);
    args.add(&mut g, "args".into(), 1, 1 + u64::from(recipe.outputs % 3));
    for (i, &(op, picks)) in recipe.stages.iter().enumerate() {
        let label = format!("fuzz/{i}");
        match op % 14 {
            11 => raise(&mut g, &label, picks, &words, &mut waves),
            12 => turn(&mut g, &label, picks, &mut waves),
            13 => lower(&mut g, &label, picks, &mut words, &waves),
            8 => pack(&mut g, &label, picks, &words, &mut rows),
            9 => unpack(&mut g, &label, picks, &mut words, &rows),
            5 => plan(&mut g, &label, picks, &words, &mut args),
            6 => mark(&mut g, &label, picks, &mut words, &args),
            10 => {
                if let (Some(source), Some(target)) = (words.source(picks[0], &[]), shown.take()) {
                    let inputs = show::Inputs {
                        source: words.read(source),
                        ids: &ids,
                        shown: target,
                    };
                    let made = g.add::<show::Show>(&label, inputs, Dispatch::Elements(45));
                    shown = Some(made.shown);
                }
            }
            op => numbers(&mut g, &label, op, picks, &mut words, &amount),
        }
    }
    finish(
        g,
        recipe,
        words,
        waves,
        rows,
        args,
        shown.filter(|_| recipe.stages.iter().any(|stage| stage.0 % 14 == 10)),
    )
}

/// Stages of nothing but numbers.
fn numbers(
    g: &mut Graph,
    label: &str,
    op: u8,
    [a, b, c, d]: [u8; 4],
    words: &mut Pool<u32>,
    amount: &Buffer<UVec4>,
) {
    let writer = match op {
        1 | 3 => words.changed(a, &[]),
        _ => words.target(a, &[]),
    };
    let Some(to) = writer else { return };
    let (Some(from), Some(other)) = (words.source(b, &[to]), words.source(c, &[to])) else {
        return;
    };
    let target = words.take(to);
    let len = Dispatch::Elements(target.len());
    match op {
        1 => {
            let made = g.add::<shift::Shift>(
                label,
                shift::Inputs {
                    amount,
                    total: target,
                },
                len,
            );
            words.put(to, made.total);
        }
        2 => {
            let history = words
                .find(b, |_, entry| entry.previous.is_some())
                .expect("one is always there");
            let before = words.0[history]
                .previous
                .as_ref()
                .expect("it was just found");
            let made = g.add::<age::Age>(
                label,
                age::Inputs {
                    before,
                    now: target,
                },
                len,
            );
            words.put(to, made.now);
        }
        3 => {
            let source = words.read(from);
            let count = Dispatch::Elements(source.len());
            let made = g.add::<count::Count>(
                label,
                count::Inputs {
                    source,
                    counts: target,
                },
                count,
            );
            words.put(to, made.counts);
        }
        4 => {
            let groups = Dispatch::Groups([target.len() as u32, 1, 1]);
            let made = g.add::<sums::Sums>(
                label,
                sums::Inputs {
                    source: words.read(from),
                    target_: target,
                },
                groups,
            );
            words.put(to, made.target_);
        }
        7 => {
            let notes = (d & 1 == 1)
                .then(|| words.target(d, &[to, from, other]))
                .flatten();
            let taken = notes.map(|i| words.take(i));
            let most = target.len().max(taken.as_ref().map_or(0, Buffer::len));
            let made = g.add::<choose::Choose>(
                label,
                choose::Inputs {
                    source: words.read(from),
                    extra: (d & 2 == 2).then(|| words.read(other)),
                    target_: target,
                    notes: taken,
                },
                Dispatch::Elements(most),
            );
            words.put(to, made.target_);
            if let (Some(i), Some(next)) = (notes, made.notes) {
                words.put(i, next);
            }
        }
        _ => {
            let inputs = mix::Inputs {
                a: words.read(from),
                b: words.read(other),
                target_: target,
            };
            let made = g.add::<mix::Mix>(label, inputs, len);
            words.put(to, made.target_);
        }
    }
}

fn finish(
    mut g: Graph,
    recipe: &Recipe,
    mut words: Pool<u32>,
    waves: Pool<Vec4>,
    rows: Pool<Row>,
    args: Pool<DispatchArgs>,
    shown: Option<gibs_graph::Image<Rgba32Float>>,
) -> Graph {
    // The value of a history for the next frame has to be made.
    for i in 0..words.0.len() {
        if words.0[i].previous.is_none() || words.0[i].ready {
            continue;
        }
        let now = words.take(i);
        let before = words.0[i].previous.as_ref().expect("it is a history");
        let len = Dispatch::Elements(now.len());
        let made = g.add::<age::Age>(&format!("fuzz/age{i}"), age::Inputs { before, now }, len);
        words.put(i, made.now);
    }
    let mut bits = recipe.outputs;
    let mut outputs = || {
        let bit = bits & 1 == 1;
        bits >>= 1;
        bit
    };
    let always = words
        .0
        .iter()
        .position(|entry| entry.previous.is_some())
        .expect("one is always there");
    g.output("always", words.read(always));
    words.finish(&mut g, &mut outputs);
    waves.finish(&mut g, &mut outputs);
    rows.finish(&mut g, &mut outputs);
    args.finish(&mut g, &mut outputs);
    if let Some(shown) = shown.filter(|_| outputs()) {
        g.output_image("shown", &shown);
    }
    g
}
