//! A frame makes no memory. In a program of its own, because the allocator is everybody's.
mod common;

use common::*;
use gibs_graph::{Dispatch, Graph, Initial};
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Counts calls that make or grow memory, of all threads.
struct Counting;

static CALLS: AtomicUsize = AtomicUsize::new(0);

// SAFETY: all is left to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        CALLS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller's promise.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, ptr: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise; `ptr` came from the system's allocator.
        unsafe { System.dealloc(ptr, layout) }
    }

    unsafe fn realloc(&self, ptr: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        CALLS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: as in `dealloc`.
        unsafe { System.realloc(ptr, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const LEN: u64 = 10_000;

/// Eleven steps: clears, dispatches with one to four ports, a state and a history.
fn graph() -> Graph {
    let all = || Dispatch::Elements(LEN);
    let mut g = Graph::new("test");
    let mut values = g.input("source", LEN);
    for i in 0..4 {
        let target = g.transient(&format!("doubled {i}"), LEN);
        let inputs = double::Inputs {
            source: &values,
            target,
        };
        values = g
            .add::<double::Double>(&format!("double {i}"), inputs, all())
            .target;
    }
    let counts = g.zeroed("counts", 10);
    let inputs = histogram::Inputs {
        source: &values,
        counts,
    };
    let counts = g.add::<histogram::Histogram>("count", inputs, all()).counts;
    let [visits, turns, next] = ["visits", "turns", "next"].map(|name| g.zeroed(name, LEN));
    let inputs = visit::Inputs {
        source: &values,
        visits,
        turns,
        next,
    };
    let visited = g.add::<visit::Visit>("visit", inputs, all());
    let (state, before, now) = g.history("age", LEN, Initial::Zero);
    let now = g
        .add::<advance::Advance>(
            "advance",
            advance::Inputs {
                before: &before,
                now,
            },
            all(),
        )
        .now;
    g.output("counts", &counts);
    g.output("visits", &visited.visits);
    g.output("age", &now);
    g.keep(state, now);
    g
}

/// The queue through which a thread from outside enters rayon's pool takes a block of memory for every 63 entries (a
/// constant of crossbeam-deque); a frame enters once. Nothing else allocates, so half as many again leave room for the
/// test's own threads only.
#[test]
fn frames_allocate_nothing() {
    const FRAMES: usize = 630;
    let mut exec = prepare(graph());
    let steps = exec.schedule().steps.len();
    assert!(steps >= 11, "{steps}");
    for measured in [false, true] {
        exec.measure(measured);
        for _ in 0..10 {
            exec.run().unwrap();
        }
        let before = CALLS.load(Ordering::Relaxed);
        for _ in 0..FRAMES {
            exec.run().unwrap();
        }
        let made = CALLS.load(Ordering::Relaxed) - before;
        assert!(
            made <= FRAMES / 63 * 3 / 2,
            "{made} allocations in {FRAMES} frames of {steps} steps"
        );
    }
}
