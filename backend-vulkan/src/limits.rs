//! What a device allows, held against a schedule before anything is allocated.
use crate::lend::refused;
use ash::vk;
use gibs_graph::{
    Access, BackendError, DispatchSize, DispatchStep, ImageFormat, Resource, Schedule,
};

/// The limits of a device that a schedule can exceed. Sizes are in bytes.
#[derive(Clone, Debug)]
pub(crate) struct Limits {
    pub device: String,
    pub storage_range: u64,
    pub uniform_range: u64,
    pub buffer: u64,
    pub heap: u64,
    pub storage_buffers: u64,
    pub uniform_buffers: u64,
    pub sampled_images: u64,
    pub storage_images: u64,
    /// Width or height of an image, texels.
    pub image_side: u32,
    /// Formats that stages can use, and hosts copy.
    pub formats: Vec<ImageFormat>,
    pub group_size: [u32; 3],
    pub group_lanes: u32,
    pub group_count: [u32; 3],
}

const SMALLER: &str = "use fewer surfels or rays, a smaller picture or scene, or the cpu backend";

impl Limits {
    /// Limits of `device`; `buffer` bounds one allocation, `heap` all of them.
    pub fn new(
        device: String,
        limits: &vk::PhysicalDeviceLimits,
        formats: Vec<ImageFormat>,
        buffer: u64,
        heap: u64,
    ) -> Self {
        let per_stage =
            |stage: u32, set: u32| u64::from(stage.min(set).min(limits.max_per_stage_resources));
        Self {
            device,
            storage_range: u64::from(limits.max_storage_buffer_range),
            uniform_range: u64::from(limits.max_uniform_buffer_range),
            buffer,
            heap,
            storage_buffers: per_stage(
                limits.max_per_stage_descriptor_storage_buffers,
                limits.max_descriptor_set_storage_buffers,
            ),
            uniform_buffers: per_stage(
                limits.max_per_stage_descriptor_uniform_buffers,
                limits.max_descriptor_set_uniform_buffers,
            ),
            sampled_images: per_stage(
                limits.max_per_stage_descriptor_sampled_images,
                limits.max_descriptor_set_sampled_images,
            ),
            storage_images: per_stage(
                limits.max_per_stage_descriptor_storage_images,
                limits.max_descriptor_set_storage_images,
            ),
            image_side: limits.max_image_dimension2_d,
            formats,
            group_size: limits.max_compute_work_group_size,
            group_lanes: limits.max_compute_work_group_invocations,
            group_count: limits.max_compute_work_group_count,
        }
    }

    /// Finds the first thing in `schedule` that is beyond the device.
    ///
    /// # Errors
    /// [`BackendError::Limit`], which names the stage or the resource; [`BackendError::Refused`] for an image format
    /// that the device does not have; [`BackendError::OutOfMemory`] where the schedule as a whole is larger than the
    /// device's memory.
    pub fn check(&self, schedule: &Schedule) -> Result<(), BackendError> {
        for resource in schedule.resources.iter().filter(|r| r.usage.on_device()) {
            let what = || format!("resource `{}` (bytes)", resource.key);
            self.allow(what, resource.bytes, self.buffer, SMALLER)?;
            self.check_image(resource)?;
            if resource.usage.storage {
                self.allow(what, resource.bytes, self.storage_range, SMALLER)?;
            }
            if resource.usage.uniform {
                self.allow(
                    what,
                    resource.element.size().into(),
                    self.uniform_range,
                    "make the uniform smaller",
                )?;
            }
        }
        for (_, step, dispatch) in schedule.dispatches() {
            self.check_stage(&step.label, dispatch)?;
        }
        let bytes = schedule.bytes(false);
        if bytes > self.heap {
            let (device, resource) = (self.device.clone(), schedule.name.clone());
            return Err(BackendError::OutOfMemory {
                device,
                resource,
                bytes,
            });
        }
        Ok(())
    }

    fn check_image(&self, resource: &Resource) -> Result<(), BackendError> {
        let Some(shape) = resource.image else {
            return Ok(());
        };
        for (side, name) in shape.size.into_iter().zip(["width", "height"]) {
            let what = || format!("image `{}` ({name})", resource.key);
            self.allow(what, side.into(), self.image_side.into(), SMALLER)?;
        }
        if self.formats.contains(&shape.format) {
            return Ok(());
        }
        Err(refused(
            format!("image `{}`", resource.key),
            format!(
                "the device `{}` has no images of {:?}",
                self.device, shape.format
            ),
            "use another format or another backend",
        ))
    }

    fn check_stage(&self, label: &str, dispatch: &DispatchStep) -> Result<(), BackendError> {
        const SPLIT: &str = "split the stage, or pack what is read together";
        const ANOTHER: &str = "use a smaller size or another backend";
        let bound = || dispatch.ports.iter().filter(|p| p.access.is_bound());
        let count = |access| bound().filter(|p| p.access == access).count() as u64;
        let uniforms = count(Access::Uniform);
        let (sampled, stored) = (count(Access::Sampled), count(Access::Stored));
        let storage = bound().count() as u64 - uniforms - sampled - stored;
        let what = |part: &str| format!("stage `{label}` ({part})");
        self.allow(
            || what("storage buffers"),
            storage,
            self.storage_buffers,
            SPLIT,
        )?;
        self.allow(|| what("uniforms"), uniforms, self.uniform_buffers, SPLIT)?;
        let part = || what("sampled images");
        self.allow(part, sampled, self.sampled_images, SPLIT)?;
        self.allow(
            || what("storage images"),
            stored,
            self.storage_images,
            SPLIT,
        )?;
        let lanes = dispatch
            .kernel
            .workgroup
            .iter()
            .map(|&n| u64::from(n))
            .product();
        self.allow(
            || what("invocations per workgroup"),
            lanes,
            self.group_lanes.into(),
            ANOTHER,
        )?;
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let size = dispatch.kernel.workgroup[axis];
            let part = || what(&format!("workgroup size along {name}"));
            self.allow(part, size.into(), self.group_size[axis].into(), ANOTHER)?;
            if let DispatchSize::Groups(groups) = dispatch.size {
                let part = || what(&format!("workgroups along {name}"));
                self.allow(
                    part,
                    groups[axis].into(),
                    self.group_count[axis].into(),
                    ANOTHER,
                )?;
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
        let (device, remedy) = (self.device.clone(), remedy.into());
        Err(BackendError::Limit {
            what: what(),
            need,
            limit,
            device,
            remedy,
        })
    }
}

#[cfg(test)]
mod tests;
