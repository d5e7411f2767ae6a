//! Acceleration structures, built from the triangles and the instances that the host uploads.
//!
//! A top level stays for as long as the executable, so that descriptor sets and recorded frames hold; bottom levels are
//! made anew with each build. A build is waited for: scenes change seldom, and its memory goes at once.
mod build;
mod object;

use crate::device::Device;
use crate::memory::Buffer;
use crate::stream::Stream;
use ash::vk;
use build::build;
use gibs_graph::{AccelerationSource, BackendError, ResourceId, Schedule};
use object::{Object, instances};
use std::sync::Arc;

/// Those of a schedule.
#[derive(Default)]
pub(crate) struct Structures(Vec<Structure>);

struct Structure {
    source: AccelerationSource,
    top: Object,
    bottoms: Vec<Object>,
}

impl Structures {
    /// Makes those of `schedule`, which the device allows.
    pub fn new(device: &Arc<Device>, schedule: &Schedule) -> Result<Self, BackendError> {
        let make = |source: AccelerationSource| {
            let resource = &schedule.resources[source.resource as usize];
            let ty = vk::AccelerationStructureTypeKHR::TOP_LEVEL;
            let geometry = instances(0, source.len());
            Ok(Structure {
                top: Object::new(device, &resource.key, ty, &geometry)?,
                source,
                bottoms: Vec::new(),
            })
        };
        let sources = AccelerationSource::all(schedule);
        let made: Result<_, _> = sources.into_iter().map(make).collect();
        made.map(Self)
    }

    fn find(&self, resource: ResourceId) -> Option<&Structure> {
        self.0.iter().find(|s| s.source.resource == resource)
    }

    /// What stages bind.
    pub fn top(&self, resource: ResourceId) -> Option<vk::AccelerationStructureKHR> {
        self.find(resource).map(|structure| structure.top.raw)
    }

    /// The instances that were uploaded; `None` for any other resource.
    pub fn read(&self, resource: ResourceId) -> Option<Vec<u8>> {
        let found = self.find(resource)?;
        Some(found.source.bytes().to_vec())
    }

    /// Takes notice of an upload, and keeps it where it is one of instances: whether it is.
    pub fn write(&mut self, resource: ResourceId, offset: u64, bytes: &[u8]) -> bool {
        let mut taken = false;
        for Structure { source, .. } in &mut self.0 {
            taken |= source.uploaded(resource, offset, bytes);
        }
        taken
    }

    /// Takes the instances of another schedule's structure.
    pub fn adopt(&mut self, to: ResourceId, old: &Self, from: ResourceId) {
        let adopted = old.find(from);
        for structure in self.0.iter_mut().filter(|s| s.source.resource == to) {
            if let Some(adopted) = adopted {
                structure.source.adopt(&adopted.source);
            }
        }
    }

    /// Whether structures are built from the memory of a resource.
    pub fn uses(&self, resource: ResourceId) -> bool {
        self.0.iter().any(|s| s.source.is_of(resource))
    }

    /// Some structure has to be built before the next frame.
    pub fn is_stale(&self) -> bool {
        self.0.iter().any(|structure| structure.source.stale)
    }

    /// Builds what has to be built, behind everything that was uploaded, and waits for it. `triangles` gives the buffer of
    /// a resource.
    pub fn build<'a>(
        &mut self,
        stream: &mut Stream,
        triangles: impl Fn(ResourceId) -> Option<&'a Buffer>,
    ) -> Result<(), BackendError> {
        let stale = self.0.iter_mut().filter(|structure| structure.source.stale);
        for structure in stale {
            let Some(corners) = triangles(structure.source.triangles) else {
                continue;
            };
            let plan = structure.source.plan()?;
            let made = build(stream, &plan, &structure.top, corners)?;
            // Whatever used the ones before was submitted before the build, which is done.
            structure.bottoms = made;
            structure.source.stale = false;
        }
        Ok(())
    }
}
