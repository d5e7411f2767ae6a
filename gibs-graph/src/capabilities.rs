//! What a device allows, and whether a schedule stays within it.
use crate::{
    Access, BackendError, DispatchSize, DispatchStep, ImageFormat, Resource, ResourceId, Schedule,
};
use serde::Serialize;

/// What a device allows. Sizes are in bytes.
///
/// ```
/// use gibs_graph::Capabilities;
///
/// let mut small = Capabilities::webgpu();
/// small.storage_buffers = 4;
/// assert_eq!(small.storage_binding, 128 << 20);
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct Capabilities {
    /// Largest buffer.
    pub buffer: u64,
    /// Largest storage binding.
    pub storage_binding: u64,
    /// Largest uniform binding.
    pub uniform_binding: u64,
    /// All memory that there is; `u64::MAX` where nobody says.
    pub memory: u64,
    /// What only wide CPU kernels see is kept, too, and counts as memory.
    pub host_data: bool,
    /// Stages trace rays in acceleration structures: by ray queries, or, on a CPU, without them.
    pub ray_query: bool,
    /// Triangles of a bottom level of an acceleration structure.
    pub structure_triangles: u64,
    /// Instances in an acceleration structure.
    pub structure_instances: u64,
    /// Storage buffers of one stage.
    pub storage_buffers: u32,
    /// Uniform buffers of one stage.
    pub uniform_buffers: u32,
    /// Sampled images of one stage.
    pub sampled_images: u32,
    /// Stored images of one stage.
    pub stored_images: u32,
    /// Longest side of an image, texels.
    pub image_side: u32,
    /// Formats of images that stages can use.
    pub formats: Vec<ImageFormat>,
    /// Invocations along each axis of a workgroup.
    pub workgroup_size: [u32; 3],
    /// Invocations in a workgroup.
    pub workgroup_invocations: u32,
    /// Workgroups along each axis of a dispatch.
    pub workgroups: [u32; 3],
}

const SMALLER: &str =
    "use fewer surfels, rays or lights per point, a smaller picture or scene, or another backend";
const SPLIT: &str = "split the stage, or pack what is read together";
const ANOTHER: &str = "use a smaller size or another backend";

impl Capabilities {
    /// What any WebGPU device has: the default limits of the WebGPU standard (section "Limits").
    pub fn webgpu() -> Self {
        Self {
            buffer: 256 << 20,
            storage_binding: 128 << 20,
            uniform_binding: 64 << 10,
            memory: u64::MAX,
            host_data: false,
            ray_query: false,
            structure_triangles: 0,
            structure_instances: 0,
            storage_buffers: 8,
            uniform_buffers: 12,
            sampled_images: 16,
            stored_images: 4,
            image_side: 8192,
            formats: ImageFormat::ALL.to_vec(),
            workgroup_size: [256, 256, 64],
            workgroup_invocations: 256,
            workgroups: [65_535; 3],
        }
    }

    /// No limits at all.
    pub fn unlimited() -> Self {
        Self {
            buffer: u64::MAX,
            storage_binding: u64::MAX,
            uniform_binding: u64::MAX,
            memory: u64::MAX,
            host_data: false,
            ray_query: true,
            structure_triangles: u64::MAX,
            structure_instances: u64::MAX,
            storage_buffers: u32::MAX,
            uniform_buffers: u32::MAX,
            sampled_images: u32::MAX,
            stored_images: u32::MAX,
            image_side: u32::MAX,
            formats: ImageFormat::ALL.to_vec(),
            workgroup_size: [u32::MAX; 3],
            workgroup_invocations: u32::MAX,
            workgroups: [u32::MAX; 3],
        }
    }

    /// Holds a schedule against the limits of the device with this name.
    ///
    /// # Errors
    /// [`BackendError::Limit`] for the first thing that is too much, with the stage that needs it;
    /// [`BackendError::Refused`] for a format of images that the device does not have.
    pub fn check(&self, device: &str, schedule: &Schedule) -> Result<(), BackendError> {
        let check = Check {
            allowed: self,
            device,
            schedule,
        };
        for (id, resource) in (0..).zip(&schedule.resources) {
            if resource.usage.on_device() {
                check.resource(id, resource)?;
            }
        }
        for (_, step, dispatch) in schedule.dispatches() {
            check.stage(&step.label, dispatch)?;
        }
        let what = || format!("graph `{}` (bytes of memory in all)", schedule.name);
        check.allow(what, schedule.bytes(self.host_data), self.memory, SMALLER)
    }
}

struct Check<'a> {
    allowed: &'a Capabilities,
    device: &'a str,
    schedule: &'a Schedule,
}

impl Check<'_> {
    fn resource(&self, id: ResourceId, resource: &Resource) -> Result<(), BackendError> {
        let what = |unit: &str| format!("{} ({unit})", self.name(id, resource));
        let allowed = self.allowed;
        if let Some(image) = resource.image {
            let side = u64::from(image.size[0].max(image.size[1]));
            let unit = || what("texels along a side");
            self.allow(unit, side, allowed.image_side.into(), SMALLER)?;
            if allowed.formats.contains(&image.format) {
                return Ok(());
            }
            return Err(BackendError::Refused {
                what: self.name(id, resource),
                reason: format!(
                    "the device `{}` has no images of {:?}",
                    self.device, image.format
                ),
                remedy: "use another format or another backend".into(),
            });
        }
        self.allow(
            || what("bytes of a buffer"),
            resource.bytes,
            allowed.buffer,
            SMALLER,
        )?;
        self.structure(id, resource)?;
        if resource.usage.storage {
            self.allow(
                || what("bytes of a storage binding"),
                resource.bytes,
                allowed.storage_binding,
                SMALLER,
            )?;
        }
        if resource.usage.uniform {
            self.allow(
                || what("bytes of a uniform"),
                resource.element.size().into(),
                allowed.uniform_binding,
                "make the uniform smaller",
            )?;
        }
        Ok(())
    }

    /// What rays are traced in, and its triangles.
    fn structure(&self, id: ResourceId, resource: &Resource) -> Result<(), BackendError> {
        let allowed = self.allowed;
        let what = |unit: &str| format!("{} ({unit})", self.name(id, resource));
        if resource.usage.triangles {
            // The most that a bottom level could have.
            let unit = || what("triangles of an acceleration structure");
            let most = match allowed.ray_query {
                true => allowed.structure_triangles,
                false => u64::MAX,
            };
            self.allow(unit, resource.len, most, SMALLER)?;
        }
        if !resource.usage.acceleration {
            return Ok(());
        }
        if !allowed.ray_query {
            return Err(BackendError::Refused {
                what: self.name(id, resource),
                reason: format!("the device `{}` has no ray queries", self.device),
                remedy: "trace without them (the setting ray_queries=off), or use a device and a driver that have them"
                    .into(),
            });
        }
        let unit = || what("instances of an acceleration structure");
        self.allow(unit, resource.len, allowed.structure_instances, SMALLER)
    }

    /// The resource, and the first stage that binds it.
    fn name(&self, id: ResourceId, resource: &Resource) -> String {
        let kind = match resource.image {
            Some(_) => "image",
            None if resource.usage.acceleration => "acceleration structure",
            None => "buffer",
        };
        let binds = |dispatch: &DispatchStep| dispatch.bindings.iter().any(|b| b.resource == id);
        let mut stages = self.schedule.dispatches();
        match stages.find(|(_, _, dispatch)| binds(dispatch)) {
            Some((_, step, _)) => format!("stage `{}`, {kind} `{}`", step.label, resource.key),
            None => format!("{kind} `{}`", resource.key),
        }
    }

    fn stage(&self, label: &str, dispatch: &DispatchStep) -> Result<(), BackendError> {
        type Counts = fn(Access) -> bool;
        let allowed = self.allowed;
        let count = |counts: Counts| {
            let bound = dispatch.bindings.iter().filter(|b| b.access.is_bound());
            bound.filter(|b| counts(b.access)).count() as u64
        };
        let what = |unit: &str| format!("stage `{label}` ({unit})");
        let counted: [(&str, Counts, u32); 4] = [
            (
                "storage buffers",
                |a| a != Access::Uniform && a != Access::Acceleration && !a.is_image(),
                allowed.storage_buffers,
            ),
            (
                "uniform buffers",
                |a| a == Access::Uniform,
                allowed.uniform_buffers,
            ),
            (
                "sampled images",
                |a| a == Access::Sampled,
                allowed.sampled_images,
            ),
            (
                "stored images",
                |a| a == Access::Stored,
                allowed.stored_images,
            ),
        ];
        for (unit, counts, most) in counted {
            self.allow(|| what(unit), count(counts), most.into(), SPLIT)?;
        }
        let size = dispatch.kernel.workgroup;
        self.allow(
            || what("invocations per workgroup"),
            size.map(u64::from).iter().product(),
            allowed.workgroup_invocations.into(),
            ANOTHER,
        )?;
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let unit = || what(&format!("workgroup size along {name}"));
            let most = allowed.workgroup_size[axis].into();
            self.allow(unit, size[axis].into(), most, ANOTHER)?;
            if let DispatchSize::Groups(groups) = dispatch.size {
                let unit = || what(&format!("workgroups along {name}"));
                let most = allowed.workgroups[axis].into();
                self.allow(unit, groups[axis].into(), most, ANOTHER)?;
            }
        }
        Ok(())
    }

    fn allow(
        &self,
        what: impl FnOnce() -> String,
        need: u64,
        limit: u64,
        remedy: &str,
    ) -> Result<(), BackendError> {
        if need <= limit {
            return Ok(());
        }
        Err(BackendError::Limit {
            what: what(),
            need,
            limit,
            device: self.device.into(),
            remedy: remedy.into(),
        })
    }
}
