//! The contract of backends, as the one without a device keeps it.
mod common;

use common::*;
use gibs_graph::{
    Backend, BackendError, Capabilities, Executable, Graph, Initial, NullBackend, ResourceId,
    Schedule,
};
use std::sync::Arc;

/// An input `source`, a zeroed `sum`, a state `age` that starts as 5, a history `past` that starts as 0, 1, 2, ...; all
/// but the input are outputs.
fn frame(age: u64) -> Arc<Schedule> {
    let mut g = Graph::new("test");
    let source = g.input("source", LEN);
    let sum = g.zeroed("sum", LEN);
    let sum = pass_on(&mut g, "sum", &source, sum);
    let (age_state, value) = g.state("age", age, Initial::fill(5_u32));
    let value = pass_on(&mut g, "age", &source, value);
    let (past_state, before, target) = g.history("past", LEN, Initial::Sequence);
    let inputs = recall::Inputs {
        before: &before,
        target,
    };
    let past = g.add::<recall::Recall>("past", inputs, all()).target;
    g.output("sum", &sum);
    g.output("age", &value);
    g.output("past", &past);
    g.keep(age_state, value);
    g.keep(past_state, past);
    Arc::new(compiled(g))
}

fn prepared() -> Box<dyn Executable> {
    NullBackend::new().prepare(frame(LEN)).unwrap()
}

fn id(exec: &dyn Executable, key: &str) -> ResourceId {
    exec.schedule().resource(key).unwrap()
}

fn upload(exec: &mut dyn Executable, key: &str, first: usize, words: &[u32]) {
    let bytes: Vec<u8> = words.iter().flat_map(|w| w.to_ne_bytes()).collect();
    let id = id(exec, key);
    exec.upload(id, 4 * first as u64, &bytes).unwrap();
}

fn read(exec: &mut dyn Executable, key: &str) -> Vec<u32> {
    let id = id(exec, key);
    let bytes = exec.read(id).unwrap();
    let words = bytes.as_chunks::<4>().0.iter();
    words.map(|word| u32::from_ne_bytes(*word)).collect()
}

fn sequence() -> Vec<u32> {
    (0..LEN as u32).collect()
}

#[test]
fn uploads_replace_their_range_and_nothing_else() {
    let mut exec = prepared();
    assert_eq!(read(&mut *exec, "source"), [0; LEN as usize]);
    upload(&mut *exec, "source", 0, &sequence());
    upload(&mut *exec, "source", 98, &[7, 8]);
    upload(&mut *exec, "age", 1, &[9]);
    let source = read(&mut *exec, "source");
    assert_eq!(source[..98], sequence()[..98]);
    assert_eq!(source[98..], [7, 8]);
    assert_eq!(read(&mut *exec, "age")[..3], [5, 9, 5]);
    // Inputs and states stay over frames.
    exec.run().unwrap();
    exec.wait().unwrap();
    assert_eq!(read(&mut *exec, "source"), source);
    assert_eq!(read(&mut *exec, "age")[..3], [5, 9, 5]);
}

#[test]
fn what_is_out_of_range_is_refused_and_changes_nothing() {
    let mut exec = prepared();
    let source = id(&*exec, "source");
    let end = 4 * LEN;
    for (offset, len) in [(end, 1), (end - 3, 4), (0, end + 1), (u64::MAX, 1)] {
        let refused = exec.upload(source, offset, &vec![1; len as usize]);
        let range = matches!(&refused, Err(BackendError::Range { resource, bytes, .. })
            if resource == "source" && *bytes == end);
        assert!(range, "{offset} + {len}: {refused:?}");
    }
    exec.upload(source, end, &[]).unwrap();
    assert_eq!(read(&mut *exec, "source"), [0; LEN as usize]);
    let refused = |error| matches!(error, BackendError::Refused { .. });
    assert!(exec.upload(1000, 0, &[]).is_err_and(refused));
    assert!(exec.read(1000).is_err_and(refused));
    let steps = exec.schedule().steps.len();
    exec.run_step(steps - 1).unwrap();
    assert!(matches!(
        exec.run_step(steps),
        Err(BackendError::Refused { .. })
    ));
}

#[test]
fn clears_happen_in_a_frame() {
    let mut exec = prepared();
    upload(&mut *exec, "sum", 0, &[3]);
    assert_eq!(read(&mut *exec, "sum")[0], 3);
    exec.run().unwrap();
    assert_eq!(read(&mut *exec, "sum"), [0; LEN as usize]);
    upload(&mut *exec, "sum", 0, &[3]);
    let (clear, _) = step(&frame(LEN), "clear sum");
    for step in 0..exec.schedule().steps.len() {
        let before = read(&mut *exec, "sum")[0];
        exec.run_step(step).unwrap();
        let expected = if step == clear { 0 } else { before };
        assert_eq!(read(&mut *exec, "sum")[0], expected, "step {step}");
    }
}

#[test]
fn histories_rotate_in_a_frame_and_not_in_a_step() {
    let mut exec = prepared();
    assert_eq!(read(&mut *exec, "past"), sequence());
    upload(&mut *exec, "past", 0, &[100]);
    let (past, _) = step(&frame(LEN), "past");
    exec.run_step(past).unwrap();
    assert_eq!(read(&mut *exec, "past")[..2], [100, 1]);
    exec.run().unwrap();
    assert_eq!(read(&mut *exec, "past"), sequence());
    upload(&mut *exec, "past", 0, &[200]);
    exec.run().unwrap();
    assert_eq!(read(&mut *exec, "past")[..2], [100, 1]);
    exec.run().unwrap();
    assert_eq!(read(&mut *exec, "past")[..2], [200, 1]);
}

#[test]
fn reset_brings_back_initial_values_and_leaves_inputs() {
    for frames in 0..3 {
        let mut exec = prepared();
        upload(&mut *exec, "source", 0, &[3]);
        upload(&mut *exec, "age", 0, &[4]);
        upload(&mut *exec, "past", 0, &[100]);
        for _ in 0..frames {
            exec.run().unwrap();
            upload(&mut *exec, "past", 0, &[100]);
        }
        exec.reset().unwrap();
        assert_eq!(read(&mut *exec, "source")[0], 3);
        assert_eq!(read(&mut *exec, "age"), [5; LEN as usize]);
        // Both allocations.
        assert_eq!(read(&mut *exec, "past"), sequence());
        exec.run().unwrap();
        assert_eq!(read(&mut *exec, "past"), sequence());
    }
}

#[test]
fn what_agrees_is_adopted_by_key() {
    let mut old = prepared();
    upload(&mut *old, "source", 0, &[3]);
    upload(&mut *old, "age", 0, &[4]);
    upload(&mut *old, "past", 0, &[100]);
    old.run().unwrap();
    upload(&mut *old, "past", 0, &[200]);
    upload(&mut *old, "sum", 0, &[6]);
    // A shorter `age` starts anew.
    let mut new = old;
    new.adopt(frame(LEN - 1)).unwrap();
    assert_eq!(read(&mut *new, "source")[0], 3);
    assert_eq!(read(&mut *new, "age"), [5; LEN as usize - 1]);
    assert_eq!(read(&mut *new, "sum")[0], 0);
    assert_eq!(read(&mut *new, "past")[0], 200);
    new.run().unwrap();
    assert_eq!(read(&mut *new, "past")[0], 100);
}

/// A backend that allows so many bytes per storage binding, and so many of those per stage.
fn limited(bytes: u64, buffers: u32) -> NullBackend {
    let mut capabilities = Capabilities::unlimited();
    capabilities.storage_binding = bytes;
    capabilities.storage_buffers = buffers;
    NullBackend::with_capabilities(capabilities)
}

#[test]
fn limits_are_held() {
    let prepare = |bytes, buffers| {
        let backend = limited(bytes, buffers);
        assert_eq!(backend.capabilities().storage_binding, bytes);
        backend.prepare(frame(LEN)).err()
    };
    assert!(prepare(4 * LEN, 2).is_none());
    let limit = |error: Option<BackendError>| match error {
        Some(BackendError::Limit {
            what, need, limit, ..
        }) => (what, need, limit),
        other => panic!("{other:?}"),
    };
    let (what, need, most) = limit(prepare(4 * LEN - 1, 2));
    assert!(what.contains("`source`"), "{what}");
    assert_eq!((need, most), (4 * LEN, 4 * LEN - 1));
    let (what, need, most) = limit(prepare(4 * LEN, 1));
    assert!(what.contains("stage `sum`"), "{what}");
    assert_eq!((need, most), (2, 1));
}

/// Uniforms and data of wide CPU kernels are no storage buffers.
#[test]
fn limits_count_what_devices_bind() {
    let mut g = Graph::new("test");
    let batch = g.input("batch", 1);
    let extra = g.input("extra", LEN);
    let target = g.zeroed("target", LEN);
    let inputs = batched::Inputs {
        batch: &batch,
        target,
    };
    let target = g.add::<batched::Batched>("batched", inputs, all()).target;
    let inputs = hosted::Inputs {
        extra: &extra,
        target,
    };
    let target = g.add::<hosted::Hosted>("hosted", inputs, all()).target;
    g.output("target", &target);
    let schedule = Arc::new(compiled(g));
    let prepare = |buffers| {
        let backend = limited(u64::MAX, buffers);
        backend.prepare(Arc::clone(&schedule))
    };
    assert!(prepare(1).is_ok());
    assert!(prepare(0).is_err());
}

/// A schedule that no machine has memory for is prepared; touching it is an error and not the end of the process.
#[test]
fn memory_is_taken_when_touched() {
    let mut g = Graph::new("test");
    let huge = g.input::<[u32; 4]>("huge", u64::MAX);
    let small = g.input::<u32>("small", 1);
    g.output("huge", &huge);
    g.output("small", &small);
    let backend = NullBackend::new();
    let mut exec = backend.prepare(Arc::new(compiled(g))).unwrap();
    upload(&mut *exec, "small", 0, &[1]);
    exec.run().unwrap();
    assert_eq!(read(&mut *exec, "small"), [1]);
    let oom =
        |error| matches!(error, BackendError::OutOfMemory { resource, .. } if resource == "huge");
    assert!(exec.read(0).is_err_and(oom));
    assert!(exec.upload(0, 0, &[1]).is_err_and(oom));
}
