//! A compiled frame: plain data that any backend can run.
use crate::step::{Action, DispatchStep, Step};
use crate::{ImageFormat, Kind, Layout};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;

/// Index of a resource in [`Schedule::resources`].
pub type ResourceId = u32;

/// A compiled frame: what to allocate, and what to run in which order.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct Schedule {
    /// Name of the graph.
    pub name: String,
    /// Everything to allocate.
    pub resources: Vec<Resource>,
    /// Steps in execution order.
    pub steps: Vec<Step>,
    /// What the host reads after a frame.
    pub outputs: Vec<Output>,
    /// Labels of stages that nothing needs, and that were left out.
    pub removed: Vec<String>,
    /// Every dependency between steps, once, whether a barrier settles it already or not, as `(earlier, later, resource)`.
    pub edges: Vec<(u32, u32, ResourceId)>,
}

/// One resource.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Resource {
    /// Key or name, unique in the schedule.
    pub key: String,
    /// Lifetime and first content.
    pub kind: Kind,
    /// Type of one element.
    pub element: Layout,
    /// Number of elements.
    pub len: u64,
    /// Bytes of one allocation; a history has two. Of an image, those of its values.
    pub bytes: u64,
    /// Size and texels of an image; `None` for a buffer.
    pub image: Option<ImageShape>,
    /// Of an acceleration structure, the input with its triangles; `None` for anything else.
    pub triangles: Option<ResourceId>,
    /// The resource whose memory this one uses, itself unless it shares. Resources that share are never in use at the
    /// same time.
    pub home: ResourceId,
    /// Bytes to allocate: enough for everything that is at home here, 0 where this one is at home elsewhere.
    pub room: u64,
    /// How stages touch it.
    pub usage: Usage,
}

/// Size and texels of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ImageShape {
    /// How devices see it.
    pub format: ImageFormat,
    /// Width and height.
    pub size: [u32; 2],
}

/// How the stages of a schedule touch a resource.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct Usage {
    /// Bound as a uniform.
    pub uniform: bool,
    /// Bound as storage.
    pub storage: bool,
    /// Read as sizes of an indirect dispatch.
    pub indirect: bool,
    /// An image.
    pub image: bool,
    /// Bound as an acceleration structure.
    pub acceleration: bool,
    /// Read when an acceleration structure is built.
    pub triangles: bool,
    /// Seen by wide CPU kernels.
    pub host: bool,
}

impl Usage {
    /// A device needs an allocation for it.
    pub fn on_device(self) -> bool {
        let read = self.acceleration || self.triangles;
        self.uniform || self.storage || self.indirect || self.image || read
    }
}

/// Something the host reads after a frame.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Output {
    /// Name.
    pub name: String,
    /// Resource.
    pub resource: ResourceId,
}

impl Schedule {
    /// The resource with this key.
    pub fn resource(&self, key: &str) -> Option<ResourceId> {
        self.resources
            .iter()
            .position(|r| r.key == key)
            .map(|i| i as ResourceId)
    }

    /// The resource behind an output.
    pub fn output(&self, name: &str) -> Option<ResourceId> {
        self.outputs
            .iter()
            .find(|o| o.name == name)
            .map(|o| o.resource)
    }

    /// Bytes that a backend allocates for this schedule; with wide CPU data only where `host` is set.
    pub fn bytes(&self, host: bool) -> u64 {
        self.sum_bytes(host, |r| r.room)
    }

    /// Bytes that transients save by sharing memory.
    pub fn shared_bytes(&self) -> u64 {
        self.sum_bytes(true, |r| r.bytes) - self.bytes(true)
    }

    fn sum_bytes(&self, host: bool, bytes: impl Fn(&Resource) -> u64) -> u64 {
        let counted = self.resources.iter();
        counted
            .filter(|r| r.usage.on_device() || host)
            .map(|r| bytes(r).saturating_mul(r.kind.allocations()))
            .fold(0, u64::saturating_add)
    }

    /// Pairs `(old, new)` of persistent resources whose content carries over from `old`: key, kind with its initial
    /// value, type, length and image size agree. A state or a history may also have become longer: then what it held
    /// stays at its front, and the rest starts from the initial value.
    pub fn adoptions(&self, old: &Schedule) -> Vec<(ResourceId, ResourceId)> {
        let before: HashMap<&str, (ResourceId, &Resource)> = (0..)
            .zip(&old.resources)
            .map(|(id, r)| (r.key.as_str(), (id, r)))
            .collect();
        (0..)
            .zip(&self.resources)
            .filter(|(_, new)| new.kind.persists())
            .filter_map(|(id, new)| {
                let &(from, old) = before.get(new.key.as_str())?;
                let grows = new.kind != Kind::Input && old.len < new.len;
                let agrees = old.kind == new.kind
                    && old.element == new.element
                    && (old.len == new.len || grows)
                    && old.image == new.image;
                agrees.then_some((from, id))
            })
            .collect()
    }

    /// Steps that have to wait for earlier ones since the last that did: before each, a backend that records a frame ahead needs a
    /// barrier.
    pub fn barriers(&self) -> usize {
        let waiting = self.steps.iter().filter(|step| !step.hazards.is_empty());
        waiting.count()
    }

    /// The dispatch steps, with their index.
    pub fn dispatches(&self) -> impl Iterator<Item = (usize, &Step, &DispatchStep)> {
        self.steps
            .iter()
            .enumerate()
            .filter_map(|(i, step)| match &step.action {
                Action::Dispatch(dispatch) => Some((i, step, dispatch.as_ref())),
                Action::Clear(_) => None,
            })
    }
}
