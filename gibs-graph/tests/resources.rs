//! Resources of a schedule: usage, size, adoption, first content, and the size of dispatches.
mod common;

use common::*;
use gibs_graph::{Dispatch, Graph, Initial, Kind, MAX_GROUPS, Schedule, Usage, groups_for};

#[test]
fn usage_is_what_live_stages_do() {
    let mut g = Graph::new("test");
    let source = g.input::<u32>("source", LEN);
    let tree = g.input("tree", LEN);
    let host_twin = g.input("read by both", LEN);
    let args = g.input("args", 1);
    let target = g.zeroed("target", LEN);
    let inputs = batched::Inputs {
        batch: &args,
        target,
    };
    let target = g
        .add::<batched::Batched>("batched", inputs, Dispatch::Indirect(&args))
        .target;
    let target = g
        .add::<hosted::Hosted>(
            "trace",
            hosted::Inputs {
                extra: &tree,
                target,
            },
            all(),
        )
        .target;
    let target = g
        .add::<hosted::Hosted>(
            "both",
            hosted::Inputs {
                extra: &host_twin,
                target,
            },
            all(),
        )
        .target;
    let target = pass_on(&mut g, "copy", &host_twin, target);
    g.output("target", &target);
    g.output("source", &source);
    let schedule = compiled(g);
    let usage = |key: &str| schedule.resources[schedule.resource(key).unwrap() as usize].usage;
    let flags = |key: &str| {
        let Usage {
            uniform,
            storage,
            indirect,
            image,
            host,
            ..
        } = usage(key);
        [uniform, storage, indirect, image, host]
    };
    assert_eq!(flags("args"), [true, false, true, false, false]);
    assert_eq!(flags("tree"), [false, false, false, false, true]);
    assert_eq!(flags("read by both"), [false, true, false, false, true]);
    assert_eq!(flags("target"), [false, true, false, false, false]);
    // An output that no stage touches is there all the same.
    assert_eq!(flags("source"), [false, true, false, false, false]);
    assert!(!usage("tree").on_device());
    assert!(
        ["args", "read by both", "target"]
            .iter()
            .all(|key| usage(key).on_device())
    );
    // Arguments of a dispatch take 32 bytes.
    assert_eq!(schedule.bytes(false), 32 + 3 * 4 * LEN);
    assert_eq!(schedule.bytes(true), 32 + 4 * 4 * LEN);
}

#[test]
fn a_history_counts_twice_and_nothing_overflows() {
    let mut g = Graph::new("test");
    let (state, before, now) = g.history::<u32>("past", LEN, Initial::Zero);
    let now = g
        .add::<recall::Recall>(
            "advance",
            recall::Inputs {
                before: &before,
                target: now,
            },
            all(),
        )
        .target;
    g.output("now", &now);
    g.keep(state, now);
    let schedule = compiled(g);
    assert_eq!(schedule.resources[0].bytes, 4 * LEN);
    assert_eq!(schedule.bytes(false), 2 * 4 * LEN);

    let mut g = Graph::new("test");
    let huge = g.input::<[u32; 4]>("huge", u64::MAX);
    let other = g.input::<[u32; 4]>("other", u64::MAX);
    g.output("huge", &huge);
    g.output("other", &other);
    let schedule = compiled(g);
    assert_eq!(schedule.resources[0].bytes, u64::MAX);
    assert_eq!(schedule.bytes(false), u64::MAX);
}

#[test]
fn a_buffer_has_an_element_at_least() {
    let mut g = Graph::new("test");
    let empty = g.input::<u32>("empty", 0);
    assert_eq!((empty.len(), empty.is_empty()), (1, false));
    g.output("empty", &empty);
    assert_eq!(compiled(g).resources[0].bytes, 4);
}

/// A schedule with an input, a transient, a state, and a history.
fn persistent(key: &str, len: u64, initial: Initial) -> Schedule {
    let mut g = Graph::new("test");
    let source = g.input("source", LEN);
    let scratch = g.transient("scratch", LEN);
    let scratch = pass_on(&mut g, "scratch", &source, scratch);
    let (state, value) = g.state(key, len, initial);
    let value = pass_on(&mut g, "change", &scratch, value);
    let (past_state, before, now) = g.history("past", LEN, Initial::Zero);
    let now = g
        .add::<recall::Recall>(
            "advance",
            recall::Inputs {
                before: &before,
                target: now,
            },
            all(),
        )
        .target;
    g.output("value", &value);
    g.output("now", &now);
    g.keep(state, value);
    g.keep(past_state, now);
    compiled(g)
}

#[test]
fn persistent_resources_that_agree_are_adopted() {
    let old = persistent("age", LEN, Initial::Zero);
    let adopted = |new: &Schedule| {
        let pairs = new.adoptions(&old);
        let agree = |&(from, to): &(u32, u32)| {
            let (from, to) = (&old.resources[from as usize], &new.resources[to as usize]);
            assert_eq!((&from.key, &from.kind), (&to.key, &to.kind));
            assert!(from.len <= to.len);
            to.key.clone()
        };
        pairs.iter().map(agree).collect::<Vec<_>>()
    };
    assert_eq!(adopted(&old), ["source", "age", "past"]);
    assert_eq!(
        adopted(&persistent("years", LEN, Initial::Zero)),
        ["source", "past"]
    );
    assert_eq!(
        adopted(&persistent("age", LEN + 1, Initial::Zero)),
        ["source", "age", "past"],
        "a state may grow"
    );
    assert_eq!(
        adopted(&persistent("age", LEN - 1, Initial::Zero)),
        ["source", "past"]
    );
    assert_eq!(
        adopted(&persistent("age", LEN, Initial::Sequence)),
        ["source", "past"]
    );

    // An input that grows is written anew.
    let inputs = |len| {
        let mut g = Graph::new("test");
        let source = g.input::<u32>("source", len);
        g.output("source", &source);
        compiled(g)
    };
    assert_eq!(inputs(LEN + 1).adoptions(&inputs(LEN)), []);

    // The same key, but of another type or another kind.
    let mut g = Graph::new("test");
    let source = g.input::<f32>("source", LEN);
    let age = g.input::<u32>("age", LEN);
    let past = g.zeroed::<u32>("past", LEN);
    g.output("source", &source);
    g.output("age", &age);
    g.output("past", &past);
    assert_eq!(adopted(&compiled(g)), Vec::<String>::new());
}

#[test]
fn initial_values() {
    let words = |initial: Initial, bytes| {
        let bytes = initial.bytes(bytes);
        bytes
            .chunks(4)
            .map(|word| u32::from_ne_bytes(word.try_into().unwrap()))
            .collect::<Vec<_>>()
    };
    assert_eq!(words(Initial::Zero, 8), [0, 0]);
    assert_eq!(words(Initial::Sequence, 16), [0, 1, 2, 3]);
    assert_eq!(words(Initial::fill([7_u32, 8]), 16), [7, 8, 7, 8]);
    let persists = [
        (Kind::Input, true),
        (Kind::Transient, false),
        (Kind::Zeroed, false),
        (Kind::State(Initial::Zero), true),
        (Kind::History(Initial::Zero), true),
    ];
    assert!(
        persists
            .iter()
            .all(|(kind, persists)| kind.persists() == *persists)
    );
}

#[test]
fn long_dispatches_are_folded_into_rows() {
    let most = u64::from(MAX_GROUPS);
    assert_eq!(groups_for(0, 64), [0, 1, 1]);
    assert_eq!(groups_for(1, 64), [1, 1, 1]);
    assert_eq!(groups_for(64, 64), [1, 1, 1]);
    assert_eq!(groups_for(65, 64), [2, 1, 1]);
    assert_eq!(groups_for(most * 64, 64), [MAX_GROUPS, 1, 1]);
    assert_eq!(groups_for(most * 64 + 1, 64), [MAX_GROUPS, 2, 1]);
    assert_eq!(groups_for(most * most, 1), [MAX_GROUPS, MAX_GROUPS, 1]);
    assert_eq!(
        groups_for(most * most + 1, 1),
        [MAX_GROUPS, MAX_GROUPS + 1, 1]
    );
    assert_eq!(groups_for(u64::MAX, 1), [MAX_GROUPS, u32::MAX, 1]);
    // No lanes counts as one.
    assert_eq!(groups_for(10, 0), [10, 1, 1]);
}

/// The workgroups of a folded dispatch own every index once, the ones too many own none.
#[test]
fn workgroups_of_a_folded_dispatch_cover_it() {
    let elements = 65_535 * 2 * 64 + 17;
    let count = groups_for(elements, 64);
    assert_eq!(count, [MAX_GROUPS, 3, 1]);
    let mut next = 0;
    for (y, x) in (0..count[1]).flat_map(|y| (0..count[0]).map(move |x| (y, x))) {
        let group = gibs_graph::Workgroup {
            id: [x, y, 0],
            count,
            size: [64, 1, 1],
        };
        let range = group.range(elements as u32);
        assert_eq!(range.start, next);
        next = range.end;
    }
    assert_eq!(next, elements as usize);
}
