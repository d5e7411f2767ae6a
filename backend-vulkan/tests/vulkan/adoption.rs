//! A new schedule takes over the state of an old one.
use crate::stages::*;
use crate::state::counting;
use crate::support::{compile, prepare, read, start, upload, watched};
use gibs_graph::{
    Backend, BackendError, Dispatch, Executable, Graph, Initial, ResourceId, Schedule, StepTime,
};
use std::any::Any;
use std::sync::Arc;

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
            let mut e = backend
                .prepare(compile(counting_and_doubling(10)), Some(e))
                .unwrap();
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

#[test]
fn another_length_starts_anew() {
    watched(|backend| {
        let mut e = prepare(backend, counting(10));
        upload(&mut *e, "source", &[1u32; 10]);
        e.run().unwrap();
        let mut e = backend.prepare(compile(counting(20)), Some(e)).unwrap();
        assert_eq!(read(&mut *e, "total"), (0..20).collect::<Vec<u32>>());
        assert_eq!(read(&mut *e, "past"), [3; 20]);
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
        let mut e = backend.prepare(compile(graph(2)), Some(e)).unwrap();
        assert_eq!(read(&mut *e, "kept"), [2, 2]);
        assert_eq!(
            read(&mut *e, "source"),
            [5, 6],
            "an input keeps its content"
        );
    });
}

/// An executable that no backend here made.
struct Stranger(Arc<Schedule>);

impl Executable for Stranger {
    fn schedule(&self) -> &Arc<Schedule> {
        &self.0
    }
    fn upload(&mut self, _: ResourceId, _: u64, _: &[u8]) -> Result<(), BackendError> {
        Ok(())
    }
    fn run(&mut self) -> Result<(), BackendError> {
        Ok(())
    }
    fn run_step(&mut self, _: usize) -> Result<(), BackendError> {
        Ok(())
    }
    fn read(&mut self, _: ResourceId) -> Result<Vec<u8>, BackendError> {
        Ok(Vec::new())
    }
    fn reset(&mut self) -> Result<(), BackendError> {
        Ok(())
    }
    fn wait(&mut self) -> Result<(), BackendError> {
        Ok(())
    }
    fn measure(&mut self, _: bool) {}
    fn timings(&mut self) -> Result<Option<Vec<StepTime>>, BackendError> {
        Ok(None)
    }
    fn into_any(self: Box<Self>) -> Box<dyn Any> {
        self
    }
}

#[test]
fn strangers_are_refused() {
    watched(|backend| {
        let schedule = compile(counting(10));
        let stranger = Box::new(Stranger(schedule.clone()));
        let error = backend.prepare(schedule.clone(), Some(stranger)).err();
        assert!(
            matches!(error, Some(BackendError::ForeignExecutable { .. })),
            "{error:?}"
        );

        let Some(other) = start() else { return };
        let of_other = prepare(&other, counting(10));
        let error = backend.prepare(schedule, Some(of_other)).err();
        assert!(
            matches!(error, Some(BackendError::ForeignExecutable { .. })),
            "{error:?}"
        );
        let log = other.validation_log();
        drop(other);
        assert_eq!(log.messages(), Vec::<String>::new());
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
