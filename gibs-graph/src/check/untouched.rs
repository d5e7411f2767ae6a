//! What a step only reads: it has to be as it was when the step is over.
use super::lockstep::written;
use crate::{Access, Action, Comparator, Kind, ResourceId, Schedule, Step};

/// A port that a step only reads, and which is looked at after it.
pub(crate) struct OnlyRead {
    pub port: &'static str,
    pub resource: ResourceId,
}

/// How it is compared.
pub(crate) const UNTOUCHED: Comparator =
    Comparator::exact("a stage leaves as it is what it only reads").with_non_finite();

/// Bytes from which on an input is looked at once a frame.
const LARGE: u64 = 1 << 20;

/// What a step only reads. Large inputs, which nothing but the host writes, are looked at once a frame: after the last step
/// that binds them, where what any of them did to them still shows. The value that a history had before is not looked at, since
/// it cannot be read back; nor is what only wide CPU kernels see.
pub(crate) fn only_read(schedule: &Schedule, index: usize) -> Vec<OnlyRead> {
    let step = &schedule.steps[index];
    let Action::Dispatch(dispatch) = &step.action else {
        return Vec::new();
    };
    let mut found: Vec<OnlyRead> = Vec::new();
    for binding in &dispatch.bindings {
        let id = binding.resource;
        let comes_again = || {
            schedule.steps[index + 1..]
                .iter()
                .any(|later| reads(later, id))
        };
        let resource = &schedule.resources[id as usize];
        let waits = resource.kind == Kind::Input && resource.bytes >= LARGE;
        if reads(step, id)
            && !found.iter().any(|known| known.resource == id)
            && !(waits && comes_again())
        {
            found.push(OnlyRead {
                port: binding.port,
                resource: id,
            });
        }
    }
    found
}

/// Whether a step reads a resource, where that can be read back, and does not write it.
fn reads(step: &Step, id: ResourceId) -> bool {
    let Action::Dispatch(dispatch) = &step.action else {
        return false;
    };
    let bound = dispatch.bindings.iter().filter(|b| b.resource == id);
    let mut access = bound.map(|binding| binding.access);
    let is_read = |access| matches!(access, Access::Uniform | Access::Read | Access::Sampled);
    access.any(is_read) && written(step).iter().all(|written| written.resource != id)
}
