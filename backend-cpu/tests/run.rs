//! What frames give.
mod common;

use common::*;
use gibs_backend_cpu::Options;
use gibs_graph::{Backend, BackendError, Dispatch, DispatchArgs, Graph, Initial};

const LEN: u64 = 1000;

fn all() -> Dispatch<'static> {
    Dispatch::Elements(LEN)
}

fn doubling() -> Graph {
    let mut g = Graph::new("test");
    let source = g.input("source", LEN);
    let target = g.transient("target", LEN);
    let inputs = double::Inputs {
        source: &source,
        target,
    };
    let target = g.add::<double::Double>("double", inputs, all()).target;
    g.output("target", &target);
    g
}

#[test]
fn numbers_are_doubled() {
    let mut exec = prepare(doubling());
    exec.run().unwrap();
    assert_eq!(read(&mut *exec, "target"), vec![0; LEN as usize]);
    let numbers: Vec<u32> = (0..LEN as u32).collect();
    upload(&mut *exec, "source", &numbers);
    exec.run().unwrap();
    exec.wait().unwrap();
    assert_eq!(
        read(&mut *exec, "target"),
        numbers.iter().map(|n| 2 * n).collect::<Vec<_>>()
    );
}

#[test]
fn the_device_is_described() {
    let backend = backend(Options {
        threads: Some(2),
        ..Options::default()
    });
    assert_eq!(backend.name(), "cpu");
    let device = backend.device();
    assert_eq!(
        (device.kind.as_str(), device.timestamps, device.ray_query),
        ("cpu", true, false)
    );
    assert!(!device.name.is_empty());
    assert!(
        device.notes.contains(&"2 threads".to_string()),
        "{:?}",
        device.notes
    );
}

#[test]
fn zeroed_counts_start_anew_in_every_frame() {
    let mut g = Graph::new("test");
    let source = g.input("source", LEN);
    let counts = g.zeroed("counts", 10);
    let inputs = histogram::Inputs {
        source: &source,
        counts,
    };
    let counts = g.add::<histogram::Histogram>("count", inputs, all()).counts;
    g.output("counts", &counts);
    let mut exec = prepare(g);
    let numbers: Vec<u32> = (0..LEN as u32).map(|i| i % 20).collect();
    upload(&mut *exec, "source", &numbers);
    for _ in 0..3 {
        exec.run().unwrap();
        // Ten of twenty numbers and those beyond them share the last count.
        assert_eq!(
            read(&mut *exec, "counts"),
            [50, 50, 50, 50, 50, 50, 50, 50, 50, 550]
        );
    }
}

/// A graph whose second stage runs as many workgroups as the source says.
fn indirect() -> Graph {
    let mut g = Graph::new("test");
    let source = g.input("source", 3);
    let args = g.transient::<DispatchArgs>("args", 1);
    let args = g
        .add::<sizes::Sizes>(
            "sizes",
            sizes::Inputs {
                source: &source,
                args,
            },
            Dispatch::Groups([1; 3]),
        )
        .args;
    let [visits, turns, next] = ["visits", "turns", "next"].map(|name| g.zeroed(name, 200));
    let inputs = visit::Inputs {
        source: &source,
        visits,
        turns,
        next,
    };
    let made = g.add::<visit::Visit>("draw/visit", inputs, Dispatch::Indirect(&args));
    g.output("visits", &made.visits);
    g
}

#[test]
fn indirect_dispatches_have_the_size_that_the_frame_computes() {
    for size in [[0, 7, 1], [1, 1, 1], [100, 1, 1], [5, 4, 3], [199, 1, 1]] {
        let mut exec = prepare(indirect());
        upload(&mut *exec, "source", &size);
        exec.run().unwrap();
        let groups = size.iter().product::<u32>() as usize;
        let visits = read(&mut *exec, "visits");
        assert_eq!(visits[..groups], vec![1; groups], "{size:?}");
        assert_eq!(visits[groups..], vec![0; 200 - groups], "{size:?}");
    }
}

#[test]
fn indirect_sizes_that_no_device_takes_are_an_error() {
    let run = |size: [u32; 3]| {
        let mut exec = prepare(indirect());
        upload(&mut *exec, "source", &size);
        exec.run()
    };
    let error = run([65_536, 1, 1]).unwrap_err();
    assert!(matches!(&error, BackendError::Kernel { stage, .. } if stage == "draw/visit"));
    let text = error.to_string();
    assert!(
        text.starts_with(
            "stage `draw/visit`: [65536, 1, 1] workgroups were asked for; at most 65535"
        ),
        "{text}"
    );
    // The product has no place in 64 bits.
    assert!(run([u32::MAX; 3]).is_err());
    assert!(run([65_535, 65_535, 2]).is_err());
    // Nothing at all is fine, however long the other axes are.
    assert!(run([u32::MAX, u32::MAX, 0]).is_ok());
}

#[test]
fn no_workgroups_do_nothing() {
    let mut g = Graph::new("test");
    let source = g.input("source", LEN);
    let (state, value) = g.state("value", LEN, Initial::fill(9_u32));
    let inputs = double::Inputs {
        source: &source,
        target: value,
    };
    let value = g
        .add::<double::Double>("double", inputs, Dispatch::Groups([3, 0, 3]))
        .target;
    g.output("value", &value);
    g.keep(state, value);
    let mut exec = prepare(g);
    exec.run().unwrap();
    assert_eq!(read(&mut *exec, "value"), vec![9; LEN as usize]);
}

#[test]
fn wide_kernels_run_unless_the_oracle_is_asked_for() {
    let graph = || {
        let mut g = Graph::new("test");
        let source = g.input("source", LEN);
        let extra = g.input("extra", 1);
        let target = g.transient("target", LEN);
        let inputs = twins::Inputs {
            source: &source,
            extra: &extra,
            target,
        };
        let target = g.add::<twins::Twins>("twins", inputs, all()).target;
        g.output("target", &target);
        g
    };
    for (scalar, want) in [(false, 12), (true, 1)] {
        let mut exec = prepare_with(
            Options {
                scalar,
                ..Options::default()
            },
            graph(),
        );
        upload(&mut *exec, "extra", &[10]);
        exec.run().unwrap();
        assert_eq!(read(&mut *exec, "target"), vec![want; LEN as usize]);
    }
    // A stage without a wide kernel runs its scalar one.
    let mut exec = prepare(doubling());
    upload(&mut *exec, "source", &[4]);
    exec.run().unwrap();
    assert_eq!(read(&mut *exec, "target")[0], 8);
}

#[test]
fn uploads_beyond_a_resource_are_errors() {
    let mut exec = prepare(doubling());
    let source = exec.schedule().resource("source").unwrap();
    exec.upload(source, 3996, &[1, 2, 3, 4]).unwrap();
    exec.upload(source, 4000, &[]).unwrap();
    let message = |result: Result<(), BackendError>| result.unwrap_err().to_string();
    let error = exec.upload(source, 3997, &[1, 2, 3, 4]);
    assert_eq!(
        message(error),
        "`source` has 4000 bytes, 3997..4001 was asked for; stay within them"
    );
    let error = exec.upload(source, u64::MAX, &[1]);
    assert_eq!(
        message(error),
        format!(
            "`source` has 4000 bytes, {0}..{0} was asked for; stay within them",
            u64::MAX
        )
    );
    let error = exec.upload(99, 0, &[]);
    let name = &exec.schedule().name;
    let count = exec.schedule().resources.len();
    let want = format!(
        "resource 99 of `{name}`: the schedule has {count} resources; take the number from `Schedule::resource` or `Schedule::output`"
    );
    assert_eq!(message(error), want);
    assert!(matches!(exec.read(99), Err(BackendError::Refused { .. })));
    // What failed changed nothing.
    let words = read(&mut *exec, "source");
    assert_eq!(words[998..], [0, u32::from_ne_bytes([1, 2, 3, 4])]);
}

/// Offsets need no alignment.
#[test]
fn uploads_replace_the_bytes_that_they_name() {
    let mut exec = prepare(doubling());
    let source = exec.schedule().resource("source").unwrap();
    exec.upload(source, 5, &[1, 2, 3]).unwrap();
    let bytes = exec.read(source).unwrap();
    assert_eq!(bytes[..12], [0, 0, 0, 0, 0, 1, 2, 3, 0, 0, 0, 0]);
}

/// Refused before anything is allocated, also where only wide kernels would see it. A machine that does not say how much
/// memory it has finds out by asking for it.
#[test]
fn memory_that_is_not_there_is_an_error() {
    let backend = backend(Options::default());
    let limit = backend.capabilities().memory;
    let mut g = Graph::new("test");
    let huge = g.input::<u32>("huge", u64::MAX / 2);
    g.output("huge", &huge);
    let text = backend.prepare(compile(g)).err().unwrap().to_string();
    if limit == u64::MAX {
        let want = format!("out of memory on `cpu` allocating {limit} bytes for `huge`; ");
        assert!(text.starts_with(&want), "{text}");
        return;
    }
    let want = format!("graph `test` (bytes of memory in all) needs {}, ", u64::MAX);
    assert!(text.starts_with(&want), "{text}");
    assert!(text.contains(&format!(" allows {limit}; ")), "{text}");

    let mut g = Graph::new("test");
    let tree = g.input::<u32>("tree", limit / 4 + 1);
    let target = g.transient("target", LEN);
    let inputs = hosted::Inputs {
        tree: &tree,
        target,
    };
    let out = g.add::<hosted::Hosted>("trace", inputs, all());
    g.output("target", &out.target);
    let refused = backend.prepare(compile(g));
    assert!(matches!(refused.err(), Some(BackendError::Limit { need, .. }) if need > limit));
}

mod hosted {
    use gibs_graph::{WgslSource, Workgroup, stage};

    stage! {
        /// Has data for wide CPU kernels.
        pub stage Hosted {
            wgsl: WgslSource { name: "hosted", text: "", modules: &[], features: &[] },
            workgroup: [64, 1, 1],
            ports: { host_only tree: u32, write target: u32 },
            cpu: kernel,
            wide: None,
        }
    }

    fn kernel(_: &Views<'_>, _: Workgroup) {}
}

#[test]
fn times_are_measured_per_step() {
    let mut g = doubling();
    let source = g.input("numbers", LEN);
    let counts = g.zeroed("counts", 10);
    let inputs = histogram::Inputs {
        source: &source,
        counts,
    };
    let counts = g.add::<histogram::Histogram>("count", inputs, all()).counts;
    g.output("counts", &counts);
    let mut exec = prepare(g);
    exec.run().unwrap();
    assert_eq!(exec.timings().unwrap(), None);
    exec.measure(true);
    assert_eq!(exec.timings().unwrap(), None);
    for _ in 0..3 {
        let start = std::time::Instant::now();
        exec.run().unwrap();
        let frame = start.elapsed();
        let times = exec.timings().unwrap().unwrap();
        assert_eq!(
            times.iter().map(|time| time.step).collect::<Vec<_>>(),
            [0, 1, 2]
        );
        // Steps run one after another within the frame.
        assert!(
            times
                .iter()
                .map(|time| time.time)
                .sum::<std::time::Duration>()
                <= frame
        );
    }
    let last = exec.timings().unwrap();
    exec.measure(false);
    exec.run().unwrap();
    assert_eq!(exec.timings().unwrap(), last);
}

#[test]
fn threads_do_not_show_in_the_result() {
    let graph = || {
        let len = 100_000;
        let mut g = Graph::new("test");
        let source = g.input("source", len);
        let [a, b] = ["a", "b"].map(|name| g.transient(name, len));
        let counts = g.zeroed("counts", 777);
        let all = || Dispatch::Elements(len);
        let a = g
            .add::<double::Double>(
                "a",
                double::Inputs {
                    source: &source,
                    target: a,
                },
                all(),
            )
            .target;
        let b = g
            .add::<double::Double>(
                "b",
                double::Inputs {
                    source: &a,
                    target: b,
                },
                all(),
            )
            .target;
        let inputs = histogram::Inputs { source: &b, counts };
        let counts = g.add::<histogram::Histogram>("count", inputs, all()).counts;
        g.output("b", &b);
        g.output("counts", &counts);
        g
    };
    let run = |threads, checked| {
        let mut exec = prepare_with(
            Options {
                threads: Some(threads),
                checked,
                scalar: false,
            },
            graph(),
        );
        let numbers: Vec<u32> = (0..100_000_u32)
            .map(|i| i.wrapping_mul(2_654_435_761) >> 22)
            .collect();
        upload(&mut *exec, "source", &numbers);
        exec.run().unwrap();
        (read(&mut *exec, "b"), read(&mut *exec, "counts"))
    };
    let one = run(1, false);
    assert_eq!(one.1.iter().sum::<u32>(), 100_000);
    assert!(one.1.iter().filter(|&&count| count > 0).count() > 100);
    assert_eq!(one, run(2, false));
    assert_eq!(one, run(2, true));
    assert_eq!(one, run(7, false));
    assert_eq!(one, run(64, false));
}
