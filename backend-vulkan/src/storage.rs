//! The memory of a schedule's resources: made, taken over, and set to initial values.
use crate::device::Device;
use crate::image::Image;
use crate::memory::Buffer;
use crate::stream::Stream;
use crate::structures::Structures;
use gibs_graph::{BackendError, Initial, Kind, Resource, ResourceId, Schedule};
use std::sync::Arc;

/// The memory of one resource.
pub(crate) enum Store {
    /// Of a history two buffers, of which frames of either parity take one as the current.
    Buffers(Vec<Buffer>),
    /// Made when it is first needed: a host that provides the image pays for no other.
    Image(Option<Image>),
}

impl Store {
    /// Fresh memory, undefined.
    fn new(device: &Arc<Device>, resource: &Resource) -> Result<Self, BackendError> {
        if resource.image.is_some() {
            return Ok(Self::Image(None));
        }
        (0..resource.kind.allocations())
            .map(|_| {
                let built_from = resource.usage.triangles;
                Buffer::resource(device, &resource.key, resource.room, built_from)
            })
            .collect::<Result<_, _>>()
            .map(Self::Buffers)
    }

    /// Sets every buffer to the first value of its kind. An image starts at zero when it is made.
    fn initialize(&self, stream: &mut Stream, resource: &Resource) -> Result<(), BackendError> {
        let Self::Buffers(buffers) = self else {
            return Ok(());
        };
        let zero = Initial::Zero;
        let initial = match &resource.kind {
            Kind::State(initial) | Kind::History(initial) => initial,
            _ => &zero,
        };
        let word = repeated_word(initial);
        for buffer in buffers {
            stream.fill(buffer, word.unwrap_or(0))?;
            if word.is_none() {
                stream.write(buffer, 0, &initial.bytes(resource.bytes as usize))?;
            }
        }
        Ok(())
    }
}

/// The value as one repeated word, which the device can write by itself.
fn repeated_word(initial: &Initial) -> Option<u32> {
    match initial {
        Initial::Zero => Some(0),
        Initial::Fill(element) => {
            let (words, rest) = element.as_chunks::<4>();
            let first = *words.first()?;
            let same = rest.is_empty() && words.iter().all(|word| *word == first);
            same.then(|| u32::from_ne_bytes(first))
        }
        _ => None,
    }
}

/// The memory of all resources of a schedule.
pub(crate) struct Stores {
    /// Of each resource; `None` where the device has none, or it is at home elsewhere.
    stores: Vec<Option<Store>>,
    /// Of each resource, the one whose memory it uses.
    homes: Vec<ResourceId>,
    /// Acceleration structures.
    pub structures: Structures,
}

impl Stores {
    /// Room for the memory of `schedule`, none of which is there yet.
    pub fn new(schedule: &Schedule) -> Self {
        Self {
            stores: Vec::with_capacity(schedule.resources.len()),
            homes: schedule.resources.iter().map(|r| r.home).collect(),
            structures: Structures::default(),
        }
    }

    /// Makes memory for everything in `schedule` that the device touches, and sets it to its first value. After an error,
    /// this holds what the stream may already be working on.
    pub fn fill(&mut self, schedule: &Schedule, stream: &mut Stream) -> Result<(), BackendError> {
        self.structures = Structures::new(&stream.device, schedule)?;
        for (id, resource) in schedule.resources.iter().enumerate() {
            let is_structure = resource.usage.acceleration;
            if !resource.usage.on_device() || is_structure || resource.home as usize != id {
                self.stores.push(None);
            } else {
                let store = Store::new(&stream.device, resource)?;
                let initialized = store.initialize(stream, resource);
                self.stores.push(Some(store));
                initialized?;
            }
        }
        Ok(())
    }

    /// The buffer that frames of this parity change.
    pub fn buffer(&self, resource: ResourceId, parity: usize) -> Option<&Buffer> {
        let home = *self.homes.get(resource as usize)?;
        match self.stores.get(home as usize)? {
            Some(Store::Buffers(buffers)) => buffers.get(parity % buffers.len().max(1)),
            _ => None,
        }
    }

    /// The image, if it was made.
    pub fn image(&self, resource: ResourceId) -> Option<&Image> {
        match self.stores.get(resource as usize)? {
            Some(Store::Image(image)) => image.as_ref(),
            _ => None,
        }
    }

    /// Makes the image of a resource that has one, if it is not there yet, and has it set to zero with what is
    /// recorded next.
    pub fn make_image(
        &mut self,
        id: ResourceId,
        resource: &Resource,
        stream: &mut Stream,
    ) -> Result<(), BackendError> {
        let (Some(Some(Store::Image(image @ None))), Some(shape)) =
            (self.stores.get_mut(id as usize), resource.image)
        else {
            return Ok(());
        };
        let made = image.insert(Image::new(&stream.device, &resource.key, shape)?);
        stream.pending.zero(made);
        Ok(())
    }

    /// Builds the acceleration structures that have to be, and waits for them.
    pub fn build_structures(&mut self, stream: &mut Stream) -> Result<(), BackendError> {
        if !self.structures.is_stale() {
            return Ok(());
        }
        let mut structures = std::mem::take(&mut self.structures);
        let built = structures.build(stream, |resource| self.buffer(resource, 0));
        self.structures = structures;
        built
    }

    /// Takes an image, if it was made, from the memory of another schedule.
    pub fn take_image(&mut self, to: ResourceId, old: &mut Self, from: ResourceId) {
        if let (Some(Some(Store::Image(new))), Some(Some(Store::Image(old)))) = (
            self.stores.get_mut(to as usize),
            old.stores.get_mut(from as usize),
        ) {
            *new = old.take();
        }
    }

    /// Sets states and histories to their first value.
    pub fn reset(&self, schedule: &Schedule, stream: &mut Stream) -> Result<(), BackendError> {
        for (store, resource) in self.stores.iter().zip(&schedule.resources) {
            if let (Some(store), Kind::State(_) | Kind::History(_)) = (store, &resource.kind) {
                store.initialize(stream, resource)?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_repeated_words_are_filled_by_the_device() {
        assert_eq!(repeated_word(&Initial::Zero), Some(0));
        assert_eq!(repeated_word(&Initial::Sequence), None);
        assert_eq!(repeated_word(&Initial::fill(u32::MAX)), Some(u32::MAX));
        assert_eq!(repeated_word(&Initial::fill([7u32, 7, 7])), Some(7));
        assert_eq!(repeated_word(&Initial::fill([7u32, 7, 8])), None);
        assert_eq!(repeated_word(&Initial::Fill(vec![1, 2])), None);
        assert_eq!(repeated_word(&Initial::Fill(Vec::new())), None);
    }
}
