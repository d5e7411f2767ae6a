//! Steps as commands.
use crate::barriers::{Barrier, plan};
use crate::bound::Bound;
use crate::descriptors::Descriptors;
use crate::device::Device;
use crate::imports::Imports;
use crate::kernels::Kernel;
use crate::timing::Timer;
use ash::vk;
use gibs_graph::{Action, BackendError, DispatchSize, DispatchStep, Schedule, unknown_step};
use std::ffi::CString;
use std::sync::Arc;

/// A schedule resolved to handles, for frames of both parities. The handles belong to the executable that holds it, or
/// to its host.
pub(crate) struct Program {
    steps: Vec<Command>,
    barriers: Vec<Option<Barrier>>,
    labels: Vec<CString>,
    /// Of each parity, what a host lent when its handles were looked up; `None` before that.
    resolved: [Option<Imports>; 2],
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

/// Fails for a step that the backend does not know.
pub(crate) fn known(schedule: &Schedule) -> Result<(), BackendError> {
    let unknown = schedule.steps.iter().find(|step| match &step.action {
        Action::Clear(_) => false,
        Action::Dispatch(dispatch) => !matches!(
            dispatch.size,
            DispatchSize::Groups(_) | DispatchSize::Indirect(_)
        ),
        _ => true,
    });
    unknown.map_or(Ok(()), |step| Err(unknown_step(&step.label)))
}

impl Program {
    /// Turns every step into a command; [`known`] has looked at them. `kernels` has an entry per step.
    pub fn new(schedule: &Schedule, kernels: &[Option<Arc<Kernel>>], bound: Bound<'_>) -> Self {
        let dispatch = |i: usize, dispatch: &DispatchStep| {
            let kernel = kernels[i].as_deref()?;
            let size = match dispatch.size {
                DispatchSize::Groups(groups) if groups.contains(&0) => return None,
                DispatchSize::Groups(groups) => Size::Groups(groups),
                DispatchSize::Indirect(_) => Size::Indirect(Default::default()),
                _ => return None,
            };
            let (pipeline, layout) = (kernel.pipeline, kernel.layout);
            Some(Command::Dispatch {
                pipeline,
                layout,
                sets: Default::default(),
                size,
            })
        };
        let steps = schedule.steps.iter().enumerate().map(|(i, step)| {
            let command = match &step.action {
                Action::Clear(id) => bound.buffer(*id, 0).map(|buffer| {
                    // Not the whole buffer, which may be at home to something larger.
                    let bytes = schedule.resources[*id as usize].bytes;
                    let size = bytes.next_multiple_of(4);
                    Command::Clear { buffer, size }
                }),
                Action::Dispatch(step) => dispatch(i, step),
                _ => None,
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
            resolved: [None, None],
        }
    }

    /// Frames of this parity use what is lent now.
    pub fn is_resolved(&self, parity: usize, imports: &Imports) -> bool {
        self.resolved[parity].as_ref() == Some(imports)
    }

    /// Looks up what frames of this parity bind. All memory that is not lent must be there.
    pub fn resolve(
        &mut self,
        schedule: &Schedule,
        descriptors: &mut Descriptors,
        bound: Bound<'_>,
        parity: usize,
    ) -> Result<(), BackendError> {
        let mut before = self.resolved[parity].take();
        for (i, _, dispatch) in schedule.dispatches() {
            let Command::Dispatch { sets, size, .. } = &mut self.steps[i] else {
                continue;
            };
            sets[parity] = descriptors.set(schedule, i, dispatch, bound, parity)?;
            if let (Size::Indirect(buffers), DispatchSize::Indirect(id)) = (size, dispatch.size) {
                buffers[parity] = bound.buffer(id, parity).unwrap_or_default();
            }
        }
        before.get_or_insert_default().copy(bound.imports);
        self.resolved[parity] = before;
        Ok(())
    }

    /// Forgets what frames bind.
    pub fn forget(&mut self) {
        self.resolved = [None, None];
    }

    /// Records a whole frame of one parity. Everything before it must be ordered already.
    ///
    /// # Safety
    /// `commands` is being recorded; the program is resolved for this parity, and nothing that it refers to goes before
    /// the work is done.
    pub unsafe fn record_frame(
        &self,
        device: &Device,
        commands: vk::CommandBuffer,
        parity: usize,
        timer: Option<&Timer>,
    ) {
        // SAFETY: the caller's promise.
        unsafe {
            if let Some(timer) = timer {
                timer.start(commands, parity);
            }
            let imports = self.resolved[parity].as_ref();
            if let Some(imports) = imports {
                imports.enter(&device.raw, commands);
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
            if let Some(imports) = imports {
                imports.leave(&device.raw, commands);
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
            let imports = self.resolved[parity].as_ref();
            if let Some(imports) = imports {
                imports.enter(&device.raw, commands);
            }
            self.steps[step].record(&device.raw, commands, parity);
            if let Some(imports) = imports {
                imports.leave(&device.raw, commands);
            }
        }
    }
}

impl Command {
    /// # Safety
    /// As [`Program::record_frame`].
    unsafe fn record(&self, device: &ash::Device, commands: vk::CommandBuffer, parity: usize) {
        // SAFETY: the caller's promise; pipelines, layouts and sets were made for each other, and what is cleared is
        // inside its buffer, whose size is a multiple of 4.
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
