//! The checking mode: write conflicts and the shuffled order.
mod common;

use common::*;
use gibs_backend_cpu::Options;
use gibs_graph::{BackendError, Dispatch, Graph};

fn options(threads: usize, checked: bool) -> Options {
    Options {
        threads: Some(threads),
        checked,
        scalar: false,
    }
}

fn overlapping(len: u64) -> Graph {
    let mut g = Graph::new("test");
    let source = g.input("source", len);
    let target = g.transient("target", len);
    let inputs = overlap::Inputs {
        source: &source,
        target,
    };
    let target = g
        .add::<overlap::Overlap>("draw/overlap", inputs, Dispatch::Elements(len))
        .target;
    g.output("target", &target);
    g
}

#[test]
fn two_workgroups_that_write_one_element_are_found() {
    for threads in [1, 2] {
        let mut exec = prepare_with(options(threads, true), overlapping(2 * LANES));
        // In every frame, not only in the first.
        for _ in 0..3 {
            let error = exec.run().unwrap_err();
            assert!(
                matches!(&error, BackendError::WriteConflict { offset, .. } if *offset == 4 * LANES)
            );
            let want = "stage `draw/overlap`, port `target`: the bytes at 256 were written twice";
            assert!(error.to_string().starts_with(want), "{error}");
        }
    }
    // Without checking nobody looks. (On one thread: the two writes are a race.)
    prepare_with(options(1, false), overlapping(2 * LANES))
        .run()
        .unwrap();
}

/// On a device two invocations would race for the element. What a stage reads as well, it may gather in.
#[test]
fn two_invocations_that_write_one_element_are_found() {
    let run = |read: bool| {
        let mut g = Graph::new("test");
        let source = g.input("source", LANES);
        let target = g.zeroed("target", LANES);
        let size = Dispatch::Elements(LANES);
        let target = match read {
            false => {
                let source = &source;
                let inputs = repeat::Inputs { source, target };
                g.add::<repeat::Repeat>("draw/repeat", inputs, size).target
            }
            true => {
                let source = &source;
                let inputs = add_up::Inputs { source, target };
                g.add::<add_up::AddUp>("draw/add_up", inputs, size).target
            }
        };
        g.output("target", &target);
        prepare_with(options(1, true), g).run()
    };
    let error = run(false).unwrap_err().to_string();
    assert!(
        error.contains("the bytes at 0 were written twice"),
        "{error}"
    );
    run(true).unwrap();
}

/// A kernel that leaves its buffers is an error that names the stage, on one thread and on several, and the executable
/// goes on afterwards.
#[test]
fn what_is_out_of_bounds_is_an_error() {
    const LEN: u64 = 10 * LANES;
    for checked in [true, false] {
        // Also on more threads than there are workgroups, most likely more than processors.
        for threads in [1, 2, 32] {
            let mut g = Graph::new("test");
            let source = g.input("source", LEN);
            let target = g.transient("target", LEN);
            let count = g.zeroed("count", 1);
            let inputs = beyond::Inputs {
                source: &source,
                target,
                count,
            };
            let out = g.add::<beyond::Beyond>("draw/beyond", inputs, Dispatch::Elements(LEN));
            g.output("target", &out.target);
            g.output("count", &out.count);
            let mut exec = prepare_with(options(threads, checked), g);
            let source = exec.schedule().resource("source").unwrap();
            for bad in [7_u32, 8, 9] {
                exec.upload(source, 4 * 333, &bad.to_ne_bytes()).unwrap();
                let error = exec.run().unwrap_err().to_string();
                assert!(error.contains("stage `draw/beyond`"), "{error}");
                assert!(
                    error.contains("index") && error.contains("640") || bad == 9,
                    "{error}"
                );
                exec.upload(source, 4 * 333, &[0; 4]).unwrap();
                exec.run().unwrap();
            }
        }
    }
}

/// Visits and turns of every workgroup.
fn visits(options: Options, groups: [u32; 3]) -> (Vec<u32>, Vec<u32>) {
    let total = u64::from(groups.iter().product::<u32>());
    let mut g = Graph::new("test");
    let source = g.input("source", 1);
    let visits = g.zeroed("visits", total);
    let turns = g.zeroed("turns", total);
    let next = g.zeroed("next", 1);
    let inputs = visit::Inputs {
        source: &source,
        visits,
        turns,
        next,
    };
    let made = g.add::<visit::Visit>("visit", inputs, Dispatch::Groups(groups));
    g.output("visits", &made.visits);
    g.output("turns", &made.turns);
    let mut exec = prepare_with(options, g);
    exec.run().unwrap();
    (read(&mut *exec, "visits"), read(&mut *exec, "turns"))
}

#[test]
fn every_workgroup_runs_exactly_once() {
    for groups in [
        [1, 1, 1],
        [2, 1, 1],
        [1, 1, 9],
        [7, 5, 3],
        [64, 64, 1],
        [100, 1, 17],
        [65_535, 2, 1],
    ] {
        for (threads, checked) in [(1, false), (2, false), (1, true), (2, true)] {
            let (visits, mut turns) = visits(options(threads, checked), groups);
            assert!(visits.iter().all(|&count| count == 1), "{groups:?}");
            turns.sort_unstable();
            assert!(
                turns.iter().copied().eq(1..=turns.len() as u32),
                "{groups:?}"
            );
        }
    }
}

#[test]
fn only_checking_shuffles() {
    let in_order: Vec<u32> = (1..=105).collect();
    assert_eq!(visits(options(1, false), [7, 5, 3]).1, in_order);
    let shuffled = visits(options(1, true), [7, 5, 3]).1;
    let moved = shuffled
        .iter()
        .zip(&in_order)
        .filter(|(a, b)| a != b)
        .count();
    assert!(moved > 100, "{moved} of 105 workgroups have another turn");
    // Failures can be repeated.
    assert_eq!(visits(options(1, true), [7, 5, 3]).1, shuffled);
}
