//! The check of the slots (S4): stages of the group `check`, which are there where it is asked for.
use super::Surfels;
use crate::data::*;
use crate::stages::*;
use gibs_graph::{Buffer, Dispatch, Graph};

/// Counts slots that are not exactly one of free and live, in the output `slot_errors`.
pub(super) fn check_slots(
    g: &mut Graph,
    settings: &Buffer<SurfelSettings>,
    surfels: &Surfels,
    counters: &Buffer<SurfelCounters>,
    free_slots: &Buffer<u32>,
) {
    let slots = free_slots.len();
    let marks = g.zeroed("slot_marks", slots);
    let marked = g.add::<mark_slots::MarkSlots>(
        "check/mark_slots",
        mark_slots::Inputs {
            settings,
            poses: &surfels.poses,
            counters,
            free_slots,
            marks,
        },
        Dispatch::Elements(slots),
    );
    let errors = g.zeroed("slot_errors", 1);
    let inputs = count_slots::Inputs {
        settings,
        marks: &marked.marks,
        errors,
    };
    let counted =
        g.add::<count_slots::CountSlots>("check/count_slots", inputs, Dispatch::Elements(slots));
    g.output("slot_errors", &counted.errors);
}
