//! What outlives a frame.
use crate::stages::*;
use crate::support::{prepare, read, upload, watched};
use gibs_graph::{Dispatch, Graph, Initial};

/// A state that grows by its source every frame, and a history that advances.
pub fn counting(len: u64) -> Graph {
    let mut g = Graph::new("counting");
    let source = g.input("source", len);
    let (state, total) = g.state("total", len, Initial::Sequence);
    let inputs = accumulate::Inputs {
        source: &source,
        total,
    };
    let out = g.add::<accumulate::Accumulate>("accumulate", inputs, Dispatch::Elements(len));
    g.output("total", &out.total);
    g.keep(state, out.total);
    let (state, before, now) = g.history("past", len, Initial::fill(3u32));
    let inputs = advance::Inputs {
        before: &before,
        now,
    };
    let out = g.add::<advance::Advance>("advance", inputs, Dispatch::Elements(len));
    g.output("past", &out.now);
    g.keep(state, out.now);
    g
}

#[test]
fn state_is_kept_from_frame_to_frame() {
    watched(|backend| {
        let mut e = prepare(backend, counting(100));
        assert_eq!(
            read(&mut *e, "total"),
            (0..100).collect::<Vec<u32>>(),
            "the initial value"
        );
        upload(&mut *e, "source", &[5u32; 100]);
        for _ in 0..7 {
            e.run().unwrap();
        }
        assert_eq!(read(&mut *e, "total"), (35..135).collect::<Vec<u32>>());
    });
}

#[test]
fn a_history_rotates() {
    watched(|backend| {
        let mut e = prepare(backend, counting(100));
        let mut expected = 3;
        assert_eq!(read(&mut *e, "past"), [expected; 100], "the initial value");
        for frame in 0..5 {
            e.run().unwrap();
            expected = 2 * expected + 1;
            assert_eq!(read(&mut *e, "past"), [expected; 100], "frame {frame}");
        }
        upload(&mut *e, "past", &[10u32; 100]);
        assert_eq!(read(&mut *e, "past"), [10; 100]);
        e.run().unwrap();
        assert_eq!(
            read(&mut *e, "past"),
            [21; 100],
            "the next frame starts from the upload"
        );
    });
}

#[test]
fn reset_goes_back_to_the_initial_values() {
    watched(|backend| {
        let mut e = prepare(backend, counting(100));
        upload(&mut *e, "source", &[5u32; 100]);
        for frames in 1..4 {
            for _ in 0..frames {
                e.run().unwrap();
            }
            e.reset().unwrap();
            assert_eq!(read(&mut *e, "total"), (0..100).collect::<Vec<u32>>());
            assert_eq!(read(&mut *e, "past"), [3; 100]);
            assert_eq!(read(&mut *e, "source"), [5; 100], "inputs stay");
            e.run().unwrap();
            assert_eq!(read(&mut *e, "past"), [7; 100]);
            e.reset().unwrap();
        }
    });
}

/// A value that no single word repeats.
#[test]
fn an_initial_element_of_several_words_is_repeated() {
    watched(|backend| {
        let mut g = Graph::new("pairs");
        let (state, pairs) = g.state::<[u32; 2]>("pairs", 3, Initial::fill([1u32, 2]));
        g.output("pairs", &pairs);
        g.keep(state, pairs);
        let mut e = prepare(backend, g);
        e.run().unwrap();
        assert_eq!(read(&mut *e, "pairs"), [1, 2, 1, 2, 1, 2]);
    });
}
