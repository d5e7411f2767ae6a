//! Which handle stands for a resource: what a host lent, or else memory of the executable's own.
use crate::imports::{Import, Imports, layout};
use crate::storage::Stores;
use ash::vk;
use gibs_graph::ResourceId;

/// Own memory, and what stands in for it.
#[derive(Clone, Copy)]
pub(crate) struct Bound<'a> {
    pub stores: &'a Stores,
    pub imports: &'a Imports,
}

impl Bound<'_> {
    /// The buffer of a resource that frames of this parity change.
    pub fn buffer(self, resource: ResourceId, parity: usize) -> Option<vk::Buffer> {
        match self.imports.get(resource) {
            Some(Import::Buffer(buffer)) => Some(buffer),
            _ => Some(self.stores.buffer(resource, parity)?.raw),
        }
    }

    /// What rays are traced in.
    pub fn structure(self, resource: ResourceId) -> Option<vk::AccelerationStructureKHR> {
        self.stores.structures.top(resource)
    }

    /// The view of an image, and the layout in which stages see it.
    pub fn view(self, resource: ResourceId) -> Option<(vk::ImageView, vk::ImageLayout)> {
        match self.imports.get(resource) {
            Some(Import::Image { lent, stored }) => Some((lent.view, layout(stored))),
            _ => Some((self.stores.image(resource)?.view, vk::ImageLayout::GENERAL)),
        }
    }
}
