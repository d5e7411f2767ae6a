//! Which stages compilation keeps.
mod common;

use common::*;
use gibs_graph::{Buffer, Graph, HazardKind, Initial, State};

/// States, with the buffers that hold them.
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
