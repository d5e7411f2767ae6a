//! What a step waits for, and what is cleared.
mod common;

use common::*;
use gibs_graph::{
    Access, Action, Dispatch, DispatchArgs, DispatchSize, Graph, HazardKind, Initial,
};

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
