//! What is kept from frame to frame.
use super::*;

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
