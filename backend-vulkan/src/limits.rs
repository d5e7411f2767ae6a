//! What a device allows, held against a schedule before anything is allocated.
use ash::vk;
use gibs_graph::{Access, BackendError, DispatchSize, DispatchStep, Schedule};

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
    pub group_size: [u32; 3],
    pub group_lanes: u32,
    pub group_count: [u32; 3],
}

impl Limits {
    /// Limits of `device`; `buffer` bounds one allocation, `heap` all of them.
    pub fn new(device: String, limits: &vk::PhysicalDeviceLimits, buffer: u64, heap: u64) -> Self {
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
            group_size: limits.max_compute_work_group_size,
            group_lanes: limits.max_compute_work_group_invocations,
            group_count: limits.max_compute_work_group_count,
        }
    }

    /// Finds the first thing in `schedule` that is beyond the device.
    ///
    /// # Errors
    /// [`BackendError::Limit`], which names the stage or the resource; [`BackendError::OutOfMemory`] where the
    /// schedule as a whole is larger than the device's memory.
    pub fn check(&self, schedule: &Schedule) -> Result<(), BackendError> {
        const SMALLER: &str =
            "use fewer surfels or rays, a smaller picture or scene, or the cpu backend";
        for resource in schedule.resources.iter().filter(|r| r.usage.on_device()) {
            let what = || format!("resource `{}` (bytes)", resource.key);
            self.allow(what, resource.bytes, self.buffer, SMALLER)?;
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

    fn check_stage(&self, label: &str, dispatch: &DispatchStep) -> Result<(), BackendError> {
        const SPLIT: &str = "split the stage, or pack what is read together";
        const ANOTHER: &str = "use a smaller size or another backend";
        let bound = || dispatch.ports.iter().filter(|p| p.access.is_bound());
        let uniforms = bound().filter(|p| p.access == Access::Uniform).count() as u64;
        let storage = bound().count() as u64 - uniforms;
        let what = |part: &str| format!("stage `{label}` ({part})");
        self.allow(
            || what("storage buffers"),
            storage,
            self.storage_buffers,
            SPLIT,
        )?;
        self.allow(|| what("uniforms"), uniforms, self.uniform_buffers, SPLIT)?;
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
mod tests {
    use super::*;
    use gibs_graph::{Dispatch, Graph, WgslSource, Workgroup, stage};

    stage! {
        /// Two storage buffers and a uniform.
        pub stage Small {
            wgsl: WgslSource { name: "small", text: "", modules: &[], features: &[] },
            workgroup: [8, 4, 1],
            ports: { uniform size: [u32; 4], read source: u32, write target_: u32 },
            cpu: kernel,
            wide: None,
        }
    }

    fn kernel(_: &Views<'_>, _: Workgroup) {}

    fn schedule() -> Schedule {
        let mut g = Graph::new("small");
        let size = g.input("size", 1);
        let source = g.input("source", 100);
        let target_ = g.transient("target", 50);
        let inputs = Inputs {
            size: &size,
            source: &source,
            target_,
        };
        let out = g.add::<Small>("group/small", inputs, Dispatch::Groups([3, 2, 1]));
        g.output("target", &out.target_);
        g.compile(None).unwrap()
    }

    type Lower = fn(&mut Limits);

    /// Exactly what the schedule needs.
    fn enough() -> Limits {
        Limits {
            device: "test".into(),
            storage_range: 400,
            uniform_range: 16,
            buffer: 400,
            heap: 616,
            storage_buffers: 2,
            uniform_buffers: 1,
            group_size: [8, 4, 1],
            group_lanes: 32,
            group_count: [3, 2, 1],
        }
    }

    #[test]
    fn one_less_of_anything_is_named() {
        let schedule = schedule();
        enough().check(&schedule).unwrap();
        let cases: [(&str, Lower); 9] = [
            ("resource `source` (bytes) needs 400", |l| {
                l.storage_range -= 1
            }),
            ("resource `size` (bytes) needs 16", |l| l.uniform_range -= 1),
            ("resource `source` (bytes) needs 400", |l| l.buffer -= 1),
            ("stage `group/small` (storage buffers) needs 2", |l| {
                l.storage_buffers -= 1
            }),
            ("stage `group/small` (uniforms) needs 1", |l| {
                l.uniform_buffers -= 1
            }),
            (
                "stage `group/small` (invocations per workgroup) needs 32",
                |l| l.group_lanes -= 1,
            ),
            (
                "stage `group/small` (workgroup size along y) needs 4",
                |l| l.group_size[1] -= 1,
            ),
            ("stage `group/small` (workgroups along x) needs 3", |l| {
                l.group_count[0] -= 1
            }),
            ("allocating 616 bytes for `small`", |l| l.heap -= 1),
        ];
        for (expected, lower) in cases {
            let mut limits = enough();
            lower(&mut limits);
            let error = limits.check(&schedule).unwrap_err().to_string();
            assert!(
                error.contains(expected) && error.contains("`test`"),
                "{error}"
            );
        }
    }
}
