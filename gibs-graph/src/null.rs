//! A backend without a device.
use crate::{
    Action, Backend, BackendError, Capabilities, DeviceInfo, Executable, Kind, Resource,
    ResourceId, Schedule, check_image, check_range, check_step,
};
use std::sync::Arc;

const NAME: &str = "null";

/// Runs no kernel, and keeps the rest of a backend's promises: for tests of what is built on graphs, where neither a
/// device nor the light matters.
///
/// Uploads, reads, adoption, resets, the rotation of histories and clears are those of any backend. What only a kernel
/// would write keeps what was uploaded into it, or else is zero. Memory is taken when a resource is first touched, so
/// that a schedule of any size is prepared at once.
///
/// ```
/// use gibs_graph::{Backend, Graph, NullBackend};
///
/// let mut g = Graph::new("example");
/// let numbers = g.input::<u32>("numbers", 2);
/// g.output("numbers", &numbers);
/// let schedule = g.compile(None).unwrap();
///
/// let mut exec = NullBackend::new().prepare(schedule.into()).unwrap();
/// exec.upload(0, 4, &7_u32.to_ne_bytes()).unwrap();
/// exec.run().unwrap();
/// assert_eq!(exec.read(0).unwrap(), [0, 7_u32].map(u32::to_ne_bytes).concat());
/// assert!(exec.upload(0, 8, &[1]).is_err());
/// ```
#[derive(Clone, Debug)]
pub struct NullBackend {
    device: DeviceInfo,
    capabilities: Capabilities,
}

impl NullBackend {
    /// A backend without limits.
    pub fn new() -> Self {
        Self::with_capabilities(Capabilities::unlimited())
    }

    /// A backend that refuses what a device with these capabilities would.
    pub fn with_capabilities(capabilities: Capabilities) -> Self {
        Self {
            device: DeviceInfo {
                name: NAME.into(),
                driver: format!("gibs {}", env!("CARGO_PKG_VERSION")),
                kind: "software".into(),
                timestamps: false,
                ray_query: false,
                notes: Vec::new(),
            },
            capabilities,
        }
    }
}

impl Default for NullBackend {
    fn default() -> Self {
        Self::new()
    }
}

impl Backend for NullBackend {
    fn name(&self) -> &str {
        NAME
    }

    fn device(&self) -> &DeviceInfo {
        &self.device
    }

    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn prepare(&self, schedule: Arc<Schedule>) -> Result<Box<dyn Executable>, BackendError> {
        self.capabilities.check(NAME, &schedule)?;
        Ok(Box::new(NullExecutable {
            contents: nothing(&schedule),
            capabilities: self.capabilities.clone(),
            schedule,
        }))
    }
}

fn nothing(schedule: &Schedule) -> Vec<Content> {
    let mut contents = Vec::new();
    contents.resize_with(schedule.resources.len(), Content::default);
    contents
}

/// Bytes of a resource; `None` as long as they are what it starts with.
#[derive(Debug, Default)]
struct Content {
    current: Option<Vec<u8>>,
    /// Of a history.
    previous: Option<Vec<u8>>,
}

#[derive(Debug)]
struct NullExecutable {
    schedule: Arc<Schedule>,
    capabilities: Capabilities,
    contents: Vec<Content>,
}

/// What a resource starts with.
fn first(resource: &Resource) -> Result<Vec<u8>, BackendError> {
    let oom = || BackendError::OutOfMemory {
        device: NAME.into(),
        resource: resource.key.clone(),
        bytes: resource.bytes,
    };
    let size = usize::try_from(resource.bytes).map_err(|_| oom())?;
    let mut bytes = Vec::new();
    // Asked for first, because a vector that cannot grow ends the process.
    bytes.try_reserve_exact(size).map_err(|_| oom())?;
    match &resource.kind {
        Kind::State(initial) | Kind::History(initial) => bytes = initial.bytes(size),
        Kind::Input | Kind::Transient | Kind::Zeroed => bytes.resize(size, 0),
    }
    Ok(bytes)
}

impl NullExecutable {
    fn current(&mut self, id: ResourceId) -> Result<&mut Vec<u8>, BackendError> {
        let current = &mut self.contents[id as usize].current;
        match current {
            Some(bytes) => Ok(bytes),
            None => Ok(current.insert(first(&self.schedule.resources[id as usize])?)),
        }
    }

    fn step(&mut self, step: usize) {
        if let Action::Clear(id) = self.schedule.steps[step].action {
            self.contents[id as usize].current = None;
        }
    }
}

impl Executable for NullExecutable {
    fn schedule(&self) -> &Arc<Schedule> {
        &self.schedule
    }

    fn upload(
        &mut self,
        resource: ResourceId,
        offset: u64,
        bytes: &[u8],
    ) -> Result<(), BackendError> {
        check_range(&self.schedule, resource, offset, bytes.len())?;
        let found = &self.schedule.resources[resource as usize];
        if let Some(image) = found.image {
            check_image(found, bytes.len())?;
            let values = image.format.decode(&image.format.encode(bytes));
            self.current(resource)?[..values.len()].copy_from_slice(&values);
            return Ok(());
        }
        let memory = self.current(resource)?;
        memory[offset as usize..][..bytes.len()].copy_from_slice(bytes);
        Ok(())
    }

    fn run(&mut self) -> Result<(), BackendError> {
        self.rotate()?;
        (0..self.schedule.steps.len()).for_each(|step| self.step(step));
        Ok(())
    }

    fn rotate(&mut self) -> Result<(), BackendError> {
        for (content, resource) in self.contents.iter_mut().zip(&self.schedule.resources) {
            if let Kind::History(_) = resource.kind {
                std::mem::swap(&mut content.current, &mut content.previous);
            }
        }
        Ok(())
    }

    fn run_step(&mut self, step: usize) -> Result<(), BackendError> {
        check_step(&self.schedule, step)?;
        self.step(step);
        Ok(())
    }

    fn read(&mut self, resource: ResourceId) -> Result<Vec<u8>, BackendError> {
        check_range(&self.schedule, resource, 0, 0)?;
        // Not through `current`: reading takes no memory.
        match &self.contents[resource as usize].current {
            Some(bytes) => Ok(bytes.clone()),
            None => first(&self.schedule.resources[resource as usize]),
        }
    }

    fn reset(&mut self) -> Result<(), BackendError> {
        for (content, resource) in self.contents.iter_mut().zip(&self.schedule.resources) {
            if let Kind::State(_) | Kind::History(_) = resource.kind {
                *content = Content::default();
            }
        }
        Ok(())
    }

    fn wait(&mut self) -> Result<(), BackendError> {
        Ok(())
    }

    fn adopt(&mut self, schedule: Arc<Schedule>) -> Result<(), BackendError> {
        self.capabilities.check(NAME, &schedule)?;
        let mut contents = nothing(&schedule);
        for (from, to) in schedule.adoptions(&self.schedule) {
            let old = &self.contents[from as usize];
            let resource = &schedule.resources[to as usize];
            let longer = |bytes: &Option<Vec<u8>>| {
                let grown = bytes.as_ref().map(|bytes| {
                    let mut grown = first(resource)?;
                    grown[..bytes.len()].copy_from_slice(bytes);
                    Ok::<_, BackendError>(grown)
                });
                grown.transpose()
            };
            contents[to as usize] = Content {
                current: longer(&old.current)?,
                previous: longer(&old.previous)?,
            };
        }
        (self.schedule, self.contents) = (schedule, contents);
        Ok(())
    }
}
