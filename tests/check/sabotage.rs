//! A backend that does one thing wrong.
use gibs::graph::{
    Backend, BackendError, Capabilities, DeviceInfo, Executable, ResourceId, Schedule,
};
use std::sync::Arc;

/// What is done to the bytes that a step has written.
pub type Damage = fn(&mut [u8]);

/// A backend that damages what one step writes, from one frame on.
pub struct Sabotaged {
    pub inner: Box<dyn Backend>,
    /// Type name of the stage.
    pub stage: &'static str,
    /// Port that is damaged.
    pub port: &'static str,
    /// First frame in which it is.
    pub from: u32,
    pub how: How,
}

/// The ways.
#[derive(Clone, Copy)]
pub enum How {
    /// What was written is changed.
    Damage(Damage),
    /// The stage does not run.
    Skip,
    /// What was written cannot be read in full.
    Truncate,
    /// The step is refused.
    Fail,
}

impl Backend for Sabotaged {
    fn name(&self) -> &str {
        self.inner.name()
    }

    fn device(&self) -> &DeviceInfo {
        self.inner.device()
    }

    fn capabilities(&self) -> &Capabilities {
        self.inner.capabilities()
    }

    fn prepare(&self, schedule: Arc<Schedule>) -> Result<Box<dyn Executable>, BackendError> {
        let found = schedule.dispatches().find_map(|(i, _, dispatch)| {
            let binding = dispatch.bindings.iter().find(|b| b.port == self.port)?;
            (dispatch.stage == self.stage).then_some((i, binding.resource))
        });
        Ok(Box::new(Run {
            inner: self.inner.prepare(schedule)?,
            target: found,
            how: self.how,
            from: self.from,
            frame: 0,
        }))
    }
}

struct Run {
    inner: Box<dyn Executable>,
    /// Step and resource, where the schedule has them.
    target: Option<(usize, ResourceId)>,
    how: How,
    from: u32,
    /// Frames begun.
    frame: u32,
}

impl Executable for Run {
    fn schedule(&self) -> &Arc<Schedule> {
        self.inner.schedule()
    }

    fn upload(&mut self, id: ResourceId, offset: u64, bytes: &[u8]) -> Result<(), BackendError> {
        self.inner.upload(id, offset, bytes)
    }

    fn run(&mut self) -> Result<(), BackendError> {
        self.rotate()?;
        (0..self.schedule().steps.len()).try_for_each(|step| self.run_step(step))
    }

    fn rotate(&mut self) -> Result<(), BackendError> {
        self.frame += 1;
        self.inner.rotate()
    }

    fn run_step(&mut self, step: usize) -> Result<(), BackendError> {
        let hit = self
            .target
            .filter(|(at, _)| *at == step && self.frame > self.from);
        match (hit, self.how) {
            (Some(_), How::Skip) => Ok(()),
            (Some(_), How::Fail) => Err(BackendError::Kernel {
                stage: "a stage".into(),
                message: "as a test wants".into(),
            }),
            (Some((_, id)), How::Damage(damage)) => {
                self.inner.run_step(step)?;
                let mut bytes = self.inner.read(id)?;
                damage(&mut bytes);
                self.inner.upload(id, 0, &bytes)
            }
            _ => self.inner.run_step(step),
        }
    }

    fn read(&mut self, id: ResourceId) -> Result<Vec<u8>, BackendError> {
        let mut bytes = self.inner.read(id)?;
        let hit = self
            .target
            .is_some_and(|(_, target)| target == id && self.frame > self.from);
        if hit && matches!(self.how, How::Truncate) {
            bytes.truncate(bytes.len() / 2);
        }
        Ok(bytes)
    }

    fn reset(&mut self) -> Result<(), BackendError> {
        self.inner.reset()
    }

    fn wait(&mut self) -> Result<(), BackendError> {
        self.inner.wait()
    }

    fn adopt(&mut self, schedule: Arc<Schedule>) -> Result<(), BackendError> {
        self.inner.adopt(schedule)
    }
}
