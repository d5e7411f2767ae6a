//! What is checked, and on what.
use super::CheckError;
use crate::{Backend, BackendError, Executable, ResourceId, Schedule, check_image, check_range};
use std::sync::Arc;

/// A backend that takes part in a check.
#[derive(Clone, Copy)]
pub struct Participant<'a> {
    /// What reports call it. Begins with [`Backend::name`].
    pub name: &'a str,
    /// The backend.
    pub backend: &'a dyn Backend,
}

impl<'a> Participant<'a> {
    /// A backend under its own name.
    pub fn new(backend: &'a dyn Backend) -> Self {
        Self {
            name: backend.name(),
            backend,
        }
    }

    /// A backend under its own name and more, where one takes part in several ways: `cpu-scalar`.
    pub fn named(name: &'a str, backend: &'a dyn Backend) -> Self {
        Self { name, backend }
    }
}

/// Refuses a check that would compare a backend with itself, or call one by the name of another.
pub(crate) fn distinct(participants: &[Participant<'_>]) -> Result<(), CheckError> {
    if participants.len() < 2 {
        return Err(CheckError::TooFew {
            found: participants.len(),
        });
    }
    for (i, one) in participants.iter().enumerate() {
        if !one.name.starts_with(one.backend.name()) {
            return Err(CheckError::Mislabelled {
                name: one.name.into(),
                backend: one.backend.name().into(),
            });
        }
        for other in &participants[..i] {
            let of =
                |p: &Participant<'_>| (p.backend.name().to_owned(), p.backend.device().clone());
            if other.name == one.name || of(other) == of(one) {
                return Err(CheckError::Same {
                    a: other.name.into(),
                    b: one.name.into(),
                    device: one.backend.device().name.clone(),
                });
            }
        }
    }
    Ok(())
}

/// Bytes that the host writes before a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Upload {
    /// Resource of the schedule.
    pub resource: ResourceId,
    /// First byte.
    pub offset: u64,
    /// What is written.
    pub bytes: Vec<u8>,
}

/// A frame to check, and what the host feeds it with.
pub struct Case<'a> {
    /// Name in reports.
    pub name: String,
    /// The frame. Compile it after [`Graph::keep_transients`](crate::Graph::keep_transients), so that everything that a
    /// step writes can be read.
    pub schedule: Arc<Schedule>,
    /// Frames to compare, ascending, from 0. Those between run on the first participant alone, and the others go on from
    /// what it has.
    pub frames: Vec<u32>,
    feed: Box<Feed<'a>>,
    /// Of the frames so far.
    fed: Vec<Vec<Upload>>,
}

/// What the host writes before frame `n`.
type Feed<'a> = dyn FnMut(u32) -> Result<Vec<Upload>, BackendError> + 'a;

impl<'a> Case<'a> {
    /// A case. `feed` is asked once for each frame, in order; [`UploadLog`] records what code that is written for an
    /// executable uploads.
    pub fn new(
        name: impl Into<String>,
        schedule: Arc<Schedule>,
        frames: impl IntoIterator<Item = u32>,
        feed: impl FnMut(u32) -> Result<Vec<Upload>, BackendError> + 'a,
    ) -> Self {
        Self {
            name: name.into(),
            schedule,
            frames: frames.into_iter().collect(),
            feed: Box::new(feed),
            fed: Vec::new(),
        }
    }

    /// Fails where steps may have lost what they wrote to another that shares its memory.
    pub(crate) fn keeps_transients(&self) -> Result<(), CheckError> {
        let shares = (0..)
            .zip(&self.schedule.resources)
            .find(|(id, r)| r.home != *id);
        match shares {
            None => Ok(()),
            Some((_, resource)) => Err(CheckError::Shared {
                case: self.name.clone(),
                resource: resource.key.clone(),
            }),
        }
    }

    /// What the host writes before a frame.
    pub(crate) fn uploads(&mut self, frame: u32) -> Result<&[Upload], BackendError> {
        while self.fed.len() <= frame as usize {
            let next = (self.feed)(self.fed.len() as u32)?;
            self.fed.push(next);
        }
        Ok(&self.fed[frame as usize])
    }
}

impl std::fmt::Debug for Case<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Case")
            .field("name", &self.name)
            .field("schedule", &self.schedule.name)
            .field("frames", &self.frames)
            .finish_non_exhaustive()
    }
}

/// Takes uploads down in place of an executable. It runs nothing.
#[derive(Debug)]
pub struct UploadLog {
    schedule: Arc<Schedule>,
    uploads: Vec<Upload>,
}

impl UploadLog {
    /// An empty log for a schedule.
    pub fn new(schedule: Arc<Schedule>) -> Self {
        Self {
            schedule,
            uploads: Vec::new(),
        }
    }

    /// What was uploaded since the last call.
    pub fn take(&mut self) -> Vec<Upload> {
        std::mem::take(&mut self.uploads)
    }

    fn refuse<T>(&self, what: &str) -> Result<T, BackendError> {
        Err(BackendError::Refused {
            what: format!("{what} `{}`", self.schedule.name),
            reason: "this only takes down what is uploaded".into(),
            remedy: "prepare the schedule on a backend".into(),
        })
    }
}

impl Executable for UploadLog {
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
        if found.image.is_some() {
            check_image(found, bytes.len())?;
        }
        self.uploads.push(Upload {
            resource,
            offset,
            bytes: bytes.to_vec(),
        });
        Ok(())
    }

    fn run(&mut self) -> Result<(), BackendError> {
        self.refuse("running")
    }

    fn rotate(&mut self) -> Result<(), BackendError> {
        self.refuse("running")
    }

    fn run_step(&mut self, _: usize) -> Result<(), BackendError> {
        self.refuse("running")
    }

    fn read(&mut self, _: ResourceId) -> Result<Vec<u8>, BackendError> {
        self.refuse("reading")
    }

    fn reset(&mut self) -> Result<(), BackendError> {
        self.refuse("resetting")
    }

    fn wait(&mut self) -> Result<(), BackendError> {
        Ok(())
    }

    fn adopt(&mut self, schedule: Arc<Schedule>) -> Result<(), BackendError> {
        self.schedule = schedule;
        Ok(())
    }
}
