//! Where the resources of a schedule are: memory of the backend, or what a host gave.
use crate::buffers::{Allocation, Parity};
use crate::context::Context;
use crate::images::Image;
use crate::structures::Structures;
use gibs_graph::{BackendError, Kind, Resource, ResourceId, Schedule};
use std::sync::Arc;

/// What a host gave for a resource.
#[derive(Clone, PartialEq)]
pub(crate) enum Import {
    Image(wgpu::TextureView),
    Buffer(wgpu::Buffer),
}

/// Memory of every resource.
pub(crate) struct Stores {
    schedule: Arc<Schedule>,
    /// Per resource; empty for an image, and for what is at home elsewhere.
    pub allocations: Vec<Allocation>,
    /// Images of the backend's own, made when one is needed.
    images: Vec<Option<Image>>,
    pub structures: Structures,
    imports: Vec<Option<Import>>,
}

impl Stores {
    /// Shares with `old` what both schedules keep, and allocates the rest; what has become longer begins with a copy of
    /// what it held. `old` stays as it is.
    pub fn new(
        context: &Context,
        schedule: &Arc<Schedule>,
        old: Option<(&Stores, Parity)>,
    ) -> Result<Self, BackendError> {
        let count = schedule.resources.len();
        let mut adopted: Vec<Option<(Allocation, u64)>> = vec![None; count];
        let mut images: Vec<Option<Image>> = vec![None; count];
        if let Some((old, parity)) = old {
            for (from, to) in schedule.adoptions(&old.schedule) {
                let (from, to) = (from as usize, to as usize);
                images[to] = old.images[from].clone();
                let allocation = old.allocations[from].clone();
                if allocation.is_on_device() && schedule.resources[to].usage.on_device() {
                    let bytes = old.schedule.resources[from].bytes;
                    adopted[to] = Some((allocation.rebase(parity), bytes));
                }
            }
        }
        let allocate = |(resource, old): (&Resource, Option<(Allocation, u64)>)| match old {
            Some((old, bytes)) if bytes == resource.bytes => Ok(old),
            Some((old, bytes)) => {
                let made = Allocation::new(context, resource)?;
                made.begin_with(context, &old, bytes)?;
                Ok(made)
            }
            None => Allocation::new(context, resource),
        };
        let resources = schedule.resources.iter().zip(adopted);
        let allocations = resources.map(allocate).collect::<Result<_, _>>()?;
        Ok(Self {
            schedule: Arc::clone(schedule),
            allocations,
            images,
            structures: Structures::new(
                context,
                schedule,
                old.map(|(old, _)| (&old.structures, &*old.schedule)),
            )?,
            imports: vec![None; count],
        })
    }

    /// What the frame of this parity writes, or has written.
    pub fn current(&self, resource: ResourceId, parity: Parity) -> Option<&wgpu::Buffer> {
        let found = self.schedule.resources.get(resource as usize)?;
        match &self.imports[resource as usize] {
            Some(Import::Buffer(buffer)) => Some(buffer),
            _ => self.allocations[found.home as usize].current(parity),
        }
    }

    /// The value of the frame before.
    pub fn previous(&self, resource: ResourceId, parity: Parity) -> Option<&wgpu::Buffer> {
        self.allocations[resource as usize].previous(parity)
    }

    /// The buffers of a resource depend on the parity.
    pub fn is_history(&self, resource: ResourceId) -> bool {
        self.allocations[resource as usize].is_history()
    }

    /// The view of an image.
    pub fn view(&self, resource: ResourceId) -> Option<&wgpu::TextureView> {
        match &self.imports[resource as usize] {
            Some(Import::Image(view)) => Some(view),
            _ => self.images[resource as usize].as_ref().map(|i| &i.view),
        }
    }

    /// The backend's own image of a resource, made if it is not there; `None` for a buffer.
    pub fn own_image(
        &mut self,
        context: &Context,
        resource: ResourceId,
    ) -> Result<Option<&Image>, BackendError> {
        let found = &self.schedule.resources[resource as usize];
        let Some(shape) = found.image else {
            return Ok(None);
        };
        let place = &mut self.images[resource as usize];
        if place.is_none() {
            *place = Some(Image::new(context, found, shape)?);
        }
        Ok(place.as_ref())
    }

    /// Records the builds of acceleration structures that wait.
    pub fn record_structures(&mut self, encoder: &mut wgpu::CommandEncoder) {
        let mut structures = std::mem::take(&mut self.structures);
        structures.record(self, encoder);
        self.structures = structures;
    }

    /// What a host gave for a resource.
    pub fn import(&self, resource: ResourceId) -> Option<&Import> {
        self.imports.get(resource as usize)?.as_ref()
    }

    /// Takes what a host gives for a resource; whether it is another one than before.
    pub fn set_import(
        &mut self,
        resource: ResourceId,
        import: Import,
    ) -> Result<bool, BackendError> {
        let refuse = |reason: String, remedy: &str| BackendError::Refused {
            what: match self.schedule.resources.get(resource as usize) {
                Some(found) => format!("importing `{}`", found.key),
                None => format!("importing resource {resource}"),
            },
            reason,
            remedy: remedy.into(),
        };
        let Some(found) = self.schedule.resources.get(resource as usize) else {
            return Err(refuse(
                "the schedule has no such resource".into(),
                "take the number from `Schedule::resource`",
            ));
        };
        let is_output = self.schedule.outputs.iter().any(|o| o.resource == resource);
        if found.kind != Kind::Input && !(found.kind == Kind::Transient && is_output) {
            return Err(refuse(
                "only inputs and transient outputs can be a host's".into(),
                "leave states and histories to the backend",
            ));
        }
        if self.structures.uses(resource) {
            return Err(refuse(
                "an acceleration structure is built from what is uploaded to it".into(),
                "upload its content",
            ));
        }
        match (&import, found.image) {
            (Import::Image(view), Some(shape)) => {
                let size = view.texture().size();
                if [size.width, size.height] != shape.size {
                    return Err(refuse(
                        format!(
                            "the image has {}x{} texels, the graph was recorded for {}x{}",
                            size.width, size.height, shape.size[0], shape.size[1]
                        ),
                        "give one of that size, or record the graph anew",
                    ));
                }
            }
            (Import::Buffer(buffer), None) => {
                if buffer.size() < found.bytes {
                    return Err(refuse(
                        format!(
                            "the buffer has {} bytes, {} are needed",
                            buffer.size(),
                            found.bytes
                        ),
                        "give a larger one",
                    ));
                }
            }
            (Import::Image(_), None) => {
                return Err(refuse("it is a buffer".into(), "use `import_buffer`"));
            }
            (Import::Buffer(_), Some(_)) => {
                return Err(refuse("it is an image".into(), "use `import_image`"));
            }
        }
        let place = &mut self.imports[resource as usize];
        let changed = place.as_ref() != Some(&import);
        *place = Some(import);
        Ok(changed)
    }
}
