//! Pipelines: each kernel compiled once per device, with a layout that follows from the stage's ports.
use crate::buffers::Parity;
use crate::context::{Context, lock, said};
use crate::images;
use crate::passthrough;
use crate::stores::Stores;
use gibs_graph::{Access, BackendError, DispatchStep, ImageFormat, Port, Schedule};
use gibs_shaders::on_all_cores;
use std::borrow::Cow;
use std::collections::HashMap;
use std::num::NonZeroU64;
use std::sync::Arc;

/// Kernels that have been built.
pub(crate) type KernelCache = HashMap<Key, Arc<Kernel>>;

/// What makes two kernels the same. The text is part of it because names are only a convention.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(crate) struct Key {
    name: &'static str,
    text: &'static str,
    features: Vec<&'static str>,
    slots: Vec<(&'static str, Slot)>,
}

/// How the device sees a port.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Slot {
    Uniform,
    ReadOnly,
    ReadWrite,
    Image(ImageFormat),
    Structure,
}

/// A kernel, ready to bind.
pub(crate) struct Kernel {
    pub pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
    /// Binding number of each bound port.
    numbers: Vec<(&'static str, u32)>,
}

/// The kernel of every step of a schedule (`None` for a clear), in order. Those that were not built before are, on all cores.
///
/// # Errors
/// [`BackendError::Kernel`] of the first stage whose kernel is refused, with what the compiler or the driver said.
pub(crate) fn kernels(
    context: &Context,
    schedule: &Schedule,
) -> Result<Vec<Option<Arc<Kernel>>>, BackendError> {
    let mut missing: Vec<(Key, &str, &DispatchStep)> = Vec::new();
    // Held to the end, so that two threads do not build the same kernel.
    let mut known = lock(&context.kernels);
    for (_, step, dispatch) in schedule.dispatches() {
        let key = Key::of(dispatch);
        if !known.contains_key(&key) && !missing.iter().any(|(other, ..)| *other == key) {
            missing.push((key, &step.label, dispatch));
        }
    }
    let built = on_all_cores(&missing, |(key, label, dispatch)| {
        build(context, label, dispatch, &key.slots)
    });
    let mut refused = None;
    for ((key, ..), built) in missing.into_iter().zip(built) {
        match built {
            Ok(kernel) => drop(known.insert(key, Arc::new(kernel))),
            Err(error) => refused = refused.or(Some(error)),
        }
    }
    if let Some(error) = refused {
        return Err(error);
    }
    let mut kernels = vec![None; schedule.steps.len()];
    for (i, _, dispatch) in schedule.dispatches() {
        kernels[i] = known.get(&Key::of(dispatch)).map(Arc::clone);
    }
    Ok(kernels)
}

impl Key {
    fn of(dispatch: &DispatchStep) -> Self {
        let source = &dispatch.kernel.wgsl;
        let slots = dispatch.ports.iter();
        Self {
            name: source.name,
            text: source.text,
            features: dispatch.features(),
            slots: slots
                .filter_map(|port| Some((port.name, slot(port)?)))
                .collect(),
        }
    }
}

fn slot(port: &Port) -> Option<Slot> {
    match port.access {
        Access::Uniform => Some(Slot::Uniform),
        Access::Read | Access::Previous => Some(Slot::ReadOnly),
        Access::Write | Access::ReadWrite | Access::Atomic => Some(Slot::ReadWrite),
        Access::Sampled | Access::Stored => port.image.map(Slot::Image),
        Access::Acceleration => Some(Slot::Structure),
        _ => None,
    }
}

fn build(
    context: &Context,
    label: &str,
    dispatch: &DispatchStep,
    slots: &[(&'static str, Slot)],
) -> Result<Kernel, BackendError> {
    let refuse = |message: String| BackendError::Kernel {
        stage: label.into(),
        message,
    };
    let name = dispatch.kernel.wgsl.name;
    let compiled = context
        .compiler
        .compile(&dispatch.kernel.wgsl, &dispatch.ports)
        .map_err(|error| refuse(error.to_string()))?;
    let mut numbers = Vec::with_capacity(slots.len());
    let mut entries = Vec::with_capacity(slots.len());
    for &(port, slot) in slots {
        let Some(binding) = compiled.binding(port) else {
            return Err(refuse(format!(
                "{} has no global for the port `{port}`; declare it in @group(0)",
                name
            )));
        };
        numbers.push((port, binding));
        entries.push(layout_entry(binding, slot));
    }
    let made = context.guard_as(
        || {
            let device = &context.device;
            let module = if context.same_spirv {
                passthrough::module(context, name, &compiled)?
            } else {
                device.create_shader_module(wgpu::ShaderModuleDescriptor {
                    label: Some(name),
                    source: wgpu::ShaderSource::Wgsl(Cow::Borrowed(compiled.wgsl())),
                })
            };
            let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(name),
                entries: &entries,
            });
            let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(name),
                bind_group_layouts: &[Some(&layout)],
                immediate_size: 0,
            });
            let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(name),
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some("main"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            });
            Ok::<_, String>((layout, pipeline))
        },
        |error| refuse(said(&error)),
    )?;
    let (layout, pipeline) = made.map_err(refuse)?;
    Ok(Kernel {
        pipeline,
        layout,
        numbers,
    })
}

fn layout_entry(binding: u32, slot: Slot) -> wgpu::BindGroupLayoutEntry {
    let buffer = |ty| wgpu::BindingType::Buffer {
        ty,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let ty = match slot {
        Slot::Uniform => buffer(wgpu::BufferBindingType::Uniform),
        Slot::ReadOnly => buffer(wgpu::BufferBindingType::Storage { read_only: true }),
        Slot::ReadWrite => buffer(wgpu::BufferBindingType::Storage { read_only: false }),
        Slot::Image(format) => images::binding_type(format),
        Slot::Structure => wgpu::BindingType::AccelerationStructure {
            vertex_return: false,
        },
    };
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty,
        count: None,
    }
}

/// The bind groups of a stage, one per parity; the same one twice where no history is involved. Everything that the
/// stage binds must be there.
///
/// # Errors
/// [`BackendError::Kernel`] with what wgpu said.
pub(crate) fn bind(
    context: &Context,
    label: &str,
    kernel: &Kernel,
    dispatch: &DispatchStep,
    schedule: &Schedule,
    stores: &Stores,
) -> Result<[wgpu::BindGroup; 2], BackendError> {
    let refuse = |message: String| BackendError::Kernel {
        stage: label.into(),
        message,
    };
    let make = |parity: Parity| {
        let mut entries = Vec::with_capacity(kernel.numbers.len());
        for binding in dispatch.bindings.iter().filter(|b| b.access.is_bound()) {
            let number = kernel
                .numbers
                .iter()
                .find(|(port, _)| *port == binding.port)
                .map(|(_, number)| *number);
            let bound = if binding.access == Access::Acceleration {
                stores
                    .structures
                    .top(binding.resource)
                    .map(wgpu::BindingResource::AccelerationStructure)
            } else if binding.access.is_image() {
                stores
                    .view(binding.resource)
                    .map(wgpu::BindingResource::TextureView)
            } else {
                let resource = &schedule.resources[binding.resource as usize];
                // Exactly the elements, so that arrayLength is the number of them; of a uniform the first.
                let size = match binding.access {
                    Access::Uniform => resource.element.size().into(),
                    _ => resource.bytes,
                };
                let buffer = match binding.access {
                    Access::Previous => stores.previous(binding.resource, parity),
                    _ => stores.current(binding.resource, parity),
                };
                buffer.map(|buffer| {
                    wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                        buffer,
                        offset: 0,
                        size: NonZeroU64::new(size),
                    })
                })
            };
            let (Some(resource), Some(binding)) = (bound, number) else {
                return Err(refuse(format!(
                    "the port `{}` is bound but was not declared",
                    binding.port
                )));
            };
            entries.push(wgpu::BindGroupEntry { binding, resource });
        }
        let descriptor = wgpu::BindGroupDescriptor {
            label: Some(label),
            layout: &kernel.layout,
            entries: &entries,
        };
        context.guard_as(
            || context.device.create_bind_group(&descriptor),
            |error| refuse(said(&error)),
        )
    };
    let [even, odd] = Parity::BOTH;
    let first = make(even)?;
    let rotates = dispatch
        .bindings
        .iter()
        .any(|b| stores.is_history(b.resource));
    let second = if rotates { make(odd)? } else { first.clone() };
    Ok([first, second])
}
