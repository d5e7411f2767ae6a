//! Steps as commands.
use crate::barriers::{Barrier, plan};
use crate::descriptors::Descriptors;
use crate::device::Device;
use crate::kernels::Kernel;
use crate::storage::Store;
use crate::timing::Timer;
use ash::vk;
use gibs_graph::{Action, DispatchSize, DispatchStep, ResourceId, Schedule};
use std::ffi::CString;
use std::sync::Arc;

/// A schedule resolved to handles, for frames of both parities. The handles belong to the executable that holds it.
pub(crate) struct Program {
    steps: Vec<Command>,
    barriers: Vec<Option<Barrier>>,
    labels: Vec<CString>,
}

/// What a step does on the device. Arrays have an entry for even and one for odd frames.
enum Command {
    /// Nothing: the size is zero, or the resource is not on the device.
    Nothing,
    Clear {
        buffer: vk::Buffer,
        size: u64,
    },
    Dispatch {
        pipeline: vk::Pipeline,
        layout: vk::PipelineLayout,
        sets: [vk::DescriptorSet; 2],
        size: Size,
    },
}

enum Size {
    Groups([u32; 3]),
    Indirect([vk::Buffer; 2]),
}

impl Program {
    /// Resolves every step. `kernels` has an entry per step, `stores` one per resource.
    pub fn new(
        schedule: &Schedule,
        kernels: &[Option<Arc<Kernel>>],
        stores: &[Option<Store>],
        descriptors: &Descriptors,
    ) -> Self {
        let store = |resource: ResourceId| stores[resource as usize].as_ref();
        let dispatch = |i: usize, dispatch: &DispatchStep| {
            let kernel = kernels[i].as_deref()?;
            let size = match dispatch.size {
                DispatchSize::Groups(groups) if groups.contains(&0) => return None,
                DispatchSize::Groups(groups) => Size::Groups(groups),
                DispatchSize::Indirect(resource) => {
                    let store = store(resource)?;
                    Size::Indirect([store.current(0).raw, store.current(1).raw])
                }
            };
            let (pipeline, layout) = (kernel.pipeline, kernel.layout);
            Some(Command::Dispatch {
                pipeline,
                layout,
                sets: descriptors.of(i),
                size,
            })
        };
        let steps = schedule.steps.iter().enumerate().map(|(i, step)| {
            let command = match &step.action {
                Action::Clear(resource) => store(*resource).map(|store| {
                    let buffer = store.current(0);
                    Command::Clear {
                        buffer: buffer.raw,
                        size: buffer.size,
                    }
                }),
                Action::Dispatch(step) => dispatch(i, step),
            };
            command.unwrap_or(Command::Nothing)
        });
        let labels = schedule
            .steps
            .iter()
            .map(|step| CString::new(step.label.as_str()));
        Self {
            steps: steps.collect(),
            barriers: plan(schedule),
            labels: labels.map(Result::unwrap_or_default).collect(),
        }
    }

    /// Records a whole frame of one parity.
    ///
    /// # Safety
    /// `commands` is being recorded; nothing that the program refers to goes before its work is done.
    pub unsafe fn record_frame(
        &self,
        device: &Device,
        commands: vk::CommandBuffer,
        parity: usize,
        timer: Option<&Timer>,
    ) {
        // SAFETY: the caller's promise.
        unsafe {
            // Behind the frame before and the uploads.
            Barrier::FULL.record(&device.raw, commands);
            if let Some(timer) = timer {
                timer.start(commands, parity);
            }
            for (i, step) in self.steps.iter().enumerate() {
                device.begin_label(commands, &self.labels[i]);
                if let Some(barrier) = self.barriers[i] {
                    barrier.record(&device.raw, commands);
                }
                step.record(&device.raw, commands, parity);
                device.end_label(commands);
                if let Some(timer) = timer {
                    timer.end_step(commands, parity, i);
                }
            }
        }
    }

    /// Records one step, behind everything before it.
    ///
    /// # Safety
    /// As [`Program::record_frame`].
    pub unsafe fn record_step(
        &self,
        device: &Device,
        commands: vk::CommandBuffer,
        parity: usize,
        step: usize,
    ) {
        // SAFETY: the caller's promise.
        unsafe {
            Barrier::FULL.record(&device.raw, commands);
            self.steps[step].record(&device.raw, commands, parity);
        }
    }
}

impl Command {
    /// # Safety
    /// As [`Program::record_frame`].
    unsafe fn record(&self, device: &ash::Device, commands: vk::CommandBuffer, parity: usize) {
        // SAFETY: the caller's promise; pipelines, layouts and sets were made for each other, and clears cover whole
        // buffers, whose size is a multiple of 4.
        unsafe {
            match self {
                Command::Nothing => {}
                Command::Clear { buffer, size } => {
                    device.cmd_fill_buffer(commands, *buffer, 0, *size, 0);
                }
                Command::Dispatch {
                    pipeline,
                    layout,
                    sets,
                    size,
                } => {
                    let point = vk::PipelineBindPoint::COMPUTE;
                    device.cmd_bind_pipeline(commands, point, *pipeline);
                    let set = [sets[parity]];
                    if set != [vk::DescriptorSet::null()] {
                        device.cmd_bind_descriptor_sets(commands, point, *layout, 0, &set, &[]);
                    }
                    match size {
                        Size::Groups([x, y, z]) => device.cmd_dispatch(commands, *x, *y, *z),
                        Size::Indirect(buffers) => {
                            device.cmd_dispatch_indirect(commands, buffers[parity], 0);
                        }
                    }
                }
            }
        }
    }
}
