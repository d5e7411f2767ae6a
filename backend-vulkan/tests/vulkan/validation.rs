//! The watch itself: it sees what it should, and barriers are where they must be.
use crate::stages::*;
use crate::support::{prepare, read, start, upload, watched};
use gibs_graph::{Backend, Dispatch, DispatchArgs, Graph};
use std::sync::Arc;

/// Dependencies of every kind, several of which one barrier settles: the uniform and the sizes are made first, read
/// last, and the barrier between stands there for another resource.
fn tangled() -> Graph {
    let mut g = Graph::new("tangled");
    let source = g.input("source", 64);
    let line = g.transient("line", 1);
    let inputs = make_line::Inputs {
        source: &source,
        line,
    };
    let line = g
        .add::<make_line::MakeLine>("make_line", inputs, Dispatch::Elements(1))
        .line;
    let args = g.transient::<DispatchArgs>("args", 1);
    let inputs = plan::Inputs {
        source: &source,
        args,
    };
    let args = g
        .add::<plan::Plan>("plan", inputs, Dispatch::Elements(1))
        .args;
    let first = g.transient("first", 64);
    let inputs = double::Inputs {
        source: &source,
        target_: first,
    };
    let first = g
        .add::<double::Double>("first", inputs, Dispatch::Elements(64))
        .target_;
    let second = g.transient("second", 64);
    let inputs = double::Inputs {
        source: &first,
        target_: second,
    };
    let second = g
        .add::<double::Double>("second", inputs, Dispatch::Elements(64))
        .target_;
    let third = g.transient("third", 64);
    let inputs = line::Inputs {
        line: &line,
        source: &first,
        target_: third,
    };
    let third = g
        .add::<line::Affine>("line", inputs, Dispatch::Elements(64))
        .target_;
    let counter = g.zeroed("counter", 1);
    let inputs = tally::Inputs {
        step_: &second,
        counter,
    };
    let counter = g
        .add::<tally::Tally>("tally", inputs, Dispatch::Indirect(&args))
        .counter;
    // Writes what was read: an order is needed, nothing more.
    let inputs = double::Inputs {
        source: &third,
        target_: first,
    };
    let again = g
        .add::<double::Double>("again", inputs, Dispatch::Elements(64))
        .target_;
    g.output("counter", &counter);
    g.output("again", &again);
    g
}

#[test]
fn one_barrier_settles_several_hazards() {
    watched(|backend| {
        let mut e = prepare(backend, tangled());
        let barriers = e
            .schedule()
            .steps
            .iter()
            .filter(|s| !s.hazards.is_empty())
            .count();
        let edges = e.schedule().edges.len();
        assert!(barriers < edges, "{}", e.schedule().to_text());
        let source: Vec<u32> = (2..66).collect();
        upload(&mut *e, "source", &source);
        for _ in 0..3 {
            e.run().unwrap();
        }
        // line: 2 x + 3; first: 2 x; again: 2 (2 (2 x) + 3); tally: 2 * 3 * 4 groups of 4 * 2.
        let expected: Vec<u32> = source.iter().map(|x| 2 * (4 * x + 3)).collect();
        assert_eq!(read(&mut *e, "first"), expected);
        assert_eq!(read(&mut *e, "counter"), [24 * 8]);
    });
}

/// The positive control: with its hazards taken out, the same schedule must be reported.
#[test]
fn a_missing_barrier_is_reported() {
    let Some(backend) = start() else { return };
    let mut schedule = tangled().compile(None).unwrap();
    let hazards: Vec<_> = schedule
        .steps
        .iter_mut()
        .map(|step| std::mem::take(&mut step.hazards))
        .collect();
    assert!(hazards.iter().flatten().count() > 0);
    let mut e = backend.prepare(Arc::new(schedule)).unwrap();
    assert_eq!(backend.validation_messages(), Vec::<String>::new());
    e.run().unwrap();
    e.wait().unwrap();
    let messages = backend.validation_messages();
    assert!(
        messages
            .iter()
            .any(|m| m.contains("SYNC-HAZARD-READ-AFTER-WRITE")),
        "{messages:?}"
    );
}

/// Each barrier alone is needed: taking out any one is reported.
#[test]
fn no_barrier_is_superfluous() {
    let Some(backend) = start() else { return };
    let steps = tangled().compile(None).unwrap().steps;
    let guarded = (0..steps.len()).filter(|&i| !steps[i].hazards.is_empty());
    for step in guarded {
        let mut schedule = tangled().compile(None).unwrap();
        schedule.steps[step].hazards.clear();
        let before = backend.validation_messages().len();
        let mut e = backend.prepare(Arc::new(schedule)).unwrap();
        e.run().unwrap();
        e.wait().unwrap();
        let found = backend.validation_messages().len() - before;
        assert!(
            found > 0,
            "without the barrier before `{}`",
            steps[step].label
        );
    }
}
