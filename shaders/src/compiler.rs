//! From a kernel's source to what devices take.
use crate::compose::{Composed, File, Place, Target, compose};
use crate::validate::{capabilities, validate};
use crate::{ShaderError, names};
use gibs_graph::{Port, WgslSource};
use naga::back::{pipeline_constants, spv};
use naga::proc::{BoundsCheckPolicies, BoundsCheckPolicy};
use naga::valid::ModuleInfo;
use naga::{GlobalVariable, Handle, Module, ShaderStage};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Composes and validates kernels, and holds them against ports. Remembers what it compiled; may be shared by threads.
#[derive(Debug, Default)]
pub struct Compiler {
    compiled: Mutex<HashMap<Key, CompiledKernel>>,
}

/// What tells kernels apart. The text counts, because nothing keeps two sources from sharing a name.
#[derive(Debug, PartialEq, Eq, Hash)]
struct Key {
    name: &'static str,
    features: Vec<&'static str>,
    text: &'static str,
    modules: &'static [(&'static str, &'static str)],
}

/// A valid kernel. Clones share it.
#[derive(Clone, Debug)]
pub struct CompiledKernel {
    pub(crate) inner: Arc<Inner>,
}

#[derive(Debug)]
pub(crate) struct Inner {
    pub name: &'static str,
    pub composed: Composed,
    pub module: Module,
    pub info: ModuleInfo,
    /// The module with a value for every `override`, where it has such.
    resolved: Option<(Module, ModuleInfo)>,
}

impl Compiler {
    /// A compiler that has compiled nothing yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Composes, parses and validates a kernel for a stage with these bound ports: the optional ones among them are
    /// features of it.
    ///
    /// # Errors
    /// The first problem, with its place in the original files.
    pub fn compile(
        &self,
        source: &WgslSource,
        ports: &[Port],
    ) -> Result<CompiledKernel, ShaderError> {
        let WgslSource {
            name,
            text,
            modules,
            ..
        } = *source;
        let features = gibs_graph::features(source, ports);
        let key = Key {
            name,
            features,
            text,
            modules,
        };
        let known = self
            .compiled
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .get(&key)
            .cloned();
        if let Some(kernel) = known {
            return Ok(kernel);
        }
        let kernel = CompiledKernel {
            inner: Arc::new(Inner::new(source, &key.features)?),
        };
        self.compiled
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .insert(key, kernel.clone());
        Ok(kernel)
    }
}

impl Inner {
    fn new(source: &WgslSource, features: &[&'static str]) -> Result<Self, ShaderError> {
        let name = source.name;
        let modules: Vec<File<'_>> = source
            .modules
            .iter()
            .map(|(path, text)| File::new(path, text))
            .collect();
        let composed = compose(
            &File::new(name, source.text),
            &modules,
            features,
            Target::Naga,
        )?;
        let (module, info) =
            validate(&composed, capabilities(features)).map_err(|source| ShaderError::Wgsl {
                kernel: name.into(),
                source,
            })?;
        let resolved = if module.overrides.is_empty() {
            None
        } else {
            let main = Some((ShaderStage::Compute, "main"));
            let (module, info) =
                pipeline_constants::process_overrides(&module, &info, main, &Default::default())
                    .map_err(|e| ShaderError::Override {
                        kernel: name.into(),
                        message: e.to_string(),
                    })?;
            Some((module.into_owned(), info.into_owned()))
        };
        Ok(Inner {
            name,
            composed,
            module,
            info,
            resolved,
        })
    }

    fn resolved(&self) -> (&Module, &ModuleInfo) {
        self.resolved
            .as_ref()
            .map_or((&self.module, &self.info), |(module, info)| (module, info))
    }

    pub fn workgroup_size(&self) -> [u32; 3] {
        self.resolved()
            .0
            .entry_points
            .first()
            .map_or([0; 3], |main| main.workgroup_size)
    }

    /// Where a global is declared.
    pub fn place(&self, global: Handle<GlobalVariable>) -> Place {
        let span = self.module.global_variables.get_span(global).to_range();
        self.composed.place(span.map_or(0, |s| s.start))
    }
}

/// Version of SPIR-V that backends ask for: what every device with Vulkan 1.2 takes.
pub const SPIRV: (u8, u8) = (1, 4);

impl CompiledKernel {
    /// The composed plain text, which wgpu takes. Its entry point is `main`.
    pub fn wgsl(&self) -> &str {
        self.inner.composed.text()
    }

    /// `n` of the `@group(0) @binding(n)` of the global that belongs to `port`.
    pub fn binding(&self, port: &str) -> Option<u32> {
        let name = names::global(port);
        let mut globals = self.inner.module.global_variables.iter();
        let (_, global) = globals.find(|(_, g)| g.name.as_deref() == Some(&*name))?;
        global.binding.filter(|b| b.group == 0).map(|b| b.binding)
    }

    /// Binding in set 0 of the SPIR-V of the global that belongs to `port`.
    pub fn spirv_binding(&self, port: &str) -> Option<u32> {
        let binding = self.binding(port)?;
        let order = self.bindings_in_order();
        order
            .iter()
            .position(|b| (b.group, b.binding) == (0, binding))
            .map(|place| place as u32)
    }

    /// Group 0 comes first.
    fn bindings_in_order(&self) -> Vec<naga::ResourceBinding> {
        let globals = self.inner.module.global_variables.iter();
        let mut bindings: Vec<_> = globals.filter_map(|(_, global)| global.binding).collect();
        bindings.sort_unstable_by_key(|b| (b.group, b.binding));
        bindings
    }

    /// Invocations per workgroup along x, y and z.
    pub fn workgroup_size(&self) -> [u32; 3] {
        self.inner.workgroup_size()
    }

    /// SPIR-V of a version such as [`SPIRV`]. Bindings of a set are numbered from 0 without gaps, in the order of those of
    /// the WGSL: so does wgpu number them, whether it writes the SPIR-V or is given it.
    ///
    /// Reads and writes beyond the end of a buffer are made harmless, and loops are made finite, as in WebGPU.
    ///
    /// # Errors
    /// What naga cannot write in that version.
    pub fn spirv(&self, version: (u8, u8)) -> Result<Vec<u32>, ShaderError> {
        let (module, info) = self.inner.resolved();
        let order = self.bindings_in_order();
        let numbered = order.iter().map(|&b| {
            let first = order.iter().position(|other| other.group == b.group);
            let place = order.iter().position(|&other| other == b);
            let info = spv::BindingInfo {
                descriptor_set: b.group,
                binding: (place.unwrap_or_default() - first.unwrap_or_default()) as u32,
                binding_array_size: None,
            };
            (b, info)
        });
        let options = spv::Options {
            lang_version: version,
            flags: spv::WriterFlags::DEBUG,
            fake_missing_bindings: false,
            binding_map: numbered.collect(),
            bounds_check_policies: BoundsCheckPolicies {
                index: BoundsCheckPolicy::Restrict,
                buffer: BoundsCheckPolicy::Restrict,
                // `Restrict` is not valid SPIR-V where coordinates are unsigned: naga subtracts a signed one.
                image_load: BoundsCheckPolicy::ReadZeroSkipWrite,
                binding_array: BoundsCheckPolicy::Unchecked,
            },
            zero_initialize_workgroup_memory: spv::ZeroInitializeWorkgroupMemoryMode::Native,
            force_loop_bounding: true,
            ray_query_initialization_tracking: true,
            ..Default::default()
        };
        let main = spv::PipelineOptions {
            shader_stage: ShaderStage::Compute,
            entry_point: "main".into(),
        };
        spv::write_vec(module, info, &options, Some(&main)).map_err(|e| ShaderError::Spirv {
            kernel: self.inner.name.into(),
            version,
            message: e.to_string(),
        })
    }
}

#[cfg(test)]
mod tests;
