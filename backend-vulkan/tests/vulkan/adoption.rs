//! A new schedule takes over the state of an old one.
use crate::stages::*;
use crate::state::counting;
use crate::support::{compile, prepare, read, start, upload, watched};
use gibs_graph::{Dispatch, Graph, Initial};

/// [`counting`] with a stage more in front, so that the same resources have other numbers.
fn counting_and_doubling(len: u64) -> Graph {
    let mut g = counting(len);
    let fresh = g.input("fresh", len);
    let target_ = g.transient("target", len);
    let inputs = double::Inputs {
        source: &fresh,
        target_,
    };
    let out = g.add::<double::Double>("double", inputs, Dispatch::Elements(len));
    g.output("target", &out.target_);
    g
}

#[test]
fn state_carries_over() {
    watched(|backend| {
        // An even and an odd number of frames: the history is in either of its allocations.
        for frames in [2, 3] {
            let mut e = prepare(backend, counting(10));
            upload(&mut *e, "source", &[1u32; 10]);
            let mut past = 3;
            for _ in 0..frames {
                e.run().unwrap();
                past = 2 * past + 1;
            }
            // Not yet submitted when the new executable takes over.
            upload(&mut *e, "source", &[100u32; 10]);
            e.adopt(compile(counting_and_doubling(10))).unwrap();
            assert_eq!(read(&mut *e, "past"), [past; 10]);
            assert_eq!(
                read(&mut *e, "total"),
                (frames..frames + 10).collect::<Vec<u32>>()
            );
            assert_eq!(
                read(&mut *e, "fresh"),
                [0; 10],
                "what is new starts at zero"
            );
            e.run().unwrap();
            e.run().unwrap();
            assert_eq!(read(&mut *e, "past"), [4 * past + 3; 10]);
            assert_eq!(
                read(&mut *e, "total"),
                (frames + 200..frames + 210).collect::<Vec<u32>>()
            );
        }
    });
}

/// What is longer goes on at its front, a history with both of its values; what is shorter starts anew.
#[test]
fn what_grows_keeps_what_it_held() {
    watched(|backend| {
        for frames in [1, 2] {
            let mut e = prepare(backend, counting(10));
            upload(&mut *e, "source", &[1u32; 10]);
            let mut past = 3;
            for _ in 0..frames {
                e.run().unwrap();
                past = 2 * past + 1;
            }
            e.adopt(compile(counting(20))).unwrap();
            let total: Vec<u32> = (frames..frames + 10).chain(10..20).collect();
            assert_eq!(read(&mut *e, "total"), total);
            assert_eq!(read(&mut *e, "past"), [[past; 10], [3; 10]].concat());
            e.run().unwrap();
            assert_eq!(
                read(&mut *e, "past"),
                [[2 * past + 1; 10], [7; 10]].concat()
            );
            e.adopt(compile(counting(10))).unwrap();
            assert_eq!(read(&mut *e, "total"), (0..10).collect::<Vec<u32>>());
        }
    });
}

#[test]
fn another_initial_value_starts_anew() {
    let graph = |initial: u32| {
        let mut g = Graph::new("kept");
        let (state, kept) = g.state("kept", 2, Initial::fill(initial));
        let source = g.input("source", 2);
        let inputs = accumulate::Inputs {
            source: &source,
            total: kept,
        };
        let out = g.add::<accumulate::Accumulate>("add", inputs, Dispatch::Elements(2));
        g.output("kept", &out.total);
        g.keep(state, out.total);
        g
    };
    watched(|backend| {
        let mut e = prepare(backend, graph(1));
        upload(&mut *e, "source", &[5u32, 6]);
        e.run().unwrap();
        e.adopt(compile(graph(2))).unwrap();
        assert_eq!(read(&mut *e, "kept"), [2, 2]);
        assert_eq!(
            read(&mut *e, "source"),
            [5, 6],
            "an input keeps its content"
        );
    });
}

/// A schedule that the device cannot have leaves everything as it was.
#[test]
fn after_an_error_the_old_schedule_goes_on() {
    watched(|backend| {
        let mut e = prepare(backend, counting(10));
        upload(&mut *e, "source", &[1u32; 10]);
        e.run().unwrap();
        assert!(e.adopt(compile(counting((1 << 32) - (1 << 17)))).is_err());
        e.run().unwrap();
        assert_eq!(read(&mut *e, "total"), (2..12).collect::<Vec<u32>>());
        assert_eq!(read(&mut *e, "past"), [15; 10]);
    });
}

#[test]
fn an_executable_outlives_its_backend() {
    let Some(backend) = start() else { return };
    let log = backend.validation_log();
    let mut e = prepare(&backend, counting(10));
    drop(backend);
    e.run().unwrap();
    assert_eq!(read(&mut *e, "past"), [7; 10]);
    drop(e);
    assert_eq!(log.messages(), Vec::<String>::new());
}
