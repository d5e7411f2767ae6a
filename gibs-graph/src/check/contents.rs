//! What the resources of a schedule hold, on the host.
use super::Upload;
use super::compare::UNWRITTEN;
use crate::{BackendError, Executable, Kind, Resource, ResourceId, Schedule};

/// What the resources of a schedule hold.
#[derive(Clone)]
pub(crate) struct Contents {
    pub current: Vec<Vec<u8>>,
    /// Of histories.
    pub previous: Vec<Vec<u8>>,
}

impl Contents {
    /// What they start with.
    pub fn new(schedule: &Schedule) -> Self {
        let first = |resource: &Resource| match &resource.kind {
            Kind::State(initial) | Kind::History(initial) => initial.bytes(resource.bytes as usize),
            _ => vec![0; resource.bytes as usize],
        };
        let current: Vec<_> = schedule.resources.iter().map(first).collect();
        let resources = schedule.resources.iter().zip(&current);
        let previous = resources.map(|(resource, current)| match resource.kind {
            Kind::History(_) => current.clone(),
            _ => Vec::new(),
        });
        Self {
            previous: previous.collect(),
            current,
        }
    }

    /// What the host writes.
    pub fn write(&mut self, uploads: &[Upload]) {
        for upload in uploads {
            let from = upload.offset as usize;
            self.current[upload.resource as usize][from..from + upload.bytes.len()]
                .copy_from_slice(&upload.bytes);
        }
    }

    /// What a frame has changed for the next one.
    pub fn keep(
        &mut self,
        schedule: &Schedule,
        exec: &mut dyn Executable,
    ) -> Result<(), BackendError> {
        for (id, resource) in (0..).zip(&schedule.resources) {
            if matches!(resource.kind, Kind::State(_) | Kind::History(_)) {
                self.current[id as usize] = exec.read(id)?;
            }
        }
        Ok(())
    }

    /// Begins a frame.
    pub fn rotate(&mut self, schedule: &Schedule) {
        for (id, resource) in schedule.resources.iter().enumerate() {
            if let Kind::History(_) = resource.kind {
                std::mem::swap(&mut self.current[id], &mut self.previous[id]);
            }
        }
    }

    /// The contents of an isolated step's resources.
    pub fn of(&self, sources: &[(ResourceId, bool)]) -> Vec<&[u8]> {
        let one = |&(id, previous): &(ResourceId, bool)| match previous {
            true => self.previous[id as usize].as_slice(),
            false => self.current[id as usize].as_slice(),
        };
        sources.iter().map(one).collect()
    }
}

/// Resources that a frame starts without a value of, and what stands there until one is written.
pub(crate) fn poison(schedule: &Schedule) -> Vec<(ResourceId, Vec<u8>)> {
    let undefined = (0..).zip(&schedule.resources).filter(|(_, resource)| {
        matches!(resource.kind, Kind::Transient) && resource.image.is_none()
    });
    undefined
        .map(|(id, resource)| {
            let pattern = UNWRITTEN.to_ne_bytes().into_iter().cycle();
            (id, pattern.take(resource.bytes as usize).collect())
        })
        .collect()
}
