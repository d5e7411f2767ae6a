//! What compilation makes of small frames.
mod common;

use common::*;
use gibs_graph::{
    Access, Action, Buffer, Dispatch, DispatchArgs, DispatchSize, Graph, HazardKind, Initial, Kind,
    MAX_GROUPS, Schedule, State, Usage, groups_for,
};

const LEN: u64 = 100;

fn all() -> Dispatch<'static> {
    Dispatch::Elements(LEN)
}

fn pass_on(g: &mut Graph, label: &str, source: &Buffer<u32>, target: Buffer<u32>) -> Buffer<u32> {
    g.add::<pass::Pass>(label, pass::Inputs { source, target }, all())
        .target
}

fn compiled(g: Graph) -> Schedule {
    let schedule = g.compile(None).unwrap();
    assert_eq!(oracle::unsettled(&schedule), []);
    schedule
}

/// `count` states, with the buffers that hold them.
fn states<const COUNT: usize>(g: &mut Graph) -> [(State<u32>, Buffer<u32>); COUNT] {
    std::array::from_fn(|i| g.state(&format!("state{i}"), LEN, Initial::Zero))
}

#[test]
fn stages_that_no_output_needs_are_removed() {
    let mut g = Graph::new("test");
    let source = g.input("source", LEN);
    let [a, b, c] = ["a", "b", "c"].map(|name| g.transient(name, LEN));
    let a = pass_on(&mut g, "needed", &source, a);
    let b = pass_on(&mut g, "reads only", &a, b);
    let _ = pass_on(&mut g, "of the dead", &b, c);
    g.output("a", &a);
    let schedule = compiled(g);
    assert_eq!(labels(&schedule), ["needed"]);
    assert_eq!(schedule.removed, ["reads only", "of the dead"]);
    // What only dead stages touch is not allocated.
    assert_eq!(schedule.resource("a"), schedule.output("a"));
    assert_eq!(schedule.resource("b"), None);
    assert_eq!(schedule.output("b"), None);
}

#[test]
fn a_state_that_only_its_own_stage_sees_is_dead() {
    let mut g = Graph::new("test");
    let source = g.input("source", LEN);
    let [(state, value)] = states(&mut g);
    let value = g
        .add::<tally::Tally>(
            "count",
            tally::Inputs {
                source: &source,
                target: value,
            },
            all(),
        )
        .target;
    g.keep(state, value);
    let schedule = compiled(g);
    assert_eq!(schedule.steps.len(), 0);
    assert_eq!(schedule.removed, ["count"]);
}

/// The stage that changes a state comes after the one that reads what the frame before left.
#[test]
fn a_state_that_a_live_stage_reads_lives() {
    let mut g = Graph::new("test");
    let source = g.input("source", LEN);
    let [(state, value)] = states(&mut g);
    let seen = g.transient("seen", LEN);
    let seen = pass_on(&mut g, "look", &value, seen);
    let value = pass_on(&mut g, "change", &source, value);
    g.output("seen", &seen);
    g.keep(state, value);
    assert_eq!(labels(&compiled(g)), ["look", "change"]);
}

/// Each state is copied to the one before it, against the order of the frame: what reaches the output takes as many
/// frames as there are states.
#[test]
fn liveness_crosses_as_many_frames_as_it_takes() {
    let mut g = Graph::new("test");
    let source = g.input("source", LEN);
    let [(s0, v0), (s1, v1), (s2, v2), (s3, v3)] = states(&mut g);
    let seen = g.transient("seen", LEN);
    let seen = pass_on(&mut g, "look", &v0, seen);
    let v0 = pass_on(&mut g, "one to zero", &v1, v0);
    let v1 = pass_on(&mut g, "two to one", &v2, v1);
    let v2 = pass_on(&mut g, "source to two", &source, v2);
    let v3 = pass_on(&mut g, "two to three", &v2, v3);
    g.output("seen", &seen);
    for (state, value) in [(s0, v0), (s1, v1), (s2, v2), (s3, v3)] {
        g.keep(state, value);
    }
    let schedule = compiled(g);
    assert_eq!(
        labels(&schedule),
        ["look", "one to zero", "two to one", "source to two"]
    );
    assert_eq!(schedule.removed, ["two to three"]);
}

#[test]
fn a_chain_of_partial_writers_lives() {
    let mut g = Graph::new("test");
    let source = g.input("source", LEN);
    let [(state, value)] = states(&mut g);
    let seen = g.transient("seen", LEN);
    let value = pass_on(&mut g, "first half", &source, value);
    let value = pass_on(&mut g, "second half", &source, value);
    // The reader names the second version only.
    let seen = pass_on(&mut g, "look", &value, seen);
    let value = pass_on(&mut g, "rest", &source, value);
    g.output("seen", &seen);
    g.keep(state, value);
    // The stage after the reader may leave what the next frame reads.
    let schedule = compiled(g);
    assert_eq!(
        labels(&schedule),
        ["first half", "second half", "look", "rest"]
    );
    assert_eq!(
        step(&schedule, "second half").1.hazards[0].kind,
        HazardKind::WriteAfterWrite
    );
}

/// Within a frame nobody sees what is written after the last read.
#[test]
fn writes_after_the_last_read_of_a_transient_are_dead() {
    let mut g = Graph::new("test");
    let source = g.input("source", LEN);
    let [a, b] = ["a", "b"].map(|name| g.transient(name, LEN));
    let a = pass_on(&mut g, "first", &source, a);
    let b = pass_on(&mut g, "look", &a, b);
    let _ = pass_on(&mut g, "late", &source, a);
    g.output("b", &b);
    assert_eq!(labels(&compiled(g)), ["first", "look"]);
}

#[test]
fn a_history_is_read_beside_being_written() {
    let mut g = Graph::new("test");
    let (state, before, now) = g.history::<u32>("past", LEN, Initial::Zero);
    assert_eq!((before.len(), now.len()), (LEN, LEN));
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
    let seen = g.transient("seen", LEN);
    let seen = g
        .add::<recall::Recall>(
            "look",
            recall::Inputs {
                before: &before,
                target: seen,
            },
            all(),
        )
        .target;
    g.output("seen", &seen);
    g.keep(state, now);
    let schedule = compiled(g);
    assert_eq!(labels(&schedule), ["advance", "look"]);
    // Two allocations, so nothing has to wait.
    assert_eq!(barriers(&schedule), "..");
    assert_eq!(schedule.edges, []);
    let (_, _, dispatch) = schedule.dispatches().next().unwrap();
    assert_eq!(
        dispatch
            .bindings
            .iter()
            .map(|b| b.access)
            .collect::<Vec<_>>(),
        [Access::Previous, Access::Write]
    );
    assert_eq!(dispatch.bindings[0].resource, dispatch.bindings[1].resource);
}

#[test]
fn only_who_conflicts_waits() {
    let mut g = Graph::new("test");
    let source = g.input("source", LEN);
    let [a, b, c] = ["a", "b", "c"].map(|name| g.transient(name, LEN));
    let a = pass_on(&mut g, "a", &source, a);
    let b = pass_on(&mut g, "b", &source, b);
    let c = pass_on(&mut g, "c", &a, c);
    let [d, e] = ["d", "e"].map(|name| g.transient(name, LEN));
    // Behind the barrier before `c`, so `b` needs no other one.
    let d = pass_on(&mut g, "d", &b, d);
    let e = pass_on(&mut g, "e", &d, e);
    for (name, buffer) in [("c", &c), ("e", &e)] {
        g.output(name, buffer);
    }
    let schedule = compiled(g);
    assert_eq!(labels(&schedule), ["a", "b", "c", "d", "e"]);
    assert_eq!(barriers(&schedule), "..|.|");
    let [a, b, d] = ["a", "b", "d"].map(|key| schedule.resource(key).unwrap());
    assert_eq!(schedule.edges, [(0, 2, a), (1, 3, b), (3, 4, d)]);
}

#[test]
fn hazards_say_what_meets_what() {
    let mut g = Graph::new("test");
    let source = g.input("source", LEN);
    let [a, b] = ["a", "b"].map(|name| g.transient(name, LEN));
    let a = pass_on(&mut g, "write", &source, a);
    let b = pass_on(&mut g, "read", &a, b);
    let a = pass_on(&mut g, "overwrite", &source, a);
    let a = pass_on(&mut g, "overwrite again", &source, a);
    let inputs = merge::Inputs {
        first: &b,
        second: &b,
        target: a,
    };
    let a = g.add::<merge::Merge>("change", inputs, all()).target;
    g.output("a", &a);
    g.output("b", &b);
    let schedule = compiled(g);
    let kinds = |label| {
        step(&schedule, label)
            .1
            .hazards
            .iter()
            .map(|h| (h.after, h.kind))
            .collect::<Vec<_>>()
    };
    assert_eq!(kinds("write"), []);
    assert_eq!(kinds("read"), [(0, HazardKind::ReadAfterWrite)]);
    // The barrier before `read` settles `write` already.
    assert_eq!(kinds("overwrite"), [(1, HazardKind::WriteAfterRead)]);
    assert_eq!(kinds("overwrite again"), [(2, HazardKind::WriteAfterWrite)]);
    assert_eq!(kinds("change"), [(3, HazardKind::ReadAfterWrite)]);
    // `b` goes to two ports of one stage, and is one dependency.
    let b = schedule.resource("b").unwrap();
    assert_eq!(schedule.edges.iter().filter(|edge| edge.2 == b).count(), 1);
}

#[test]
fn clears_come_right_before_the_first_use() {
    let mut g = Graph::new("test");
    let source = g.input("source", LEN);
    let [a, b, unused] = ["a", "b", "unused"].map(|name| g.zeroed(name, LEN));
    let early = g.transient("early", LEN);
    let early = pass_on(&mut g, "early", &source, early);
    let b = g
        .add::<tally::Tally>(
            "first use",
            tally::Inputs {
                source: &a,
                target: b,
            },
            all(),
        )
        .target;
    let b = g
        .add::<tally::Tally>(
            "second use",
            tally::Inputs {
                source: &a,
                target: b,
            },
            all(),
        )
        .target;
    let _ = g.add::<tally::Tally>(
        "dead",
        tally::Inputs {
            source: &b,
            target: unused,
        },
        all(),
    );
    g.output("b", &b);
    g.output("early", &early);
    let schedule = compiled(g);
    assert_eq!(
        labels(&schedule),
        ["early", "clear a", "clear b", "first use", "second use"]
    );
    assert_eq!(barriers(&schedule), "...||");
    assert!(
        matches!(schedule.steps[1].action, Action::Clear(r) if Some(r) == schedule.resource("a"))
    );
    assert_eq!(schedule.steps[1].group(), "");
}

#[test]
fn indirect_sizes_are_waited_for() {
    let mut g = Graph::new("test");
    let source = g.input("source", LEN);
    let args = g.transient("args", 1);
    let target = g.transient("target", LEN);
    let args = g
        .add::<sizes::Sizes>(
            "count",
            sizes::Inputs {
                source: &source,
                args,
            },
            Dispatch::Groups([1; 3]),
        )
        .args;
    let inputs = pass::Inputs {
        source: &source,
        target,
    };
    let target = g
        .add::<pass::Pass>("fill", inputs, Dispatch::Indirect(&args))
        .target;
    // Bound and read as sizes: one dependency.
    let inputs = batched::Inputs {
        batch: &args,
        target,
    };
    let target = g
        .add::<batched::Batched>("change", inputs, Dispatch::Indirect(&args))
        .target;
    let args = g
        .add::<sizes::Sizes>(
            "count again",
            sizes::Inputs {
                source: &source,
                args,
            },
            Dispatch::Groups([1; 3]),
        )
        .args;
    g.output("target", &target);
    g.output("args", &args);
    let schedule = compiled(g);
    let [args, target] = ["args", "target"].map(|key| schedule.resource(key).unwrap());
    assert_eq!(barriers(&schedule), ".|||");
    assert_eq!(
        schedule.edges,
        [
            (0, 1, args),
            (0, 2, args),
            (1, 2, target),
            (0, 3, args),
            (1, 3, args),
            (2, 3, args)
        ]
    );
    let (_, _, dispatch) = schedule.dispatches().nth(1).unwrap();
    assert_eq!(dispatch.size, DispatchSize::Indirect(args));
    assert!(dispatch.bindings.iter().all(|b| b.resource != args));
    assert_eq!(
        step(&schedule, "fill").1.touches().last(),
        Some(&(args, Access::Indirect))
    );
}

#[test]
fn sizes_that_nobody_wrote_are_cleared() {
    let mut g = Graph::new("test");
    let source = g.input("source", LEN);
    let args = g.zeroed::<DispatchArgs>("args", 1);
    let target = g.transient("target", LEN);
    let inputs = pass::Inputs {
        source: &source,
        target,
    };
    let target = g
        .add::<pass::Pass>("fill", inputs, Dispatch::Indirect(&args))
        .target;
    g.output("target", &target);
    let schedule = compiled(g);
    assert_eq!(labels(&schedule), ["clear args", "fill"]);
    assert_eq!(barriers(&schedule), ".|");
}

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
    let none = Usage::default();
    assert_eq!(
        usage("args"),
        Usage {
            uniform: true,
            indirect: true,
            ..none
        }
    );
    assert_eq!(usage("tree"), Usage { host: true, ..none });
    assert_eq!(
        usage("read by both"),
        Usage {
            host: true,
            storage: true,
            ..none
        }
    );
    assert_eq!(
        usage("target"),
        Usage {
            storage: true,
            ..none
        }
    );
    // An output that no stage touches is there all the same.
    assert_eq!(
        usage("source"),
        Usage {
            storage: true,
            ..none
        }
    );
    assert!(!usage("tree").on_device());
    assert!(
        ["args", "read by both", "target"]
            .iter()
            .all(|key| usage(key).on_device())
    );
    assert_eq!(schedule.bytes(false), 16 + 3 * 4 * LEN);
    assert_eq!(schedule.bytes(true), 16 + 4 * 4 * LEN);
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
            assert_eq!(
                (&from.key, &from.kind, from.len),
                (&to.key, &to.kind, to.len)
            );
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
        ["source", "past"]
    );
    assert_eq!(
        adopted(&persistent("age", LEN, Initial::Sequence)),
        ["source", "past"]
    );

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
