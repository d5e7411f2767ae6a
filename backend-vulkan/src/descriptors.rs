//! Descriptor sets: the ports of every stage bound to buffers and images.
//!
//! A set is written once, when what it binds is first bound together, and kept: frames under way may use it.
use crate::bound::Bound;
use crate::device::Device;
use crate::kernels::{Kernel, Slot};
use crate::pools::{Need, Pools};
use ash::vk;
use ash::vk::Handle;
use gibs_graph::{Access, BackendError, DispatchStep, Kind, Schedule};
use std::sync::Arc;

/// The sets of a schedule.
pub(crate) struct Descriptors {
    /// Of each step, every set that was made so far.
    sets: Vec<Vec<Set>>,
    /// One entry per step.
    kernels: Vec<Option<Arc<Kernel>>>,
    pools: Pools,
    /// What a set that is looked for binds.
    handles: Vec<u64>,
    device: Arc<Device>,
}

/// A set, and the buffers and views that it binds, in the order of the kernel's slots.
struct Set {
    raw: vk::DescriptorSet,
    handles: Box<[u64]>,
    /// It binds something that a host lent.
    lent: bool,
}

/// What a slot is bound to.
enum Target {
    Buffer([vk::DescriptorBufferInfo; 1]),
    Image([vk::DescriptorImageInfo; 1]),
    Structure([vk::AccelerationStructureKHR; 1]),
}

impl Descriptors {
    /// Makes the sets of all steps without images, for frames of both parities. Images may not be there yet.
    pub fn new(
        device: &Arc<Device>,
        schedule: &Schedule,
        kernels: Vec<Option<Arc<Kernel>>>,
        bound: Bound<'_>,
    ) -> Result<Self, BackendError> {
        let (mut own, mut lent) = (Need::default(), Need::default());
        for (i, _, dispatch) in schedule.dispatches() {
            let slots = kernels[i].iter().flat_map(|kernel| &kernel.slots);
            let one = Need::of(slots.map(|slot| slot.kind));
            let (copies, may_be_lent) = uses(schedule, dispatch);
            own.add(one, copies);
            // For two images or buffers that take turns.
            lent.add(one, 2 * copies * u32::from(may_be_lent));
        }
        let mut made = Self {
            sets: schedule.steps.iter().map(|_| Vec::new()).collect(),
            kernels,
            pools: Pools::new(device, own, lent)?,
            handles: Vec::new(),
            device: Arc::clone(device),
        };
        for (i, _, dispatch) in schedule.dispatches() {
            if !dispatch.ports.iter().any(|p| p.access.is_image()) {
                for parity in 0..2 {
                    made.set(schedule, i, dispatch, bound, parity)?;
                }
            }
        }
        Ok(made)
    }

    /// The set of a step for frames of this parity, with what is bound now; null for a step that binds nothing.
    pub fn set(
        &mut self,
        schedule: &Schedule,
        step: usize,
        dispatch: &DispatchStep,
        bound: Bound<'_>,
        parity: usize,
    ) -> Result<vk::DescriptorSet, BackendError> {
        let Some(kernel) = self.kernels[step]
            .as_ref()
            .filter(|kernel| !kernel.slots.is_empty())
            .map(Arc::clone)
        else {
            return Ok(vk::DescriptorSet::null());
        };
        self.handles.clear();
        let mut lent = false;
        for slot in &kernel.slots {
            let binding = &dispatch.bindings[slot.port];
            lent |= bound.imports.get(binding.resource).is_some();
            let handle = match target(schedule, dispatch, slot, bound, parity) {
                Some(Target::Buffer([info])) => info.buffer.as_raw(),
                Some(Target::Image([info])) => info.image_view.as_raw(),
                Some(Target::Structure([raw])) => raw.as_raw(),
                None => 0,
            };
            self.handles.push(handle);
        }
        let known = self.sets[step].iter();
        if let Some(set) = known.into_iter().find(|set| *set.handles == *self.handles) {
            return Ok(set.raw);
        }
        let raw = self.pools.allocate(kernel.set_layout, lent)?;
        self.write(raw, schedule, dispatch, &kernel, bound, parity);
        self.sets[step].push(Set {
            raw,
            handles: self.handles.as_slice().into(),
            lent,
        });
        Ok(raw)
    }

    /// Frees every set with something lent.
    ///
    /// # Safety
    /// No work that uses them is under way, and none is recorded that will.
    pub unsafe fn forget(&mut self) -> Result<(), BackendError> {
        for sets in &mut self.sets {
            sets.retain(|set| !set.lent);
        }
        // SAFETY: the caller's promise.
        unsafe { self.pools.forget() }
    }

    fn write(
        &self,
        set: vk::DescriptorSet,
        schedule: &Schedule,
        dispatch: &DispatchStep,
        kernel: &Kernel,
        bound: Bound<'_>,
        parity: usize,
    ) {
        let targets: Vec<_> = kernel
            .slots
            .iter()
            .filter_map(|slot| Some((slot, target(schedule, dispatch, slot, bound, parity)?)))
            .collect();
        let mut structures: Vec<_> = targets
            .iter()
            .map(|(_, target)| {
                let structure = vk::WriteDescriptorSetAccelerationStructureKHR::default();
                match target {
                    Target::Structure(raw) => structure.acceleration_structures(raw),
                    _ => structure,
                }
            })
            .collect();
        let writes: Vec<_> = targets
            .iter()
            .zip(&mut structures)
            .map(|((slot, target), structure)| {
                let write = vk::WriteDescriptorSet::default()
                    .dst_set(set)
                    .dst_binding(slot.binding)
                    .descriptor_type(slot.kind);
                match target {
                    Target::Buffer(info) => write.buffer_info(info),
                    Target::Image(info) => write.image_info(info),
                    Target::Structure(_) => write.descriptor_count(1).push_next(structure),
                }
            })
            .collect();
        // SAFETY: the set was just made and is not in use; what it binds is alive, and buffers are as large as the
        // ranges.
        unsafe { self.device.raw.update_descriptor_sets(&writes, &[]) };
    }
}

/// What a slot is to be bound to.
fn target(
    schedule: &Schedule,
    dispatch: &DispatchStep,
    slot: &Slot,
    bound: Bound<'_>,
    parity: usize,
) -> Option<Target> {
    let binding = &dispatch.bindings[slot.port];
    let resource = &schedule.resources[binding.resource as usize];
    if binding.access.is_image() {
        let (view, layout) = bound.view(binding.resource)?;
        let info = vk::DescriptorImageInfo::default()
            .image_view(view)
            .image_layout(layout);
        return Some(Target::Image([info]));
    }
    if binding.access == Access::Acceleration {
        return Some(Target::Structure([bound.structure(binding.resource)?]));
    }
    let (parity, range) = match binding.access {
        Access::Previous => (parity + 1, resource.bytes),
        Access::Uniform => (parity, resource.element.size().into()),
        _ => (parity, resource.bytes),
    };
    // The exact size, not the allocation's, because WGSL's arrayLength comes from it.
    let info = vk::DescriptorBufferInfo::default()
        .buffer(bound.buffer(binding.resource, parity)?)
        .range(range);
    Some(Target::Buffer([info]))
}

/// How many sets a stage needs, and whether a host may lend what it binds.
fn uses(schedule: &Schedule, dispatch: &DispatchStep) -> (u32, bool) {
    let (mut rotates, mut may_be_lent) = (false, false);
    for binding in dispatch.bindings.iter().filter(|b| b.access.is_bound()) {
        let resource = &schedule.resources[binding.resource as usize];
        rotates |= matches!(resource.kind, Kind::History(_));
        may_be_lent |= resource.image.is_some() || resource.kind == Kind::Input;
    }
    (if rotates { 2 } else { 1 }, may_be_lent)
}
