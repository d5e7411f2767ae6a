//! Kernels: WGSL to SPIR-V to pipelines, built once per device.
use crate::device::Device;
use crate::spirv::fold_access_chains;
use ash::vk;
use gibs_graph::{Access, BackendError, DispatchStep, Schedule, Step};
use gibs_shaders::{Compiler, SPIRV, on_all_cores};
use std::collections::HashMap;
use std::sync::Arc;

/// A pipeline and how its ports are bound.
#[derive(Default)]
pub(crate) struct Kernel {
    pub pipeline: vk::Pipeline,
    pub layout: vk::PipelineLayout,
    pub set_layout: vk::DescriptorSetLayout,
    pub slots: Vec<Slot>,
}

/// Where a port is bound.
pub(crate) struct Slot {
    /// Index of the port in its stage.
    pub port: usize,
    /// Number in set 0.
    pub binding: u32,
    pub kind: vk::DescriptorType,
}

/// What two stages must share to share a pipeline. The text is part of it so that two kernels with one name do not
/// get mixed up.
#[derive(Clone, PartialEq, Eq, Hash)]
struct Key {
    name: &'static str,
    text: &'static str,
    features: Vec<&'static str>,
    /// Each port and how it is bound.
    ports: Vec<(&'static str, vk::DescriptorType)>,
}

/// Every kernel that was built on a device.
#[derive(Default)]
pub(crate) struct Kernels(HashMap<Key, Arc<Kernel>>);

impl Kernels {
    /// Each kernel once.
    pub fn all(&self) -> impl Iterator<Item = &Kernel> {
        self.0.values().map(Arc::as_ref)
    }
}

/// The kernel of every step of `schedule` (`None` for a clear), in order. Those that the device does not have yet are
/// built, on all cores.
///
/// # Errors
/// [`BackendError::Kernel`] with the label of the first stage whose kernel is refused.
pub(crate) fn build(
    device: &Device,
    schedule: &Schedule,
) -> Result<Vec<Option<Arc<Kernel>>>, BackendError> {
    // Held to the end, so that two threads do not build the same kernel.
    let mut known = device.kernels();
    let mut missing: Vec<(Key, &Step, &DispatchStep)> = Vec::new();
    for (_, step, dispatch) in schedule.dispatches() {
        let key = Key::of(dispatch);
        if !known.0.contains_key(&key) && !missing.iter().any(|(k, ..)| *k == key) {
            missing.push((key, step, dispatch));
        }
    }
    if !missing.is_empty() {
        let compiler = Compiler::new();
        // Drivers compile when a pipeline is made, which is slow.
        let built = on_all_cores(&missing, |(_, step, dispatch)| {
            Kernel::new(device, &compiler, &step.label, dispatch)
        });
        let mut first_error = None;
        for (result, (key, ..)) in built.into_iter().zip(missing) {
            match result {
                Ok(kernel) => drop(known.0.insert(key, Arc::new(kernel))),
                Err(error) => first_error = first_error.or(Some(error)),
            }
        }
        if let Some(error) = first_error {
            return Err(error);
        }
        device.save_pipelines();
    }
    let mut kernels = vec![None; schedule.steps.len()];
    for (i, _, dispatch) in schedule.dispatches() {
        kernels[i] = known.0.get(&Key::of(dispatch)).map(Arc::clone);
    }
    Ok(kernels)
}

/// How a port is bound.
fn kind_of(access: Access) -> vk::DescriptorType {
    match access {
        Access::Uniform => vk::DescriptorType::UNIFORM_BUFFER,
        Access::Sampled => vk::DescriptorType::SAMPLED_IMAGE,
        Access::Stored => vk::DescriptorType::STORAGE_IMAGE,
        Access::Acceleration => vk::DescriptorType::ACCELERATION_STRUCTURE_KHR,
        _ => vk::DescriptorType::STORAGE_BUFFER,
    }
}

impl Key {
    fn of(dispatch: &DispatchStep) -> Self {
        let wgsl = &dispatch.kernel.wgsl;
        let bound = dispatch.ports.iter().filter(|p| p.access.is_bound());
        Self {
            name: wgsl.name,
            text: wgsl.text,
            features: dispatch.features(),
            ports: bound.map(|p| (p.name, kind_of(p.access))).collect(),
        }
    }
}

impl Kernel {
    fn new(
        device: &Device,
        compiler: &Compiler,
        stage: &str,
        dispatch: &DispatchStep,
    ) -> Result<Self, BackendError> {
        let refused = |message: String| BackendError::Kernel {
            stage: stage.into(),
            message,
        };
        let compiled = compiler
            .compile(&dispatch.kernel.wgsl, &dispatch.ports)
            .map_err(|e| refused(e.to_string()))?;
        let mut words = compiled.spirv(SPIRV).map_err(|e| refused(e.to_string()))?;
        if device.instance.checks_hazards {
            words = fold_access_chains(&words);
        }
        let (found, stated) = (compiled.workgroup_size(), dispatch.kernel.workgroup);
        if found != stated {
            return Err(refused(format!(
                "the kernel has workgroups of {found:?}, the stage says {stated:?}"
            )));
        }
        let mut slots = Vec::with_capacity(dispatch.ports.len());
        for (port, declared) in dispatch
            .ports
            .iter()
            .enumerate()
            .filter(|(_, p)| p.access.is_bound())
        {
            let binding = compiled.spirv_binding(declared.name).ok_or_else(|| {
                refused(format!(
                    "the kernel has no binding for port `{}`",
                    declared.name
                ))
            })?;
            slots.push(Slot {
                port,
                binding,
                kind: kind_of(declared.access),
            });
        }
        let mut kernel = Self {
            slots,
            ..Self::default()
        };
        if let Err((call, error)) = kernel.create(device, &words) {
            // SAFETY: the objects made so far belong to this device and were never used; null handles are ignored.
            unsafe { kernel.destroy(&device.raw) };
            return Err(refused(format!("{call}: {error}")));
        }
        device.name(kernel.pipeline, dispatch.kernel.wgsl.name);
        Ok(kernel)
    }

    /// Makes layouts and pipeline. What was made before an error stays in `self`.
    fn create(&mut self, device: &Device, words: &[u32]) -> Result<(), (&'static str, vk::Result)> {
        let raw = &device.raw;
        let bindings: Vec<_> = self
            .slots
            .iter()
            .map(|slot| {
                vk::DescriptorSetLayoutBinding::default()
                    .binding(slot.binding)
                    .descriptor_type(slot.kind)
                    .descriptor_count(1)
                    .stage_flags(vk::ShaderStageFlags::COMPUTE)
            })
            .collect();
        let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
        // SAFETY: the device is alive; `info` points to a local.
        self.set_layout = unsafe { raw.create_descriptor_set_layout(&info, None) }
            .map_err(|e| ("vkCreateDescriptorSetLayout", e))?;
        let sets = [self.set_layout];
        let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&sets);
        // SAFETY: as above.
        self.layout = unsafe { raw.create_pipeline_layout(&info, None) }
            .map_err(|e| ("vkCreatePipelineLayout", e))?;

        let info = vk::ShaderModuleCreateInfo::default().code(words);
        // SAFETY: the words are SPIR-V that naga validated, of a version that the device takes.
        let module = unsafe { raw.create_shader_module(&info, None) }
            .map_err(|e| ("vkCreateShaderModule", e))?;
        let stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module)
            .name(c"main");
        let info = [vk::ComputePipelineCreateInfo::default()
            .stage(stage)
            .layout(self.layout)];
        // SAFETY: layout and module belong to this device; the pipeline cache synchronizes itself.
        let made = unsafe { raw.create_compute_pipelines(device.pipeline_cache, &info, None) };
        // SAFETY: a pipeline does not need its module any more once it is made, or was not made.
        unsafe { raw.destroy_shader_module(module, None) };
        let pipelines = made.map_err(|(_, e)| ("vkCreateComputePipelines", e))?;
        self.pipeline = pipelines.first().copied().unwrap_or_default();
        Ok(())
    }

    /// Gives everything back.
    ///
    /// # Safety
    /// Nothing on the device uses the kernel, and nothing will.
    pub unsafe fn destroy(&self, raw: &ash::Device) {
        // SAFETY: the caller's promise; null handles are ignored.
        unsafe {
            raw.destroy_pipeline(self.pipeline, None);
            raw.destroy_pipeline_layout(self.layout, None);
            raw.destroy_descriptor_set_layout(self.set_layout, None);
        }
    }
}
