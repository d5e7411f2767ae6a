//! What a step only reads: it has to be as it was when the step is over.
use super::Capture;
use super::compare::{Comparison, compare};
use super::judge::tally;
use super::lockstep::{Lockstep, places, written};
use crate::{Access, Action, BackendError, Comparator, Kind, ResourceId, Schedule, Step};

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

impl<'a> Lockstep<'a> {
    /// Sees whether the participants have left alike what the step only reads, while `contents` are still those before it.
    pub(super) fn look_after(
        &mut self,
        case: &str,
        frame: u32,
        index: usize,
        outputs: &[Vec<Vec<u8>>],
        captures: &mut Vec<Capture>,
    ) -> Result<(), (&'a str, BackendError)> {
        let schedule = self.schedule.clone();
        let mut differs = None;
        let mut found_there = Vec::new();
        for read in only_read(&schedule, index) {
            let lanes = self.read(read.resource)?;
            let resource = &schedule.resources[read.resource as usize];
            let step = self.report.steps.iter_mut().find(|r| r.step == index);
            let ports = step.map(|step| &mut step.ports);
            let port = ports.and_then(|ports| ports.iter_mut().find(|p| p.port == read.port));
            for pair in port.into_iter().flat_map(|port| &mut port.pairs) {
                let [a, b] = places(self.participants, pair);
                let found = match lanes[a] == lanes[b] && lanes[a].len() as u64 == resource.bytes {
                    true => Comparison {
                        elements: resource.len,
                        ..Comparison::default()
                    },
                    false => compare(
                        &resource.element,
                        resource.len,
                        &UNTOUCHED,
                        &lanes[a],
                        &lanes[b],
                        &[],
                    ),
                };
                if tally(pair, frame, found, 0) {
                    differs.get_or_insert((a, b));
                }
            }
            found_there.push((read.resource, lanes));
        }
        if let Some((a, b)) = differs {
            self.keep_capture(case, frame, index, outputs, [a, b], captures);
        }
        for (resource, lanes) in found_there {
            self.settle_one(resource, lanes)
                .map_err(|source| ("all", source))?;
        }
        Ok(())
    }
}
