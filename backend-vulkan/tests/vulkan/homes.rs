//! Transients that share memory.
use crate::imports::executable;
use crate::stages::*;
use crate::support::{prepare, read, upload, watched};
use gibs_graph::{Buffer, Dispatch, Executable, Graph};

fn doubled(g: &mut Graph, label: &str, source: &Buffer<u32>, len: u64) -> Buffer<u32> {
    let target_ = g.transient(label, len);
    let inputs = double::Inputs { source, target_ };
    // One workgroup, which no buffer here is too short for.
    let elements = Dispatch::Elements(source.len().min(64));
    g.add::<double::Double>(label, inputs, elements).target_
}

/// A chain of transients of all lengths, small behind large and large behind small, and a zeroed one that begins in
/// memory that was used before and ends inside of it.
fn chain(keep: bool) -> Graph {
    let mut g = Graph::new("chain");
    if keep {
        g.keep_transients();
    }
    let source = g.input("source", 64);
    let mut last = doubled(&mut g, "first", &source, 100);
    for (i, len) in [333, 64, 1000, 65, 999].into_iter().enumerate() {
        last = doubled(&mut g, &format!("link {i}"), &last, len);
        if i == 2 {
            // Lives across links: its memory is none of theirs.
            let counter = g.zeroed("counter", 64);
            let inputs = count::Inputs {
                source: &source,
                counter,
            };
            let counter = g
                .add::<count::Count>("count", inputs, Dispatch::Elements(64))
                .counter;
            let again = doubled(&mut g, "counted", &counter, 64);
            g.output("counted", &again);
        }
    }
    // Its exact length, in memory that is longer.
    let target_ = g.transient("length", 1);
    let inputs = length::Inputs {
        source: &last,
        target_,
    };
    let length = g
        .add::<length::Length>("length", inputs, Dispatch::Elements(1))
        .target_;
    g.output("length", &length);
    let sums = g.transient("sums", 16);
    let inputs = sums::Inputs {
        source: &last,
        target_: sums,
    };
    let sums = g
        .add::<sums::Sums>("sums", inputs, Dispatch::Elements(64))
        .target_;
    g.output("sums", &sums);
    g
}

#[test]
fn sharing_memory_changes_nothing() {
    watched(|backend| {
        let mut shared = prepare(backend, chain(false));
        let mut apart = prepare(backend, chain(true));
        assert!(shared.schedule().shared_bytes() > 0);
        assert_eq!(apart.schedule().shared_bytes(), 0);
        for frame in 0..3u32 {
            let source: Vec<u32> = (0..64).map(|i| i * 7 + frame).collect();
            for e in [&mut shared, &mut apart] {
                upload(&mut **e, "source", &source);
                e.run().unwrap();
            }
            let sum: u32 = source.iter().sum();
            for output in ["counted", "length", "sums"] {
                assert_eq!(read(&mut *shared, output), read(&mut *apart, output));
            }
            let counted = read(&mut *shared, "counted");
            assert_eq!(counted[0], 2 * sum);
            assert!(counted[1..].iter().all(|n| *n == 0));
            assert_eq!(read(&mut *shared, "length"), [999]);
            assert_eq!(read(&mut *shared, "sums")[0], 64 * sum);
        }
    });
}

/// What shares memory is one buffer, as large as the largest; the rest has none of its own.
#[test]
fn homes_are_the_only_buffers() {
    watched(|backend| {
        let e = executable(backend, chain(false));
        let schedule = e.schedule().clone();
        for (id, resource) in (0..).zip(&schedule.resources) {
            assert!(e.buffer(id).is_some());
            assert_eq!(e.buffer(id), e.buffer(resource.home), "{}", resource.key);
        }
    });
}
