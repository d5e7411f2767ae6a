//! Where descriptor sets come from: one pool for own memory, and as many as it takes for what hosts lend.
use crate::device::Device;
use ash::vk;
use gibs_graph::BackendError;
use std::sync::Arc;

const KINDS: [vk::DescriptorType; 5] = [
    vk::DescriptorType::STORAGE_BUFFER,
    vk::DescriptorType::UNIFORM_BUFFER,
    vk::DescriptorType::SAMPLED_IMAGE,
    vk::DescriptorType::STORAGE_IMAGE,
    vk::DescriptorType::ACCELERATION_STRUCTURE_KHR,
];

/// Sets, and the descriptors in them, of each of [`KINDS`].
#[derive(Clone, Copy, Default)]
pub(crate) struct Need {
    sets: u32,
    kinds: [u32; KINDS.len()],
}

impl Need {
    /// Of one set with descriptors of these kinds.
    pub fn of(kinds: impl Iterator<Item = vk::DescriptorType>) -> Self {
        let mut need = Self {
            sets: 1,
            ..Self::default()
        };
        for kind in kinds {
            for (count, of) in need.kinds.iter_mut().zip(KINDS) {
                *count += u32::from(of == kind);
            }
        }
        need
    }

    /// As much as `other` `times` times, more.
    pub fn add(&mut self, other: Self, times: u32) {
        self.sets += times * other.sets;
        for (count, other) in self.kinds.iter_mut().zip(other.kinds) {
            *count += times * other;
        }
    }
}

/// Pools for descriptor sets.
pub(crate) struct Pools {
    own: vk::DescriptorPool,
    lent: Vec<vk::DescriptorPool>,
    /// Index of the pool in `lent` that has room; of the next one to make where there is none.
    open: usize,
    /// Of one pool in `lent`.
    need: Need,
    device: Arc<Device>,
}

impl Pools {
    /// Room for `own` sets that bind own memory, and for others in steps of `lent`.
    pub fn new(device: &Arc<Device>, own: Need, lent: Need) -> Result<Self, BackendError> {
        Ok(Self {
            own: create(device, own)?,
            lent: Vec::new(),
            open: 0,
            need: lent,
            device: Arc::clone(device),
        })
    }

    /// A new set.
    pub fn allocate(
        &mut self,
        layout: vk::DescriptorSetLayout,
        lent: bool,
    ) -> Result<vk::DescriptorSet, BackendError> {
        if !lent {
            return self.try_allocate(self.own, layout);
        }
        if let Some(pool) = self.lent.get(self.open) {
            if let Ok(set) = self.try_allocate(*pool, layout) {
                return Ok(set);
            }
            self.open += 1;
        }
        let pool = match self.lent.get(self.open) {
            Some(pool) => *pool,
            None => {
                let pool = create(&self.device, self.need)?;
                self.lent.push(pool);
                pool
            }
        };
        self.try_allocate(pool, layout)
    }

    fn try_allocate(
        &self,
        pool: vk::DescriptorPool,
        layout: vk::DescriptorSetLayout,
    ) -> Result<vk::DescriptorSet, BackendError> {
        let layouts = [layout];
        let info = vk::DescriptorSetAllocateInfo::default()
            .descriptor_pool(pool)
            .set_layouts(&layouts);
        // SAFETY: pool and layout belong to this device; from Vulkan 1.1 on a pool without room says so.
        let sets = unsafe { self.device.raw.allocate_descriptor_sets(&info) };
        Ok(sets.map_err(self.device.fail("vkAllocateDescriptorSets"))?[0])
    }

    /// Frees every set with something lent; the pools stay.
    ///
    /// # Safety
    /// No work that uses them is under way, and none is recorded that will.
    pub unsafe fn forget(&mut self) -> Result<(), BackendError> {
        for pool in &self.lent {
            let flags = vk::DescriptorPoolResetFlags::empty();
            // SAFETY: the caller's promise.
            unsafe { self.device.raw.reset_descriptor_pool(*pool, flags) }
                .map_err(self.device.fail("vkResetDescriptorPool"))?;
        }
        self.open = 0;
        Ok(())
    }
}

impl Drop for Pools {
    fn drop(&mut self) {
        for pool in self.lent.iter().chain([&self.own]) {
            // SAFETY: the executable waited for its work before dropping its sets; each is destroyed once.
            unsafe { self.device.raw.destroy_descriptor_pool(*pool, None) };
        }
    }
}

fn create(device: &Device, need: Need) -> Result<vk::DescriptorPool, BackendError> {
    let sizes: Vec<_> = KINDS
        .into_iter()
        .zip(need.kinds)
        .filter(|(_, count)| *count > 0)
        .map(|(ty, descriptor_count)| vk::DescriptorPoolSize {
            ty,
            descriptor_count,
        })
        .collect();
    let info = vk::DescriptorPoolCreateInfo::default()
        .max_sets(need.sets.max(1))
        .pool_sizes(&sizes);
    // SAFETY: the device is alive; `info` points to a local.
    unsafe { device.raw.create_descriptor_pool(&info, None) }
        .map_err(device.fail("vkCreateDescriptorPool"))
}
