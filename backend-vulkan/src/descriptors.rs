//! Descriptor sets: the ports of every stage bound to buffers, for frames of both parities.
use crate::device::Device;
use crate::kernels::Kernel;
use crate::storage::Store;
use ash::vk;
use gibs_graph::{Access, BackendError, DispatchStep, Kind, Schedule};
use std::sync::Arc;

/// The sets of a schedule.
pub(crate) struct Descriptors {
    pool: vk::DescriptorPool,
    /// Per step, a set for even and one for odd frames; the same one where no history is bound, null where nothing is.
    sets: Vec<[vk::DescriptorSet; 2]>,
    device: Arc<Device>,
}

impl Descriptors {
    /// Makes and writes all sets. `kernels` has one entry per step.
    pub fn new(
        device: &Arc<Device>,
        schedule: &Schedule,
        kernels: &[Option<Arc<Kernel>>],
        stores: &[Option<Store>],
    ) -> Result<Self, BackendError> {
        let (mut storage, mut uniform, mut sets) = (0, 0, 0);
        for (i, _, dispatch) in schedule.dispatches() {
            let copies = copies(schedule, dispatch);
            for slot in kernels[i].iter().flat_map(|kernel| &kernel.slots) {
                match slot.kind {
                    vk::DescriptorType::UNIFORM_BUFFER => uniform += copies,
                    _ => storage += copies,
                }
            }
            sets += copies;
        }
        let mut made = Self {
            pool: create_pool(device, sets, storage, uniform)?,
            sets: vec![[vk::DescriptorSet::null(); 2]; schedule.steps.len()],
            device: Arc::clone(device),
        };
        for (i, _, dispatch) in schedule.dispatches() {
            let Some(kernel) = kernels[i]
                .as_deref()
                .filter(|kernel| !kernel.slots.is_empty())
            else {
                continue;
            };
            let even = made.write(schedule, dispatch, kernel, stores, 0)?;
            let odd = match copies(schedule, dispatch) {
                1 => even,
                _ => made.write(schedule, dispatch, kernel, stores, 1)?,
            };
            made.sets[i] = [even, odd];
        }
        Ok(made)
    }

    /// The sets of a step, for even and odd frames.
    pub fn of(&self, step: usize) -> [vk::DescriptorSet; 2] {
        self.sets[step]
    }

    fn write(
        &self,
        schedule: &Schedule,
        dispatch: &DispatchStep,
        kernel: &Kernel,
        stores: &[Option<Store>],
        parity: usize,
    ) -> Result<vk::DescriptorSet, BackendError> {
        let layouts = [kernel.set_layout];
        let info = vk::DescriptorSetAllocateInfo::default()
            .descriptor_pool(self.pool)
            .set_layouts(&layouts);
        // SAFETY: the pool was made for these sets, the layout belongs to this device.
        let set = unsafe { self.device.raw.allocate_descriptor_sets(&info) }
            .map_err(self.device.fail("vkAllocateDescriptorSets"))?[0];
        let mut buffers = Vec::with_capacity(kernel.slots.len());
        for slot in &kernel.slots {
            let binding = &dispatch.bindings[slot.port];
            let resource = &schedule.resources[binding.resource as usize];
            let Some(store) = &stores[binding.resource as usize] else {
                continue;
            };
            let (buffer, range) = match binding.access {
                Access::Previous => (store.previous(parity), resource.bytes),
                Access::Uniform => (store.current(parity), resource.element.size().into()),
                _ => (store.current(parity), resource.bytes),
            };
            // The exact size, not the allocation's, because WGSL's arrayLength comes from it.
            let info = vk::DescriptorBufferInfo::default()
                .buffer(buffer.raw)
                .range(range);
            buffers.push((slot, [info]));
        }
        let writes: Vec<_> = buffers
            .iter()
            .map(|(slot, info)| {
                vk::WriteDescriptorSet::default()
                    .dst_set(set)
                    .dst_binding(slot.binding)
                    .descriptor_type(slot.kind)
                    .buffer_info(info)
            })
            .collect();
        // SAFETY: the set was just made and is not in use; the buffers are alive and as large as the ranges.
        unsafe { self.device.raw.update_descriptor_sets(&writes, &[]) };
        Ok(set)
    }
}

impl Drop for Descriptors {
    fn drop(&mut self) {
        // SAFETY: the executable waited for its work before dropping its sets; destroyed once.
        unsafe { self.device.raw.destroy_descriptor_pool(self.pool, None) };
    }
}

/// How many sets a stage needs.
fn copies(schedule: &Schedule, dispatch: &DispatchStep) -> u32 {
    let rotates = dispatch
        .bindings
        .iter()
        .filter(|b| b.access.is_bound())
        .any(|b| {
            matches!(
                schedule.resources[b.resource as usize].kind,
                Kind::History(_)
            )
        });
    if rotates { 2 } else { 1 }
}

fn create_pool(
    device: &Device,
    sets: u32,
    storage: u32,
    uniform: u32,
) -> Result<vk::DescriptorPool, BackendError> {
    let sizes: Vec<_> = [
        (vk::DescriptorType::STORAGE_BUFFER, storage),
        (vk::DescriptorType::UNIFORM_BUFFER, uniform),
    ]
    .into_iter()
    .filter(|(_, count)| *count > 0)
    .map(|(ty, descriptor_count)| vk::DescriptorPoolSize {
        ty,
        descriptor_count,
    })
    .collect();
    let info = vk::DescriptorPoolCreateInfo::default()
        .max_sets(sets.max(1))
        .pool_sizes(&sizes);
    // SAFETY: the device is alive; `info` points to a local.
    unsafe { device.raw.create_descriptor_pool(&info, None) }
        .map_err(device.fail("vkCreateDescriptorPool"))
}
