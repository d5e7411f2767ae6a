//! What outlives a frame.
mod common;

use common::*;
use gibs_backend_cpu::Options;
use gibs_graph::{Backend, BackendError, Dispatch, Executable, Graph, Initial};

const LEN: u64 = 100;

fn all() -> Dispatch<'static> {
    Dispatch::Elements(LEN)
}

/// A state `total` that grows by an input, and a history `age` that grows by one.
fn growing(len: u64) -> Graph {
    let mut g = Graph::new("test");
    let step = g.input("step", 1);
    let (total_state, total) = g.state("total", len, Initial::fill(5_u32));
    let inputs = accumulate::Inputs { step: &step, total };
    let total = g
        .add::<accumulate::Accumulate>("accumulate", inputs, all())
        .total;
    let (age_state, before, now) = g.history("age", LEN, Initial::Sequence);
    let inputs = advance::Inputs {
        before: &before,
        now,
    };
    let now = g.add::<advance::Advance>("advance", inputs, all()).now;
    g.output("total", &total);
    g.output("age", &now);
    g.keep(total_state, total);
    g.keep(age_state, now);
    g
}

fn run(exec: &mut dyn Executable, frames: u32) {
    for _ in 0..frames {
        exec.run().unwrap();
    }
}

/// The sequence, plus `frames`.
fn ages(frames: u32) -> Vec<u32> {
    (frames..LEN as u32 + frames).collect()
}

#[test]
fn states_and_histories_go_on_from_frame_to_frame() {
    let mut exec = prepare(growing(LEN));
    assert_eq!(read(&mut *exec, "total"), vec![5; LEN as usize]);
    assert_eq!(read(&mut *exec, "age"), ages(0));
    upload(&mut *exec, "step", &[3]);
    for frame in 1..=5 {
        run(&mut *exec, 1);
        assert_eq!(read(&mut *exec, "total"), vec![5 + 3 * frame; LEN as usize]);
        assert_eq!(read(&mut *exec, "age"), ages(frame));
    }
}

#[test]
fn an_upload_into_a_history_is_the_previous_value_of_the_next_frame() {
    let mut exec = prepare(growing(LEN));
    upload(&mut *exec, "age", &[100]);
    run(&mut *exec, 1);
    assert_eq!(read(&mut *exec, "age")[..3], [101, 2, 3]);
    run(&mut *exec, 1);
    upload(&mut *exec, "age", &[200, 300]);
    run(&mut *exec, 1);
    assert_eq!(read(&mut *exec, "age")[..3], [201, 301, 5]);
}

#[test]
fn reset_brings_back_initial_values_and_leaves_inputs() {
    let mut exec = prepare(growing(LEN));
    upload(&mut *exec, "step", &[3]);
    // Odd and even numbers of frames leave histories in different allocations.
    for frames in [1, 2, 3] {
        run(&mut *exec, frames);
        exec.reset().unwrap();
        assert_eq!(read(&mut *exec, "total"), vec![5; LEN as usize]);
        assert_eq!(read(&mut *exec, "age"), ages(0));
        assert_eq!(read(&mut *exec, "step")[0], 3);
        run(&mut *exec, 1);
        assert_eq!(read(&mut *exec, "total"), vec![8; LEN as usize]);
        assert_eq!(read(&mut *exec, "age"), ages(1));
    }
    // Both allocations of the history: a step alone, which rotates nothing, reads the previous one.
    run(&mut *exec, 2);
    exec.reset().unwrap();
    let steps = &exec.schedule().steps;
    let advance = steps
        .iter()
        .position(|step| step.label == "advance")
        .unwrap();
    exec.run_step(advance).unwrap();
    assert_eq!(read(&mut *exec, "age"), ages(1));
}

#[test]
fn a_new_schedule_adopts_what_agrees() {
    let backend = backend(Options {
        threads: Some(2),
        ..Options::default()
    });
    for frames in [1, 2] {
        let mut old = backend.prepare(compile(growing(LEN))).unwrap();
        upload(&mut *old, "step", &[3]);
        run(&mut *old, frames);
        let mut new = old;
        new.adopt(compile(growing(LEN - 1))).unwrap();
        // A shorter `total` starts anew, the others go on.
        assert_eq!(read(&mut *new, "total"), vec![5; LEN as usize - 1]);
        assert_eq!(read(&mut *new, "age"), ages(frames));
        run(&mut *new, 1);
        assert_eq!(read(&mut *new, "total")[0], 8);
        assert_eq!(read(&mut *new, "age"), ages(frames + 1));

        // The same schedule in another order of declaration adopts all.
        let mut again = Graph::new("again");
        let (age_state, before, now) = again.history("age", LEN, Initial::Sequence);
        let inputs = advance::Inputs {
            before: &before,
            now,
        };
        let now = again.add::<advance::Advance>("advance", inputs, all()).now;
        let step = again.input("step", 1);
        let (total_state, total) = again.state("total", LEN - 1, Initial::fill(5_u32));
        let inputs = accumulate::Inputs { step: &step, total };
        let total = again
            .add::<accumulate::Accumulate>("accumulate", inputs, all())
            .total;
        again.output("total", &total);
        again.output("age", &now);
        again.keep(total_state, total);
        again.keep(age_state, now);
        new.adopt(compile(again)).unwrap();
        let mut again = new;
        run(&mut *again, 1);
        assert_eq!(read(&mut *again, "total")[0], 11);
        assert_eq!(read(&mut *again, "age"), ages(frames + 2));
    }
}

/// What is longer goes on at its front.
#[test]
fn state_that_grows_keeps_what_it_held() {
    let mut exec = prepare(growing(3));
    upload(&mut *exec, "step", &[3]);
    run(&mut *exec, 1);
    exec.adopt(compile(growing(5))).unwrap();
    assert_eq!(read(&mut *exec, "total"), [8, 8, 8, 5, 5]);
    exec.adopt(compile(growing(4))).unwrap();
    assert_eq!(
        read(&mut *exec, "total"),
        [5; 4],
        "what is shorter starts anew"
    );
}

/// A schedule that cannot be had leaves everything as it was.
#[test]
fn after_an_error_the_old_schedule_goes_on() {
    let mut exec = prepare(growing(LEN));
    upload(&mut *exec, "step", &[3]);
    run(&mut *exec, 1);
    let error = exec.adopt(compile(growing(1 << 60))).unwrap_err();
    assert!(
        matches!(
            &error,
            BackendError::OutOfMemory { .. } | BackendError::Limit { .. }
        ),
        "{error}"
    );
    run(&mut *exec, 1);
    assert_eq!(read(&mut *exec, "total"), vec![11; LEN as usize]);
    assert_eq!(read(&mut *exec, "age"), ages(2));
}

#[test]
fn a_single_step_neither_clears_nor_rotates() {
    let mut g = growing(LEN);
    let source = g.input("source", LEN);
    let counts = g.zeroed("counts", 1);
    let inputs = histogram::Inputs {
        source: &source,
        counts,
    };
    let counts = g.add::<histogram::Histogram>("count", inputs, all()).counts;
    g.output("counts", &counts);
    let mut exec = prepare(g);
    upload(&mut *exec, "step", &[3]);
    let step = |exec: &dyn Executable, label| {
        exec.schedule()
            .steps
            .iter()
            .position(|s| s.label == label)
            .unwrap()
    };
    let steps = ["accumulate", "advance", "count", "clear counts"].map(|label| step(&*exec, label));
    let [accumulate, advance, count, clear] = steps;
    run(&mut *exec, 1);
    for times in 1..=2 {
        exec.run_step(accumulate).unwrap();
        exec.run_step(advance).unwrap();
        exec.run_step(count).unwrap();
        assert_eq!(read(&mut *exec, "total")[0], 8 + 3 * times);
        // Made from the same previous value again.
        assert_eq!(read(&mut *exec, "age"), ages(1));
        assert_eq!(read(&mut *exec, "counts"), [LEN as u32 * (1 + times)]);
    }
    exec.run_step(clear).unwrap();
    assert_eq!(read(&mut *exec, "counts"), [0]);
    let text = exec.run_step(4).unwrap_err().to_string();
    assert_eq!(
        text,
        "step 4 of `test`: the schedule has 4 steps; take the number from `Schedule::steps`"
    );
}
