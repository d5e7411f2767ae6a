//! Recording builds, and waiting for them.
use super::object::{Geometry, Object, build_info, functions, instances, triangles};
use crate::memory::Buffer;
use crate::stream::Stream;
use ash::vk;
use gibs_graph::{AccelerationInstance, AccelerationPlan, AccelerationSource, BackendError};
use std::sync::Arc;

/// Scratch memory that builds at the same time share, unless one alone takes more.
const SCRATCH: u64 = 32 << 20;

/// Builds a top level with its bottom levels, which it returns.
pub(super) fn build(
    stream: &mut Stream,
    plan: &AccelerationPlan,
    top: &Object,
    corners: &Buffer,
) -> Result<Vec<Object>, BackendError> {
    let device = Arc::clone(&stream.device);
    let rays = functions(&device)?;
    let base = corners.address();
    let geometries: Vec<Geometry> = plan.bottoms.iter().map(|b| triangles(base, b)).collect();
    let bottom = vk::AccelerationStructureTypeKHR::BOTTOM_LEVEL;
    let bottoms = geometries
        .iter()
        .map(|geometry| Object::new(&device, "bottom level", bottom, geometry))
        .collect::<Result<Vec<_>, _>>()?;
    let placed = placed(plan, &bottoms)?;
    let usage = vk::BufferUsageFlags::ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_KHR;
    let mut list = Buffer::host(&device, "instances", placed.len().max(64) as u64, usage)?;
    if let Some(place) = list.mapped().get_mut(..placed.len()) {
        place.copy_from_slice(&placed);
    }
    let geometry = instances(list.address(), plan.instances.len());

    let alignment = device.adapter.rays.map_or(1, |r| r.scratch_alignment);
    let aligned = |bytes: u64| bytes.next_multiple_of(alignment);
    let batches = batches(&bottoms, aligned);
    let needs = batches.iter().map(|(_, bytes)| *bytes);
    let most = needs.chain([aligned(top.scratch)]).max().unwrap_or(0);
    let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
    let scratch = Buffer::device(&device, "scratch", most + alignment, usage)?;
    let start = aligned(scratch.address());

    let commands = stream.batch()?;
    let device = &stream.device.raw;
    // SAFETY: the batch is being recorded. Geometry lies in buffers that live until the work is done, which is waited for
    // below, and within them, as the plan was checked; scratch memory of builds at the same time does not overlap, since
    // each batch starts at the same place and a barrier stands between two. The top level has room for as many instances
    // as the source has, and they refer to bottom levels that are built before it.
    unsafe {
        order(device, commands, BEFORE);
        for (range, _) in batches {
            let mut free = start;
            let (mut infos, mut counts) = (Vec::new(), Vec::new());
            for (object, (geometry, count)) in bottoms[range.clone()].iter().zip(&geometries[range])
            {
                let info = build_info(bottom, geometry)
                    .dst_acceleration_structure(object.raw)
                    .scratch_data(vk::DeviceOrHostAddressKHR {
                        device_address: free,
                    });
                free += aligned(object.scratch);
                infos.push(info);
                counts.push([range_of(*count)]);
            }
            let ranges: Vec<&[_]> = counts.iter().map(|range| range.as_slice()).collect();
            rays.cmd_build_acceleration_structures(commands, &infos, &ranges);
            order(device, commands, BETWEEN);
        }
        let info = build_info(vk::AccelerationStructureTypeKHR::TOP_LEVEL, &geometry.0)
            .dst_acceleration_structure(top.raw)
            .scratch_data(vk::DeviceOrHostAddressKHR {
                device_address: start,
            });
        let range = [range_of(geometry.1)];
        rays.cmd_build_acceleration_structures(commands, &[info], &[&range]);
        order(device, commands, AFTER);
    }
    stream.finish()?;
    Ok(bottoms)
}

/// Bottom levels in groups whose builds share the scratch memory, with the bytes that each group takes.
fn batches(bottoms: &[Object], aligned: impl Fn(u64) -> u64) -> Vec<(std::ops::Range<usize>, u64)> {
    let mut batches: Vec<(std::ops::Range<usize>, u64)> = Vec::new();
    for (i, object) in bottoms.iter().enumerate() {
        let need = aligned(object.scratch);
        match batches.last_mut() {
            Some((range, bytes)) if *bytes + need <= SCRATCH => {
                range.end = i + 1;
                *bytes += need;
            }
            _ => batches.push((i..i + 1, need)),
        }
    }
    batches
}

/// The instances as the device reads them.
fn placed(plan: &AccelerationPlan, bottoms: &[Object]) -> Result<Vec<u8>, BackendError> {
    const EVERY_RAY: u32 = 0xff << 24;
    let addresses: Vec<u64> = bottoms
        .iter()
        .map(Object::address)
        .collect::<Result<_, _>>()?;
    let mut bytes = Vec::with_capacity(plan.instances.len() * 64);
    for (instance, bottom) in &plan.instances {
        let AccelerationInstance { custom, .. } = instance;
        // VkAccelerationStructureInstanceKHR: transform, index and mask, no flags, address.
        for value in AccelerationSource::rows(instance) {
            bytes.extend(value.to_ne_bytes());
        }
        bytes.extend((custom | EVERY_RAY).to_ne_bytes());
        bytes.extend(0_u32.to_ne_bytes());
        bytes.extend(addresses[*bottom].to_ne_bytes());
    }
    Ok(bytes)
}

fn range_of(count: u32) -> vk::AccelerationStructureBuildRangeInfoKHR {
    vk::AccelerationStructureBuildRangeInfoKHR::default().primitive_count(count)
}

/// Stages and accesses before and behind a barrier.
type Order = [(vk::PipelineStageFlags, vk::AccessFlags); 2];

const BUILD: vk::PipelineStageFlags = vk::PipelineStageFlags::ACCELERATION_STRUCTURE_BUILD_KHR;
const BUILT: vk::AccessFlags = vk::AccessFlags::ACCELERATION_STRUCTURE_WRITE_KHR;
const USED: vk::AccessFlags = vk::AccessFlags::from_raw(
    vk::AccessFlags::ACCELERATION_STRUCTURE_READ_KHR.as_raw()
        | vk::AccessFlags::ACCELERATION_STRUCTURE_WRITE_KHR.as_raw(),
);
/// Uploads, and frames that trace in what is built over.
const BEFORE: Order = [
    (
        vk::PipelineStageFlags::from_raw(
            vk::PipelineStageFlags::TRANSFER.as_raw()
                | vk::PipelineStageFlags::COMPUTE_SHADER.as_raw(),
        ),
        vk::AccessFlags::TRANSFER_WRITE,
    ),
    (
        BUILD,
        vk::AccessFlags::from_raw(vk::AccessFlags::SHADER_READ.as_raw() | USED.as_raw()),
    ),
];
const BETWEEN: Order = [(BUILD, BUILT), (BUILD, USED)];
const AFTER: Order = [
    (BUILD, BUILT),
    (
        vk::PipelineStageFlags::COMPUTE_SHADER,
        vk::AccessFlags::ACCELERATION_STRUCTURE_READ_KHR,
    ),
];

/// Records a barrier.
///
/// # Safety
/// `commands` is a command buffer of `device`, which has acceleration structures, that is being recorded.
unsafe fn order(device: &ash::Device, commands: vk::CommandBuffer, [from, to]: Order) {
    let memory = [vk::MemoryBarrier::default()
        .src_access_mask(from.1)
        .dst_access_mask(to.1)];
    let flags = vk::DependencyFlags::empty();
    // SAFETY: the caller's promise; the accesses are ones that these stages make.
    unsafe { device.cmd_pipeline_barrier(commands, from.0, to.0, flags, &memory, &[], &[]) };
}
