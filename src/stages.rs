//! Steps of the frame that belong together.
use gibs_graph::{Action, Schedule};

/// Group of steps whose label has none.
const OTHERS: &str = "others";

/// Positions of equal names, by their first appearance.
pub(crate) fn fold<T: PartialEq>(names: impl Iterator<Item = T>) -> Vec<(T, Vec<usize>)> {
    let mut folded: Vec<(T, Vec<usize>)> = Vec::new();
    for (position, name) in names.enumerate() {
        match folded.iter_mut().find(|(known, _)| *known == name) {
            Some((_, positions)) => positions.push(position),
            None => folded.push((name, vec![position])),
        }
    }
    folded
}

/// The group of a step: what its label has before the slash. A clear belongs to the stage that it comes right before.
pub(crate) fn group_of(schedule: &Schedule, step: usize) -> String {
    let mut from_here = schedule.steps.iter().skip(step);
    let stage = from_here.find(|step| matches!(step.action, Action::Dispatch(_)));
    let group = stage.and_then(|step| step.label.split_once('/'));
    group.map_or(OTHERS, |(group, _)| group).to_owned()
}

/// What steps are called that do the same at several places of a frame: the label without the group, without the
/// number of the repetition, and prefix sums and clears as one.
pub(crate) fn stage_of(label: &str) -> String {
    let Some((_, name)) = label.split_once('/') else {
        return label.split(' ').next().unwrap_or(label).to_owned();
    };
    let is_number = |part: &str| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit());
    let parts: Vec<&str> = name.split('_').filter(|part| !is_number(part)).collect();
    match parts.as_slice() {
        [before @ .., "blocks" | "sums" | "apply"]
            if matches!(before.last(), Some(&("scan" | "rank" | "bins"))) =>
        {
            before.join("_")
        }
        parts => parts.join("_"),
    }
}
