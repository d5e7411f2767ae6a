//! The buffers of a schedule: made, taken over, and set to their initial values.
use crate::device::Device;
use crate::memory::Buffer;
use crate::stream::Stream;
use gibs_graph::{BackendError, Initial, Kind, Resource, ResourceId, Schedule};
use std::sync::Arc;

/// The allocations of one resource. A history has two, of which frames of either parity take one as the current.
pub(crate) struct Store(Vec<Buffer>);

impl Store {
    /// Fresh allocations, undefined.
    pub fn new(device: &Arc<Device>, resource: &Resource) -> Result<Self, BackendError> {
        let count = if matches!(resource.kind, Kind::History(_)) {
            2
        } else {
            1
        };
        (0..count)
            .map(|_| Buffer::resource(device, &resource.key, resource.bytes))
            .collect::<Result<_, _>>()
            .map(Self)
    }

    /// The allocation that frames of this parity change.
    pub fn current(&self, parity: usize) -> &Buffer {
        &self.0[parity % self.0.len()]
    }

    /// The other one: the value of the frame before.
    pub fn previous(&self, parity: usize) -> &Buffer {
        self.current(parity + 1)
    }

    /// Exchanges the allocations, so that what was current for odd parities is so for even ones.
    pub fn swap(&mut self) {
        self.0.reverse();
    }

    /// Sets every allocation to the first value of its kind.
    pub fn initialize(&self, stream: &mut Stream, resource: &Resource) -> Result<(), BackendError> {
        let zero = Initial::Zero;
        let initial = match &resource.kind {
            Kind::State(initial) | Kind::History(initial) => initial,
            Kind::Input | Kind::Transient | Kind::Zeroed => &zero,
        };
        let word = repeated_word(initial);
        for buffer in &self.0 {
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
        Initial::Sequence => None,
        Initial::Fill(element) => {
            let (words, rest) = element.as_chunks::<4>();
            let first = *words.first()?;
            let same = rest.is_empty() && words.iter().all(|word| *word == first);
            same.then(|| u32::from_ne_bytes(first))
        }
    }
}

/// Puts one store per resource of `schedule` that the device touches into `stores`. `adopted` gives those that are
/// taken over; all others are made and set to their first value. After an error, `stores` holds what the stream may
/// already be working on.
pub(crate) fn allocate(
    device: &Arc<Device>,
    schedule: &Schedule,
    mut adopted: Vec<(ResourceId, Store)>,
    stream: &mut Stream,
    stores: &mut Vec<Option<Store>>,
) -> Result<(), BackendError> {
    for (id, resource) in schedule.resources.iter().enumerate() {
        let taken = adopted.iter().position(|(to, _)| *to as usize == id);
        if !resource.usage.on_device() {
            stores.push(None);
        } else if let Some(taken) = taken {
            stores.push(Some(adopted.swap_remove(taken).1));
        } else {
            let store = Store::new(device, resource)?;
            let initialized = store.initialize(stream, resource);
            stores.push(Some(store));
            initialized?;
        }
    }
    Ok(())
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
