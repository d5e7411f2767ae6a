//! What one frame computes.
use crate::stages::*;
use crate::support::{compile, prepare, read, upload, watched};
use gibs_graph::{Backend, Dispatch, DispatchArgs, Graph};
use std::time::Duration;

#[test]
fn numbers_are_doubled() {
    watched(|backend| {
        let mut g = Graph::new("double");
        let source = g.input("source", 1000);
        let target_ = g.transient("target", 1000);
        let out = g.add::<double::Double>(
            "double",
            double::Inputs {
                source: &source,
                target_,
            },
            Dispatch::Elements(1000),
        );
        g.output("target", &out.target_);
        let mut e = prepare(backend, g);
        let numbers: Vec<u32> = (0..1000).collect();
        upload(&mut *e, "source", &numbers);
        e.run().unwrap();
        assert_eq!(
            read(&mut *e, "target"),
            numbers.iter().map(|n| 2 * n).collect::<Vec<_>>()
        );
    });
}

#[test]
fn a_counter_starts_every_frame_at_zero() {
    watched(|backend| {
        let mut g = Graph::new("count");
        let source = g.input("source", 1000);
        let counter = g.zeroed("counter", 1);
        let inputs = count::Inputs {
            source: &source,
            counter,
        };
        let out = g.add::<count::Count>("count", inputs, Dispatch::Elements(1000));
        g.output("counter", &out.counter);
        let mut e = prepare(backend, g);
        upload(&mut *e, "source", &(0..1000).collect::<Vec<u32>>());
        for _ in 0..3 {
            e.run().unwrap();
        }
        assert_eq!(read(&mut *e, "counter"), [999 * 1000 / 2]);
    });
}

/// Sizes that a stage made; zero along an axis runs nothing.
#[test]
fn the_device_decides_how_much_runs() {
    watched(|backend| {
        let mut g = Graph::new("indirect");
        let source = g.input("source", 3);
        let args = g.transient::<DispatchArgs>("args", 1);
        let inputs = plan::Inputs {
            source: &source,
            args,
        };
        let args = g
            .add::<plan::Plan>("plan", inputs, Dispatch::Groups([1, 1, 1]))
            .args;
        let counter = g.zeroed("counter", 1);
        let step_ = g.input("step", 1);
        let inputs = tally::Inputs {
            step_: &step_,
            counter,
        };
        let out = g.add::<tally::Tally>("tally", inputs, Dispatch::Indirect(&args));
        g.output("counter", &out.counter);
        let mut e = prepare(backend, g);
        upload(&mut *e, "step", &[10u32]);
        for (size, expected) in [([2, 3, 4], 240), ([7, 1, 1], 70), ([5, 0, 1], 0)] {
            upload::<u32>(&mut *e, "source", &size);
            e.run().unwrap();
            assert_eq!(read(&mut *e, "counter"), [expected], "{size:?}");
        }
    });
}

#[test]
fn a_fixed_size_of_zero_runs_nothing() {
    watched(|backend| {
        let mut g = Graph::new("nothing");
        let counter = g.zeroed("counter", 1);
        let step_ = g.input("step", 1);
        let inputs = tally::Inputs {
            step_: &step_,
            counter,
        };
        let out = g.add::<tally::Tally>("tally", inputs, Dispatch::Elements(0));
        g.output("counter", &out.counter);
        let mut e = prepare(backend, g);
        upload(&mut *e, "step", &[1u32]);
        e.run().unwrap();
        assert_eq!(read(&mut *e, "counter"), [0]);
    });
}

fn affine() -> Graph {
    let mut g = Graph::new("line");
    let line = g.input("line", 1);
    let source = g.input("source", 4);
    let target_ = g.transient("target", 4);
    let inputs = line::Inputs {
        line: &line,
        source: &source,
        target_,
    };
    let out = g.add::<line::Affine>("line", inputs, Dispatch::Elements(4));
    g.output("target", &out.target_);
    g
}

/// Frames are under way while the next uniform is uploaded, and each must see its own.
#[test]
fn every_frame_sees_the_uniform_uploaded_before_it() {
    watched(|backend| {
        let mut g = affine();
        let (state, total) = g.state("total", 4, gibs_graph::Initial::Zero);
        let source = g.input("summand", 4);
        let inputs = accumulate::Inputs {
            source: &source,
            total,
        };
        let out = g.add::<accumulate::Accumulate>("sum", inputs, Dispatch::Elements(4));
        g.output("total", &out.total);
        g.keep(state, out.total);
        let mut e = prepare(backend, g);
        upload(&mut *e, "source", &[1u32, 2, 3, 4]);
        for frame in 0..50u32 {
            upload(
                &mut *e,
                "line",
                &[Line {
                    factor: frame,
                    offset: 7,
                    ..Line::default()
                }],
            );
            upload(&mut *e, "summand", &[frame; 4]);
            e.run().unwrap();
        }
        assert_eq!(read(&mut *e, "target"), [56, 105, 154, 203]);
        assert_eq!(read(&mut *e, "total"), [49 * 50 / 2; 4]);
    });
}

#[test]
fn workgroup_memory_starts_at_zero() {
    watched(|backend| {
        let mut g = Graph::new("sums");
        let source = g.input("source", 256);
        let target_ = g.transient("target", 4);
        let inputs = sums::Inputs {
            source: &source,
            target_,
        };
        let out = g.add::<sums::Sums>("sums", inputs, Dispatch::Elements(256));
        g.output("target", &out.target_);
        let mut e = prepare(backend, g);
        upload(&mut *e, "source", &[1u32; 256]);
        for _ in 0..3 {
            e.run().unwrap();
        }
        assert_eq!(read(&mut *e, "target"), [64; 4]);
    });
}

/// Allocations are rounded up, what a kernel sees is not.
#[test]
fn kernels_see_the_exact_length() {
    watched(|backend| {
        let mut g = Graph::new("length");
        let source = g.input("source", 3);
        let target_ = g.transient("target", 1);
        let inputs = length::Inputs {
            source: &source,
            target_,
        };
        let out = g.add::<length::Length>("length", inputs, Dispatch::Elements(1));
        g.output("target", &out.target_);
        let mut e = prepare(backend, g);
        e.run().unwrap();
        assert_eq!(read(&mut *e, "target"), [3]);
    });
}

#[test]
fn a_step_runs_alone() {
    watched(|backend| {
        let mut g = Graph::new("steps");
        let source = g.input("source", 4);
        let middle = g.transient("middle", 4);
        let inputs = double::Inputs {
            source: &source,
            target_: middle,
        };
        let middle = g
            .add::<double::Double>("first", inputs, Dispatch::Elements(4))
            .target_;
        let last = g.transient("last", 4);
        let inputs = double::Inputs {
            source: &middle,
            target_: last,
        };
        let last = g
            .add::<double::Double>("second", inputs, Dispatch::Elements(4))
            .target_;
        g.output("middle", &middle);
        g.output("last", &last);
        let mut e = prepare(backend, g);
        upload(&mut *e, "source", &[1u32; 4]);
        e.run().unwrap();
        upload(&mut *e, "middle", &[100u32; 4]);
        e.run_step(1).unwrap();
        assert_eq!(
            read(&mut *e, "middle"),
            [100; 4],
            "the first step did not run"
        );
        assert_eq!(read(&mut *e, "last"), [200; 4]);
        assert!(e.run_step(2).is_err());
    });
}

#[test]
fn time_is_measured_per_step() {
    watched(|backend| {
        let mut e = prepare(backend, affine());
        assert_eq!(e.timings().unwrap(), None);
        e.run().unwrap();
        assert_eq!(
            e.timings().unwrap(),
            None,
            "nothing is measured unless asked"
        );
        e.measure(true);
        for _ in 0..3 {
            e.run().unwrap();
        }
        let times = e.timings().unwrap();
        if !backend.device().timestamps {
            return assert_eq!(times, None);
        }
        let times = times.unwrap();
        assert_eq!(times.iter().map(|t| t.step).collect::<Vec<_>>(), [0]);
        // One workgroup takes well below a second anywhere, and a difference of unrelated numbers would not.
        assert!(times[0].time < Duration::from_secs(1), "{times:?}");
        e.measure(false);
        e.run().unwrap();
        assert_eq!(
            e.timings().unwrap().as_ref(),
            Some(&times),
            "of the last measured frame"
        );
    });
}

/// Work takes time, and the clock shows it.
#[test]
fn more_work_takes_more_time() {
    watched(|backend| {
        if !backend.device().timestamps {
            return;
        }
        let mut g = Graph::new("work");
        let step_ = g.input("step", 1);
        let (few, many) = (g.zeroed("few", 1), g.zeroed("many", 1));
        let inputs = tally::Inputs {
            step_: &step_,
            counter: few,
        };
        let few = g
            .add::<tally::Tally>("few", inputs, Dispatch::Groups([1, 1, 1]))
            .counter;
        let inputs = tally::Inputs {
            step_: &step_,
            counter: many,
        };
        let many = g
            .add::<tally::Tally>("many", inputs, Dispatch::Groups([60_000, 2, 1]))
            .counter;
        g.output("few", &few);
        g.output("many", &many);
        let schedule = compile(g);
        let mut e = backend.prepare(schedule.clone()).unwrap();
        e.run().unwrap(); // compiles, on software devices
        e.measure(true);
        e.run().unwrap();
        let times = e.timings().unwrap().unwrap();
        assert_eq!(times.len(), schedule.steps.len());
        let of = |label: &str| {
            let step = schedule
                .steps
                .iter()
                .position(|s| s.label == label)
                .unwrap();
            times[step].time
        };
        // 120,000 workgroups against one.
        assert!(of("many") > of("few"), "{times:?}");
    });
}

#[test]
fn host_only_resources_take_no_device_memory() {
    watched(|backend| {
        let mut g = Graph::new("beside");
        let source = g.input("source", 4);
        let tree = g.input("tree", 4);
        let target_ = g.transient("target", 4);
        let inputs = beside::Inputs {
            source: &source,
            tree: &tree,
            target_,
        };
        let out = g.add::<beside::Beside>("beside", inputs, Dispatch::Elements(4));
        g.output("target", &out.target_);
        let mut e = prepare(backend, g);
        upload(&mut *e, "source", &[1u32, 2, 3, 4]);
        upload(&mut *e, "tree", &[9u32; 4]);
        e.run().unwrap();
        assert_eq!(read(&mut *e, "target"), [2, 3, 4, 5]);
        let tree = e.schedule().resource("tree").unwrap();
        assert!(e.read(tree).is_err(), "the device has no copy");
    });
}
