//! The backend on a real driver. Without one, nothing is run; `GIBS_STRICT=1` makes that a failure.
#[path = "../common/mod.rs"]
mod common;
mod refusals;
#[path = "../stages/mod.rs"]
mod stages;
mod states;

use common::{aging, backend, compile, counting, doubling, engine, id, open, read, upload};
use gibs_backend_wgpu::{Options, WgpuBackend, devices};
use gibs_graph::{Action, Backend, BackendError, Dispatch, Executable, Graph, Initial};
use glam::UVec4;
use stages::{add, broken};

#[test]
fn numbers_are_doubled() {
    let Some(backend) = backend() else { return };
    // One element binds 4 bytes of a larger buffer; 1000 is no multiple of the workgroup.
    for len in [1, 1000] {
        let mut run = backend.prepare(doubling(len)).unwrap();
        let numbers: Vec<u32> = (0..len as u32).map(|i| i + 3).collect();
        upload(&mut *run, "numbers", &numbers);
        run.run().unwrap();
        assert_eq!(
            read(&mut *run, "doubled"),
            numbers.iter().map(|n| 2 * n).collect::<Vec<_>>()
        );
    }
}

#[test]
fn an_upload_may_start_and_end_anywhere() {
    let Some(backend) = backend() else { return };
    let mut run = backend.prepare(doubling(4)).unwrap();
    upload(&mut *run, "numbers", &[0, 0x0403_0201, 0x0807_0605, 9]);
    let numbers = id(&*run, "numbers");
    run.upload(numbers, 6, &[0xaa, 0xbb, 0xcc]).unwrap();
    assert_eq!(read(&mut *run, "numbers"), [0, 0xbbaa_0201, 0x0807_06cc, 9]);
}

#[test]
fn bytes_and_steps_that_are_not_there_are_errors() {
    let Some(backend) = backend() else { return };
    let mut run = backend.prepare(doubling(4)).unwrap();
    let numbers = id(&*run, "numbers");
    assert!(matches!(
        run.upload(numbers, 12, &[0; 8]),
        Err(BackendError::Range {
            offset: 12,
            end: 20,
            ..
        })
    ));
    assert!(matches!(run.read(99), Err(BackendError::Refused { .. })));
    assert!(matches!(
        run.run_step(99),
        Err(BackendError::Refused { .. })
    ));
}

#[test]
fn a_dispatch_of_nothing_does_nothing() {
    let Some(backend) = backend() else { return };
    let mut g = Graph::new("nothing");
    let amount = g.input::<UVec4>("amount", 1);
    let (state, totals) = g.state::<u32>("totals", 1, Initial::fill(5_u32));
    let out = g.add::<add::Add>(
        "add",
        add::Inputs {
            amount: &amount,
            totals,
        },
        Dispatch::Groups([1, 0, 1]),
    );
    g.output("totals", &out.totals);
    g.keep(state, out.totals);
    let mut run = backend.prepare(compile(g)).unwrap();
    upload(&mut *run, "amount", &[1; 4]);
    run.measure(true);
    run.run().unwrap();
    assert_eq!(read(&mut *run, "totals"), [5]);
    assert_eq!(
        run.timings().unwrap().map(|times| times.len()).unwrap_or(1),
        1
    );
}

#[test]
fn each_frame_sees_the_uniform_uploaded_before_it() {
    let Some(backend) = backend() else { return };
    let mut run = backend.prepare(aging(1, 1)).unwrap();
    for amount in [1, 10, 100] {
        upload(&mut *run, "amount", &[amount, 0, 0, 0]);
        run.run().unwrap();
    }
    upload(&mut *run, "amount", &[1000, 0, 0, 0]);
    run.wait().unwrap();
    assert_eq!(read(&mut *run, "totals"), [5 + 111]);
}

#[test]
fn a_zeroed_counter_starts_over_and_sizes_a_dispatch() {
    let Some(backend) = backend() else { return };
    let len = 1000;
    let mut run = backend.prepare(counting(len)).unwrap();
    for odd in [700, 700, 65, 0] {
        let numbers: Vec<u32> = (0..len as u32)
            .map(|i| u32::from(i >= len as u32 - odd))
            .collect();
        upload(&mut *run, "numbers", &numbers);
        run.run().unwrap();
        assert_eq!(read(&mut *run, "count"), [odd]);
        let marks: Vec<u32> = (0..len as u32).map(|i| u32::from(i < odd)).collect();
        assert_eq!(read(&mut *run, "marks"), marks);
    }
}

#[test]
fn steps_one_by_one_make_the_same_frame() {
    let Some(backend) = backend() else { return };
    let mut run = backend.prepare(counting(100)).unwrap();
    upload(&mut *run, "numbers", &[1; 100]);
    for step in 0..run.schedule().steps.len() {
        run.run_step(step).unwrap();
    }
    assert_eq!(read(&mut *run, "count"), [100]);
    assert_eq!(read(&mut *run, "marks"), [1; 100]);
}

#[test]
fn time_is_measured_for_every_dispatch() {
    let Some(backend) = backend() else { return };
    let mut run = backend.prepare(counting(100_000)).unwrap();
    run.run().unwrap();
    assert_eq!(run.timings().unwrap(), None, "nothing was measured");
    run.measure(true);
    for _ in 0..2 {
        run.run().unwrap();
    }
    let times = run.timings().unwrap();
    if !backend.device().timestamps {
        assert_eq!(times, None);
        return;
    }
    let times = times.unwrap();
    let steps: Vec<usize> = times.iter().map(|t| t.step).collect();
    // Clears have a time where the device writes timestamps outside of passes.
    let dispatches: Vec<usize> = run.schedule().dispatches().map(|(i, ..)| i).collect();
    let all: Vec<usize> = (0..run.schedule().steps.len()).collect();
    assert!(steps == all || steps == dispatches, "{steps:?}");
    assert!(
        times.is_sorted_by_key(|t| t.start) && times[0].start.is_zero(),
        "{times:?}"
    );
    // Counting 100000 numbers takes a while on any device; no stage takes minutes.
    assert!(times[0].time.as_nanos() > 0, "{times:?}");
    assert!(times.iter().all(|t| t.time.as_secs() < 60), "{times:?}");
    run.measure(false);
    run.run().unwrap();
    assert_eq!(
        run.timings().unwrap(),
        Some(times),
        "those of the last measured frame"
    );
}

trait Doubled {
    fn doubled(&self) -> &gibs_graph::Buffer<u32>;
}

macro_rules! doubled {
    ($($outputs:ty),*) => {
        $(impl Doubled for $outputs {
            fn doubled(&self) -> &gibs_graph::Buffer<u32> {
                &self.doubled
            }
        })*
    };
}

doubled!(
    broken::syntax::Outputs,
    broken::unnamed::Outputs,
    broken::refused::Outputs
);

#[test]
fn an_engine_records_frames_into_its_own_encoder() {
    let Some(engine) = engine() else { return };
    let backend = &engine.backend;
    assert!(
        !backend.device().timestamps,
        "the engine did not ask for them"
    );
    let mut run = backend.prepare_wgpu(aging(8, 8)).unwrap();
    upload(&mut run, "amount", &[4; 4]);
    let mut encoder = engine.encoder();
    run.record(&mut encoder).unwrap();
    run.record(&mut encoder).unwrap();
    engine.submit(encoder);
    assert_eq!(read(&mut run, "totals"), [13; 8]);
    assert_eq!(read(&mut run, "ages"), [7; 8]);
    assert!(
        run.buffer(id(&run, "ages"))
            .is_some_and(|buffer| buffer.size() >= 32)
    );
}

#[test]
fn the_device_is_described_and_found_by_name() {
    let Some(backend) = backend() else { return };
    let device = backend.device();
    assert_eq!(devices().first(), Some(device));
    assert!(
        ["discrete", "integrated", "virtual", "software"].contains(&device.kind.as_str()),
        "{device:?}"
    );
    let named = open(Options {
        adapter: Some(device.name.to_uppercase()),
        ..Options::default()
    })
    .unwrap();
    assert_eq!(named.device(), device);
    let error = WgpuBackend::new(Options {
        adapter: Some("no such device".into()),
        ..Options::default()
    })
    .unwrap_err();
    assert!(error.to_string().contains(&device.name), "{error}");
}

#[test]
fn the_schedules_here_have_the_steps_they_are_for() {
    let schedule = counting(10);
    let clears = schedule
        .steps
        .iter()
        .filter(|s| matches!(s.action, Action::Clear(_)))
        .count();
    assert_eq!((clears, schedule.dispatches().count()), (2, 3));
}
