//! Uploads take effect in order, also between frames of one submission.
mod common;
mod stages;

use common::{Engine, aging, backend, doubling, engine, id, read, upload};
use gibs_backend_wgpu::{RECORDED_UPLOAD, RECORDED_UPLOADS, WgpuExecutable, wgpu};
use gibs_graph::{Backend, BackendError, Executable, Schedule};
use std::sync::Arc;
use wgpu::BufferUsages;

fn prepare(engine: &Engine, schedule: Arc<Schedule>) -> WgpuExecutable {
    engine.backend.prepare_wgpu(schedule).unwrap()
}

#[test]
fn each_frame_of_one_submission_sees_the_uploads_before_it() {
    let Some(engine) = engine() else { return };
    let mut run = prepare(&engine, aging(8, 8));
    let seen = engine.buffer(3 * 32, BufferUsages::COPY_SRC | BufferUsages::COPY_DST);
    let mut encoder = engine.encoder();
    for (i, amount) in [1, 10, 100].into_iter().enumerate() {
        upload(&mut run, "amount", &[amount, 0, 0, 0]);
        run.record(&mut encoder).unwrap();
        let totals = run.buffer(id(&run, "totals")).unwrap();
        encoder.copy_buffer_to_buffer(totals, 0, &seen, 32 * i as u64, 32);
    }
    engine.submit(encoder);
    let want: Vec<u32> = [6, 16, 116].into_iter().flat_map(|n| [n; 8]).collect();
    assert_eq!(engine.read(&seen), want);
}

#[test]
fn two_executables_share_an_encoder() {
    let Some(engine) = engine() else { return };
    let (mut one, mut two) = (prepare(&engine, aging(4, 4)), prepare(&engine, doubling(4)));
    let mut encoder = engine.encoder();
    for amount in [1, 10] {
        upload(&mut one, "amount", &[amount, 0, 0, 0]);
        upload(&mut two, "numbers", &[amount; 4]);
        one.record(&mut encoder).unwrap();
        two.record(&mut encoder).unwrap();
    }
    engine.submit(encoder);
    assert_eq!(read(&mut one, "totals"), [16; 4]);
    assert_eq!(read(&mut two, "doubled"), [20; 4]);
}

/// The bytes around are those of a frame that the device has not seen yet.
#[test]
fn a_part_of_a_word_keeps_what_a_recorded_frame_wrote_around_it() {
    let Some(engine) = engine() else { return };
    let mut run = prepare(&engine, aging(2, 1));
    let totals = id(&run, "totals");
    let mut encoder = engine.encoder();
    upload(&mut run, "amount", &[0x10, 0, 0, 0]);
    run.record(&mut encoder).unwrap();
    run.upload(totals, 2, &[0xaa, 0xbb, 0x01]).unwrap();
    run.record(&mut encoder).unwrap();
    engine.submit(encoder);
    assert_eq!(read(&mut run, "totals"), [0xbbaa_0025, 0x11]);
}

/// What was uploaded before stays with the backend's own buffer; the host writes and reads its own.
#[test]
fn a_lent_buffer_is_neither_written_nor_read() {
    let Some(engine) = engine() else { return };
    let mut run = prepare(&engine, doubling(4));
    let numbers = id(&run, "numbers");
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
    let lent = engine.buffer(16, usage);
    upload(&mut run, "numbers", &[1; 4]);
    run.import_buffer(numbers, &lent).unwrap();
    let uploaded = run.upload(numbers, 0, &[7; 16]).unwrap_err();
    let got = run.read(numbers).unwrap_err();
    for (error, done) in [(uploaded, "written"), (got, "read")] {
        assert!(matches!(error, BackendError::Refused { .. }), "{error}");
        assert_eq!(
            error.to_string(),
            format!(
                "`numbers` cannot be {done}: the host has lent it; use it where the host has it"
            )
        );
    }
    engine
        .queue
        .write_buffer(&lent, 0, bytemuck::bytes_of(&[5_u32; 4]));
    run.run().unwrap();
    assert_eq!(engine.read(&lent), [5; 4]);
    assert_eq!(read(&mut run, "doubled"), [10; 4]);
}

#[test]
fn an_engine_may_have_uploads_recorded_before_its_own_copies() {
    let Some(engine) = engine() else { return };
    let mut run = prepare(&engine, doubling(4));
    let [theirs, seen] = [0, 1].map(|_| {
        let usage = BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        engine.buffer(16, usage)
    });
    engine.queue.write_buffer(&theirs, 0, &[9; 16]);
    upload(&mut run, "numbers", &[1, 2, 3, 4]);
    let mut encoder = engine.encoder();
    run.record_uploads(&mut encoder).unwrap();
    let numbers = run.buffer(id(&run, "numbers")).unwrap();
    encoder.copy_buffer_to_buffer(numbers, 0, &seen, 0, 16);
    encoder.copy_buffer_to_buffer(&theirs, 0, numbers, 4, 4);
    run.record(&mut encoder).unwrap();
    engine.submit(encoder);
    assert_eq!(engine.read(&seen), [1, 2, 3, 4]);
    assert_eq!(read(&mut run, "doubled"), [2, 0x1212_1212, 6, 8]);
}

#[test]
fn an_encoder_that_is_dropped_takes_its_uploads_along() {
    let Some(engine) = engine() else { return };
    let mut run = prepare(&engine, aging(1, 1));
    upload(&mut run, "amount", &[1, 0, 0, 0]);
    for _ in 0..3 {
        upload(&mut run, "amount", &[10, 0, 0, 0]);
        run.record(&mut engine.encoder()).unwrap();
    }
    run.run().unwrap();
    assert_eq!(read(&mut run, "totals"), [5]);
    upload(&mut run, "amount", &[100, 0, 0, 0]);
    run.run().unwrap();
    assert_eq!(read(&mut run, "totals"), [105]);
}

#[test]
fn more_small_uploads_than_can_wait_are_all_there() {
    let Some(backend) = backend() else { return };
    let pieces = 2 * RECORDED_UPLOADS / RECORDED_UPLOAD + 3;
    let bytes: Vec<u8> = (0..pieces * RECORDED_UPLOAD)
        .map(|i| (i / 5) as u8)
        .collect();
    let mut run = backend.prepare(doubling(bytes.len() as u64 / 4)).unwrap();
    let numbers = id(&*run, "numbers");
    for (i, piece) in bytes.chunks(RECORDED_UPLOAD).enumerate() {
        run.upload(numbers, (i * RECORDED_UPLOAD) as u64, piece)
            .unwrap();
    }
    run.run().unwrap();
    assert_eq!(run.read(numbers).unwrap(), bytes);
    let doubled = read(&mut *run, "doubled");
    let numbers: Vec<u32> = bytemuck::pod_collect_to_vec(&bytes);
    assert!(
        doubled
            .iter()
            .zip(numbers)
            .all(|(d, n)| *d == n.wrapping_mul(2))
    );
}

/// Numbers that look random, the same in every run.
struct Dice(u64);

impl Dice {
    fn below(&mut self, n: usize) -> usize {
        // xorshift64*
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 33) as usize % n
    }
}

/// Numbers in a state or history: more than one small upload can write.
const LEN: usize = RECORDED_UPLOAD / 4 * 3;

/// What `aging(LEN, LEN)` is to hold.
struct Model {
    amount: u32,
    totals: Vec<u32>,
    ages: Vec<u32>,
}

impl Model {
    fn reset(&mut self) {
        self.totals.fill(5);
        self.ages.fill(5);
    }

    fn add(&mut self) {
        let amount = self.amount;
        let add = |n: &mut u32| *n = n.wrapping_add(amount);
        self.totals.iter_mut().for_each(add);
    }

    fn frame(&mut self) {
        self.add();
        self.ages.iter_mut().for_each(|n| *n = n.wrapping_add(1));
    }
}

/// Calls in any order, against a model on the host. Frames are recorded into an encoder that stays open until
/// something comes that does not wait for recorded frames.
#[test]
fn any_order_of_calls_is_the_order_of_effects() {
    let Some(engine) = engine() else { return };
    let schedule = aging(LEN as u64, LEN as u64);
    let mut run = prepare(&engine, Arc::clone(&schedule));
    let step = schedule.steps.iter().position(|s| s.label == "state/add");
    let step = step.unwrap();
    let mut model = Model {
        amount: 0,
        totals: vec![5; LEN],
        ages: vec![5; LEN],
    };
    let mut dice = Dice(20);
    let mut open: Option<wgpu::CommandEncoder> = None;
    let mut counts = [0; 10];
    let mut together = 0;
    for call in 0..1500 {
        let kind = dice.below(22);
        if kind > 15
            && let Some(encoder) = open.take()
        {
            engine.submit(encoder);
        }
        let what = match kind {
            0..=2 => {
                model.amount = dice.below(1 << 20) as u32;
                upload(&mut run, "amount", &[model.amount, 0, 0, 0]);
                0
            }
            // Uploads to what frames write; from 16 on large ones.
            3..=10 | 16..=17 => {
                let is_large = kind > 15;
                let (least, most) = match (is_large, kind % 4) {
                    (true, _) => (RECORDED_UPLOAD + 1, 4 * LEN),
                    (false, 0) => (0, RECORDED_UPLOAD),
                    (false, _) => (0, 40),
                };
                let len = least + dice.below(most - least + 1);
                let mut offset = dice.below(4 * LEN - len + 1);
                let mut len = len;
                if kind.is_multiple_of(2) && !is_large {
                    (offset, len) = (offset / 4 * 4, len / 4 * 4);
                }
                let bytes: Vec<u8> = (0..len).map(|_| dice.below(256) as u8).collect();
                let (key, values) = if dice.below(2) == 0 {
                    ("totals", &mut model.totals)
                } else {
                    ("ages", &mut model.ages)
                };
                bytemuck::cast_slice_mut(values)[offset..offset + len].copy_from_slice(&bytes);
                let resource = id(&run, key);
                run.upload(resource, offset as u64, &bytes).unwrap();
                1 + usize::from(is_large)
            }
            11..=15 => {
                together += usize::from(open.is_some());
                let encoder = open.get_or_insert_with(|| engine.encoder());
                run.record(encoder).unwrap();
                model.frame();
                3
            }
            18 => {
                run.run().unwrap();
                model.frame();
                4
            }
            19 => {
                run.run_step(step).unwrap();
                model.add();
                5
            }
            20 if dice.below(4) == 0 => {
                run.reset().unwrap();
                model.reset();
                6
            }
            20 => {
                run.adopt(Arc::clone(&schedule)).unwrap();
                7
            }
            _ => {
                assert!(read(&mut run, "totals") == model.totals, "call {call}");
                assert!(read(&mut run, "ages") == model.ages, "call {call}");
                8
            }
        };
        counts[what] += 1;
    }
    assert!(counts[..9].iter().all(|&n| n > 5), "{counts:?}");
    assert!(
        together > 50,
        "{together} frames with another in one submission"
    );
}
