//! The backend on a real driver. Without one, nothing is run; `GIBS_STRICT=1` makes that a failure.
mod common;
mod stages;

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
fn a_state_is_kept_until_it_is_reset() {
    let Some(backend) = backend() else { return };
    let mut run = backend.prepare(aging(100, 1)).unwrap();
    upload(&mut *run, "amount", &[10, 0, 0, 0]);
    for _ in 0..3 {
        run.run().unwrap();
    }
    assert_eq!(read(&mut *run, "totals"), [35; 100]);
    run.reset().unwrap();
    assert_eq!(read(&mut *run, "totals"), [5; 100]);
    run.run().unwrap();
    assert_eq!(
        read(&mut *run, "totals"),
        [15; 100],
        "a reset leaves inputs alone"
    );
}

#[test]
fn initial_values_are_there_before_the_first_frame() {
    let Some(backend) = backend() else { return };
    let mut g = Graph::new("initial");
    let amount = g.input::<UVec4>("amount", 1);
    let mut keys = Vec::new();
    for (key, initial) in [
        ("zero", Initial::Zero),
        ("sequence", Initial::Sequence),
        ("nine", Initial::fill(9_u32)),
    ] {
        let (state, totals) = g.state::<u32>(key, 4, initial);
        let out = g.add::<add::Add>(
            key,
            add::Inputs {
                amount: &amount,
                totals,
            },
            Dispatch::Elements(4),
        );
        g.output(key, &out.totals);
        g.keep(state, out.totals);
        keys.push(key);
    }
    let mut run = backend.prepare(compile(g)).unwrap();
    upload(&mut *run, "amount", &[1; 4]);
    let all = |run: &mut dyn Executable| keys.iter().map(|key| read(run, key)).collect::<Vec<_>>();
    let before = [[0, 0, 0, 0], [0, 1, 2, 3], [9, 9, 9, 9]];
    assert_eq!(all(&mut *run), before);
    run.run().unwrap();
    assert_ne!(all(&mut *run), before);
    run.reset().unwrap();
    assert_eq!(all(&mut *run), before);
}

#[test]
fn a_history_rotates_once_per_frame() {
    let Some(backend) = backend() else { return };
    let mut run = backend.prepare(aging(1, 70)).unwrap();
    for want in 6..10 {
        run.run().unwrap();
        assert_eq!(read(&mut *run, "ages"), [want; 70]);
    }
    let step = run
        .schedule()
        .steps
        .iter()
        .position(|s| s.label == "history/age")
        .unwrap();
    run.run_step(step).unwrap();
    assert_eq!(
        read(&mut *run, "ages"),
        [9; 70],
        "a step alone sees the same frame before"
    );
    run.reset().unwrap();
    assert_eq!(read(&mut *run, "ages"), [5; 70]);
}

#[test]
fn an_upload_to_a_history_is_what_the_next_frame_finds() {
    let Some(backend) = backend() else { return };
    let mut run = backend.prepare(aging(1, 1)).unwrap();
    for uploaded in [100, 200, 300] {
        upload(&mut *run, "ages", &[uploaded]);
        run.run().unwrap();
        assert_eq!(read(&mut *run, "ages"), [uploaded + 1]);
    }
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
fn adoption_carries_over_what_agrees() {
    let Some(backend) = backend() else { return };
    // After an odd and after an even number of frames: a history must be taken over the right way round.
    for frames in [3, 4] {
        let mut old = backend.prepare(aging(20, 10)).unwrap();
        upload(&mut *old, "amount", &[1, 0, 0, 0]);
        for _ in 0..frames {
            old.run().unwrap();
        }
        let mut new = old;
        new.adopt(aging(10, 10)).unwrap();
        assert_eq!(read(&mut *new, "ages"), [5 + frames; 10]);
        assert_eq!(read(&mut *new, "amount"), [1, 0, 0, 0]);
        assert_eq!(
            read(&mut *new, "totals"),
            [5; 10],
            "what is shorter starts over"
        );
        new.run().unwrap();
        assert_eq!(read(&mut *new, "ages"), [6 + frames; 10]);
        assert_eq!(read(&mut *new, "totals"), [6; 10]);
        new.adopt(aging(20, 20)).unwrap();
        let ages = [[6 + frames; 10], [5; 10]].concat();
        assert_eq!(read(&mut *new, "ages"), ages, "what is longer goes on");
        assert_eq!(read(&mut *new, "totals"), [[6; 10], [5; 10]].concat());
        new.run().unwrap();
        let ages = [[7 + frames; 10], [6; 10]].concat();
        assert_eq!(read(&mut *new, "ages"), ages, "in both allocations");
    }
}

/// A schedule that the device cannot have leaves everything as it was.
#[test]
fn after_an_error_the_old_schedule_goes_on() {
    let Some(backend) = backend() else { return };
    let mut run = backend.prepare(aging(10, 10)).unwrap();
    upload(&mut *run, "amount", &[1, 0, 0, 0]);
    run.run().unwrap();
    assert!(run.adopt(aging((1 << 32) - (1 << 17), 10)).is_err());
    run.run().unwrap();
    assert_eq!(read(&mut *run, "ages"), [7; 10]);
    assert_eq!(read(&mut *run, "totals"), [7; 10]);
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

#[test]
fn a_limit_names_the_resource() {
    let Some(backend) = backend() else { return };
    let len = backend.capabilities().storage_binding / 4 + 1;
    let Err(error) = backend.prepare(doubling(len)) else {
        panic!("{len} elements were accepted")
    };
    assert!(
        matches!(&error, BackendError::Limit { what, need, .. }
        if what.contains("`numbers`") && *need == 4 * len),
        "{error}"
    );
}

#[test]
fn a_broken_kernel_names_the_stage() {
    let Some(backend) = backend() else { return };
    let errors =
        [
            refusal::<broken::syntax::Syntax>(&backend, |numbers, doubled| {
                broken::syntax::Inputs { numbers, doubled }
            }),
            refusal::<broken::unnamed::Unnamed>(&backend, |numbers, doubled| {
                broken::unnamed::Inputs { numbers, doubled }
            }),
            refusal::<broken::refused::Refused>(&backend, |numbers, doubled| {
                broken::refused::Inputs { numbers, doubled }
            }),
        ];
    for (error, word) in errors.iter().zip(["expected", "doubled", "refused"]) {
        assert!(
            matches!(error, BackendError::Kernel { stage, message } if stage == "bad" && message.contains(word)),
            "{error}"
        );
    }
    let mut run = backend.prepare(doubling(1)).unwrap();
    run.run().unwrap();
    run.wait().unwrap();
}

/// What preparing a stage called `bad`, with one port to read and one to write, fails with.
fn refusal<S>(
    backend: &WgpuBackend,
    inputs: impl for<'g> Fn(&'g gibs_graph::Buffer<u32>, gibs_graph::Buffer<u32>) -> S::Inputs<'g>,
) -> BackendError
where
    S: gibs_graph::Stage,
    S::Outputs: Doubled,
{
    let mut g = Graph::new("broken");
    let numbers = g.input::<u32>("numbers", 4);
    let doubled = g.transient::<u32>("doubled", 4);
    let out = g.add::<S>("bad", inputs(&numbers, doubled), Dispatch::Elements(4));
    g.output("doubled", out.doubled());
    match backend.prepare(compile(g)) {
        Ok(_) => panic!("{} was accepted", S::NAME),
        Err(error) => error,
    }
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
fn spirv_gives_what_wgsl_gives() {
    let Some(wgsl) = backend() else { return };
    let spirv = match WgpuBackend::new(Options {
        same_spirv: true,
        ..Options::default()
    }) {
        Ok(spirv) => spirv,
        Err(error) => {
            assert!(error.to_string().contains("PASSTHROUGH_SHADERS"), "{error}");
            return;
        }
    };
    for backend in [wgsl, spirv] {
        let mut run = backend.prepare(counting(100)).unwrap();
        upload(&mut *run, "numbers", &[3; 100]);
        run.run().unwrap();
        assert_eq!(read(&mut *run, "marks"), [1; 100]);
        let mut run = backend.prepare(aging(3, 3)).unwrap();
        upload(&mut *run, "amount", &[2; 4]);
        run.run().unwrap();
        run.run().unwrap();
        assert_eq!(
            (read(&mut *run, "totals"), read(&mut *run, "ages")),
            (vec![9; 3], vec![7; 3])
        );
    }
}

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
