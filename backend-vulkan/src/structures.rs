//! Acceleration structures, built from the triangles and the instances that the host uploads.
//!
//! A top level stays for as long as the executable, so that descriptor sets and recorded frames hold; bottom levels are
//! made anew with each build. A build is waited for: scenes change seldom, and its memory goes at once.
use crate::device::Device;
use crate::memory::Buffer;
use crate::stream::Stream;
use ash::vk;
use gibs_graph::{
    AccelerationInstance, AccelerationPlan, AccelerationSource, AccelerationTriangle, BackendError,
    BottomLevel, ResourceId, Schedule,
};
use std::sync::Arc;

/// Bytes between corners of a triangle.
const STRIDE: u64 = (size_of::<AccelerationTriangle>() / 3) as u64;
/// Scratch memory that builds at the same time share, unless one alone takes more.
const SCRATCH: u64 = 32 << 20;

/// Those of a schedule.
#[derive(Default)]
pub(crate) struct Structures(Vec<Structure>);

struct Structure {
    source: AccelerationSource,
    top: Object,
    bottoms: Vec<Object>,
}

/// A structure of the device, with its memory.
struct Object {
    raw: vk::AccelerationStructureKHR,
    /// Scratch memory that building it takes.
    scratch: u64,
    device: Arc<Device>,
    /// After the structure in it.
    _memory: Buffer,
}

impl Drop for Object {
    fn drop(&mut self) {
        if let Some(rays) = &self.device.rays {
            // SAFETY: whoever holds a structure waits for the work that uses it before dropping it; destroyed once.
            unsafe { rays.destroy_acceleration_structure(self.raw, None) };
        }
    }
}

/// A geometry on the device, and how many primitives it has.
type Geometry = ([vk::AccelerationStructureGeometryKHR<'static>; 1], u32);

impl Object {
    /// Room for a structure of this geometry, which is not built yet.
    fn new(
        device: &Arc<Device>,
        name: &str,
        ty: vk::AccelerationStructureTypeKHR,
        (geometry, count): &Geometry,
    ) -> Result<Self, BackendError> {
        let rays = functions(device)?;
        let info = build_info(ty, geometry);
        let mut sizes = vk::AccelerationStructureBuildSizesInfoKHR::default();
        let kind = vk::AccelerationStructureBuildTypeKHR::DEVICE;
        // SAFETY: the device is alive; the geometry is a local with as many primitives as `count` says. No address in it is
        // read.
        unsafe { rays.get_acceleration_structure_build_sizes(kind, &info, &[*count], &mut sizes) };
        let usage = vk::BufferUsageFlags::ACCELERATION_STRUCTURE_STORAGE_KHR;
        let size = sizes.acceleration_structure_size;
        let memory = Buffer::device(device, name, size, usage)?;
        let info = vk::AccelerationStructureCreateInfoKHR::default()
            .buffer(memory.raw)
            .size(size)
            .ty(ty);
        // SAFETY: the buffer was made for structures, is as large as this one, and outlives it.
        let raw = unsafe { rays.create_acceleration_structure(&info, None) }
            .map_err(device.fail("vkCreateAccelerationStructureKHR"))?;
        device.name(raw, name);
        Ok(Self {
            raw,
            scratch: sizes.build_scratch_size,
            device: Arc::clone(device),
            _memory: memory,
        })
    }

    /// Where instances find it.
    fn address(&self) -> Result<u64, BackendError> {
        let info = vk::AccelerationStructureDeviceAddressInfoKHR::default()
            .acceleration_structure(self.raw);
        let rays = functions(&self.device)?;
        // SAFETY: the structure belongs to this device.
        Ok(unsafe { rays.get_acceleration_structure_device_address(&info) })
    }
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
            if source.resource == resource {
                source.write(offset, bytes);
                taken = true;
            }
            source.stale |= source.triangles == resource;
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
        let mut sources = self.0.iter().map(|structure| &structure.source);
        sources.any(|s| s.triangles == resource || s.resource == resource)
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

/// Builds a top level with its bottom levels, which it returns.
fn build(
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

fn triangles(base: u64, bottom: &BottomLevel) -> Geometry {
    let first = u64::from(bottom.first) * 3 * STRIDE;
    let data = vk::AccelerationStructureGeometryTrianglesDataKHR::default()
        .vertex_format(vk::Format::R32G32B32_SFLOAT)
        .vertex_data(vk::DeviceOrHostAddressConstKHR {
            device_address: base + first,
        })
        .vertex_stride(STRIDE)
        .max_vertex(3 * bottom.count - 1)
        .index_type(vk::IndexType::NONE_KHR);
    let geometry = vk::AccelerationStructureGeometryKHR::default()
        .geometry_type(vk::GeometryTypeKHR::TRIANGLES)
        .geometry(vk::AccelerationStructureGeometryDataKHR { triangles: data })
        .flags(match bottom.opaque {
            true => vk::GeometryFlagsKHR::OPAQUE,
            false => vk::GeometryFlagsKHR::empty(),
        });
    ([geometry], bottom.count)
}

fn instances(list: u64, count: usize) -> Geometry {
    let data = vk::AccelerationStructureGeometryInstancesDataKHR::default().data(
        vk::DeviceOrHostAddressConstKHR {
            device_address: list,
        },
    );
    let geometry = vk::AccelerationStructureGeometryKHR::default()
        .geometry_type(vk::GeometryTypeKHR::INSTANCES)
        .geometry(vk::AccelerationStructureGeometryDataKHR { instances: data });
    ([geometry], count as u32)
}

fn build_info<'a>(
    ty: vk::AccelerationStructureTypeKHR,
    geometry: &'a [vk::AccelerationStructureGeometryKHR<'static>; 1],
) -> vk::AccelerationStructureBuildGeometryInfoKHR<'a> {
    vk::AccelerationStructureBuildGeometryInfoKHR::default()
        .ty(ty)
        .flags(vk::BuildAccelerationStructureFlagsKHR::PREFER_FAST_TRACE)
        .mode(vk::BuildAccelerationStructureModeKHR::BUILD)
        .geometries(geometry)
}

fn range_of(count: u32) -> vk::AccelerationStructureBuildRangeInfoKHR {
    vk::AccelerationStructureBuildRangeInfoKHR::default().primitive_count(count)
}

/// The functions of the extension, which every device has that allows structures.
fn functions(device: &Device) -> Result<&ash::khr::acceleration_structure::Device, BackendError> {
    device.rays.as_ref().ok_or_else(|| BackendError::Refused {
        what: "building an acceleration structure".into(),
        reason: format!(
            "the device `{}` has no ray queries",
            device.adapter.info.name
        ),
        remedy: "trace without them".into(),
    })
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
