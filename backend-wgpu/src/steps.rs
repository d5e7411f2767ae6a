//! Steps with their kernels, and bind groups for whatever they bind at the time.
use crate::buffers::Parity;
use crate::context::Context;
use crate::kernels::{Kernel, bind, kernels};
use crate::stores::{Import, Stores};
use gibs_graph::{
    Action, BackendError, DispatchSize, DispatchStep, Kind, ResourceId, Schedule, unknown_step,
};
use std::sync::Arc;

/// The steps of a schedule.
pub(crate) struct Steps {
    schedule: Arc<Schedule>,
    steps: Vec<Step>,
    /// Stages bind something that no bind group has yet.
    unbound: bool,
}

/// A step with everything that recording it takes.
pub(crate) enum Step {
    Clear {
        /// Index in the schedule.
        step: usize,
        resource: ResourceId,
        bytes: u64,
    },
    Dispatch(Box<Dispatch>),
}

pub(crate) struct Dispatch {
    /// Index in the schedule.
    pub step: usize,
    pub label: String,
    pub kernel: Arc<Kernel>,
    pub size: DispatchSize,
    /// Every set of bind groups that was needed so far, with what it has from the host.
    groups: Vec<(Vec<Import>, [wgpu::BindGroup; 2])>,
    /// Index of the set for the next frame.
    chosen: usize,
    /// What it binds that a host may give.
    imports: Vec<ResourceId>,
}

impl Dispatch {
    /// What it binds in a frame of this parity.
    pub fn group(&self, parity: Parity) -> Option<&wgpu::BindGroup> {
        let (_, groups) = self.groups.get(self.chosen)?;
        Some(&groups[parity.index()])
    }

    /// Finds or makes the bind groups for what the step, as `declared`, binds now.
    fn bind(
        &mut self,
        context: &Context,
        schedule: &Schedule,
        declared: &DispatchStep,
        stores: &mut Stores,
    ) -> Result<(), BackendError> {
        let now = || self.imports.iter().filter_map(|&r| stores.import(r));
        let mut known = self.groups.iter();
        if let Some(known) = known.position(|(imports, _)| imports.iter().eq(now())) {
            self.chosen = known;
            return Ok(());
        }
        let imports = now().cloned().collect();
        for binding in declared.bindings.iter().filter(|b| b.access.is_image()) {
            if stores.import(binding.resource).is_none() {
                stores.own_image(context, binding.resource)?;
            }
        }
        let groups = bind(
            context,
            &self.label,
            &self.kernel,
            declared,
            schedule,
            stores,
        )?;
        self.chosen = self.groups.len();
        self.groups.push((imports, groups));
        Ok(())
    }
}

impl Steps {
    /// Builds every kernel.
    pub fn new(context: &Context, schedule: &Arc<Schedule>) -> Result<Self, BackendError> {
        for (_, step, dispatch) in schedule.dispatches() {
            let (DispatchSize::Groups(_) | DispatchSize::Indirect(_)) = dispatch.size else {
                return Err(unknown_step(&step.label));
            };
        }
        let kernels = kernels(context, schedule)?;
        let mut steps = Vec::with_capacity(schedule.steps.len());
        for ((i, step), kernel) in schedule.steps.iter().enumerate().zip(kernels) {
            let label = &step.label;
            steps.push(match (&step.action, kernel) {
                (&Action::Clear(resource), _) => Step::Clear {
                    step: i,
                    resource,
                    bytes: schedule.resources[resource as usize].bytes,
                },
                (Action::Dispatch(dispatch), Some(kernel)) => Step::Dispatch(Box::new(Dispatch {
                    step: i,
                    label: label.clone(),
                    kernel,
                    size: dispatch.size,
                    groups: Vec::new(),
                    chosen: 0,
                    imports: importable(schedule, dispatch),
                })),
                _ => return Err(unknown_step(label)),
            });
        }
        Ok(Self {
            schedule: Arc::clone(schedule),
            steps,
            unbound: true,
        })
    }

    /// All of them, in order.
    pub fn all(&self) -> &[Step] {
        &self.steps
    }

    /// A host gave something else to bind.
    pub fn unbind(&mut self) {
        self.unbound = true;
    }

    /// Forgets every bind group.
    pub fn forget(&mut self) {
        for step in &mut self.steps {
            if let Step::Dispatch(dispatch) = step {
                dispatch.groups.clear();
            }
        }
        self.unbound = true;
    }

    /// Makes or finds the bind groups for what stages bind now.
    pub fn bind(&mut self, context: &Context, stores: &mut Stores) -> Result<(), BackendError> {
        if !self.unbound {
            return Ok(());
        }
        for (declared, step) in self.schedule.steps.iter().zip(&mut self.steps) {
            if let (Action::Dispatch(declared), Step::Dispatch(dispatch)) = (&declared.action, step)
            {
                dispatch.bind(context, &self.schedule, declared, stores)?;
            }
        }
        // Until all is bound, another call starts over.
        self.unbound = false;
        Ok(())
    }
}

/// What a stage binds that a host may give.
fn importable(schedule: &Schedule, dispatch: &DispatchStep) -> Vec<ResourceId> {
    let bound = dispatch.bindings.iter().filter(|b| b.access.is_bound());
    let mut found: Vec<ResourceId> = bound.map(|b| b.resource).collect();
    found.retain(|&r| {
        !matches!(
            schedule.resources[r as usize].kind,
            Kind::State(_) | Kind::History(_)
        )
    });
    found
}
