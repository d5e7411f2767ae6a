//! Which step has to wait for which.
use crate::step::{Hazard, HazardKind, Step};
use crate::{Access, Resource, ResourceId};

/// Fills in every step's hazards and returns all dependencies. A barrier before a step orders everything before it,
/// so a hazard counts only against steps since the last barrier.
///
/// Frames are ordered as wholes by who runs them, so neither a state nor the allocation that was current in the frame
/// before has a hazard against that frame.
///
/// Resources that share memory are one place here; a hazard between two of them is named after the later one.
pub(super) fn find_hazards(
    steps: &mut [Step],
    resources: &[Resource],
) -> Vec<(u32, u32, ResourceId)> {
    let mut writer: Vec<Option<u32>> = vec![None; resources.len()];
    let mut readers: Vec<Vec<u32>> = vec![Vec::new(); resources.len()];
    let mut fence = 0;
    let mut edges = Vec::new();
    for (i, step) in (0..).zip(steps) {
        step.hazards.clear();
        let mut touches = step.touches();
        // Reads of one resource through several ports are one touch.
        touches.retain(|(_, access)| *access != Access::Previous);
        touches.sort_by_key(|(resource, access)| (*resource, !access.writes()));
        touches.dedup_by_key(|(resource, _)| *resource);
        for &(resource, access) in &touches {
            let r = resources[resource as usize].home as usize;
            let after_write = writer[r].map(|after| (after, HazardKind::after_write(access)));
            let read = readers[r].iter().filter(|_| access.writes());
            let after_reads = read.map(|&after| (after, HazardKind::WriteAfterRead));
            for (after, kind) in after_write.into_iter().chain(after_reads) {
                edges.push((after, i, resource));
                if after >= fence {
                    step.hazards.push(Hazard {
                        resource,
                        after,
                        kind,
                    });
                }
            }
            if access.writes() {
                writer[r] = Some(i);
                readers[r].clear();
            } else {
                readers[r].push(i);
            }
        }
        if !step.hazards.is_empty() {
            fence = i;
        }
    }
    edges
}
