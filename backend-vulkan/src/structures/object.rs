//! Structures of the device, and the geometry that they are made of.
use crate::device::Device;
use crate::memory::Buffer;
use ash::vk;
use gibs_graph::{AccelerationTriangle, BackendError, BottomLevel};
use std::sync::Arc;

/// Bytes between corners of a triangle.
const STRIDE: u64 = (size_of::<AccelerationTriangle>() / 3) as u64;
/// A structure of the device, with its memory.
pub(super) struct Object {
    pub(super) raw: vk::AccelerationStructureKHR,
    /// Scratch memory that building it takes.
    pub(super) scratch: u64,
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
pub(super) type Geometry = ([vk::AccelerationStructureGeometryKHR<'static>; 1], u32);

impl Object {
    /// Room for a structure of this geometry, which is not built yet.
    pub(super) fn new(
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
    pub(super) fn address(&self) -> Result<u64, BackendError> {
        let info = vk::AccelerationStructureDeviceAddressInfoKHR::default()
            .acceleration_structure(self.raw);
        let rays = functions(&self.device)?;
        // SAFETY: the structure belongs to this device.
        Ok(unsafe { rays.get_acceleration_structure_device_address(&info) })
    }
}

pub(super) fn triangles(base: u64, bottom: &BottomLevel) -> Geometry {
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

pub(super) fn instances(list: u64, count: usize) -> Geometry {
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

pub(super) fn build_info<'a>(
    ty: vk::AccelerationStructureTypeKHR,
    geometry: &'a [vk::AccelerationStructureGeometryKHR<'static>; 1],
) -> vk::AccelerationStructureBuildGeometryInfoKHR<'a> {
    vk::AccelerationStructureBuildGeometryInfoKHR::default()
        .ty(ty)
        .flags(vk::BuildAccelerationStructureFlagsKHR::PREFER_FAST_TRACE)
        .mode(vk::BuildAccelerationStructureModeKHR::BUILD)
        .geometries(geometry)
}

/// The functions of the extension, which every device has that allows structures.
pub(super) fn functions(
    device: &Device,
) -> Result<&ash::khr::acceleration_structure::Device, BackendError> {
    device.rays.as_ref().ok_or_else(|| BackendError::Refused {
        what: "building an acceleration structure".into(),
        reason: format!(
            "the device `{}` has no ray queries",
            device.adapter.info.name
        ),
        remedy: "trace without them".into(),
    })
}
