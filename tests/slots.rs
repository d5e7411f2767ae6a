//! The check of slots on the device: silent on sound slots, and it counts what is planted.
mod common;

use common::{all_backends, settings};
use gibs::passes::data::SurfelCounters;
use gibs::passes::frame::Settings;
use gibs::{Counters, Renderer, builtin};

const CAPACITY: u32 = 512;

/// What the check finds in the frame after the free stack and the counters were changed by `damage`.
fn counted(
    backend: &dyn gibs::graph::Backend,
    damage: impl Fn(&mut [u32], &mut SurfelCounters),
) -> Counters {
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    let settings = Settings {
        surfels: CAPACITY,
        check_slots: true,
        ..settings(500)
    };
    let mut renderer = Renderer::new(backend, &scene, &view, [64, 64], &settings, 0)
        .unwrap_or_else(|e| panic!("{}: {e}", backend.name()));
    renderer.frame().expect("a frame");
    let before = renderer.counters().expect("counters");
    assert_eq!(before.slot_errors, Some(0), "{}", backend.name());
    assert!(before.live > 0 && before.live < CAPACITY / 2, "{before:?}");
    let exec = renderer.executable();
    let [stack, counters] = ["surfel_free_slots", "surfel_counters"]
        .map(|key| exec.schedule().resource(key).expect("a state"));
    let mut slots: Vec<u32> = bytemuck::pod_collect_to_vec(&exec.read(stack).expect("read"));
    let mut count: SurfelCounters =
        bytemuck::pod_read_unaligned(&exec.read(counters).expect("read"));
    damage(&mut slots, &mut count);
    exec.upload(stack, 0, bytemuck::cast_slice(&slots))
        .expect("written");
    exec.upload(counters, 0, bytemuck::bytes_of(&count))
        .expect("written");
    renderer.frame().expect("a frame");
    renderer.counters().expect("counters")
}

#[test]
fn what_is_planted_is_counted() {
    let end = CAPACITY as usize - 1;
    for backend in all_backends() {
        let errors = |damage: &dyn Fn(&mut [u32], &mut SurfelCounters)| {
            counted(backend.as_ref(), damage).slot_errors
        };
        let name = backend.name();
        assert_eq!(errors(&|_, _| ()), Some(0), "{name}: sound slots");
        // Births take from the front, so that the end of the stack stays what it was made.
        let double_free = |slots: &mut [u32], _: &mut SurfelCounters| slots[end] = slots[end - 1];
        assert_eq!(
            errors(&double_free),
            Some(2),
            "{name}: one slot twice, one lost"
        );
        let in_use = |slots: &mut [u32], _: &mut SurfelCounters| slots[end] = slots[0];
        assert_eq!(
            errors(&in_use),
            Some(2),
            "{name}: one slot free and in use, one lost"
        );
        let nowhere = |slots: &mut [u32], _: &mut SurfelCounters| slots[end] = u32::MAX;
        assert_eq!(
            errors(&nowhere),
            Some(1),
            "{name}: a place that names no slot"
        );
        // One slot more than is in use counts as in use: the next birth skips it.
        let leak = |_: &mut [u32], counters: &mut SurfelCounters| counters.live += 3;
        assert_eq!(errors(&leak), Some(3), "{name}: three slots lost");
    }
}

/// Nobody pays for the check unasked.
#[test]
fn without_the_setting_there_is_no_check() {
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    let backend = common::cpu();
    let mut renderer = Renderer::new(backend.as_ref(), &scene, &view, [16, 16], &settings(100), 0)
        .expect("prepares");
    renderer.frame().expect("a frame");
    assert_eq!(renderer.counters().expect("counters").slot_errors, None);
    let schedule = renderer.gi().schedule().clone();
    assert!(schedule.resource("slot_marks").is_none());
    assert!(
        !schedule
            .steps
            .iter()
            .any(|step| step.label.starts_with("check/"))
    );
}
