//! A capture: one stage with its inputs and what backends made of them, as a file.
use super::Participant;
use super::error::CaptureError;
use super::isolate::Isolated;
use super::npz::{Reader, Writer};
use crate::{
    Access, Action, Binding, DispatchArgs, DispatchSize, DispatchStep, Element, ImageShape,
    Initial, Kind, Layout, Output, Resource, ResourceId, Schedule, StageInfo, Step, Usage,
};
use serde::{Deserialize, Serialize};
use std::collections::HashSet;
use std::fs::File;
use std::io::{BufReader, BufWriter};
use std::path::Path;
use std::sync::Arc;

/// One dispatch with everything that it reads, before it ran.
///
/// The file is an `.npz` archive: `capture.json` says what is what; `before/KEY.npy` is what a resource held, and
/// `after-LANE/KEY.npy` what a participant made of it. Structs are NumPy's structured types.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Capture {
    /// Version of this format.
    pub(crate) version: u32,
    /// Case that it was taken from.
    pub case: String,
    /// Frame, from 0.
    pub frame: u32,
    /// Name of the step in the frame.
    pub label: String,
    /// Type name of the stage.
    pub stage: String,
    /// How many workgroups.
    pub size: CapturedSize,
    /// What is bound where.
    pub bindings: Vec<CapturedBinding>,
    /// Resources.
    pub buffers: Vec<CapturedBuffer>,
    /// What participants made of it.
    pub results: Vec<Origin>,
}

/// The version that this library writes and reads.
const VERSION: u32 = 1;

/// Longest `capture.json`: far more than the stages of this project need.
const MOST_JSON: u64 = 16 << 20;

/// How many workgroups run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CapturedSize {
    /// So many along each axis.
    Groups([u32; 3]),
    /// As the first element of this buffer says.
    Indirect(u32),
}

/// A port and its buffer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CapturedBinding {
    /// Port.
    pub port: String,
    /// Index of the buffer.
    pub buffer: u32,
    /// How the port touches it.
    pub access: Access,
}

/// A resource.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CapturedBuffer {
    /// Name.
    pub key: String,
    /// Type of an element.
    pub element: Layout,
    /// Number of elements.
    pub len: u64,
    /// Size and texels of an image.
    pub image: Option<ImageShape>,
    /// Content before the step.
    #[serde(skip)]
    pub bytes: Vec<u8>,
}

/// A participant and what it made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Origin {
    /// Name of the participant.
    pub lane: String,
    /// Its device.
    pub device: String,
    /// Driver of the device.
    pub driver: String,
    /// Buffers that it wrote.
    pub buffers: Vec<u32>,
    /// Their content after the step.
    #[serde(skip)]
    pub outputs: Vec<Vec<u8>>,
}

impl Capture {
    /// The isolated step with its contents.
    pub(crate) fn new(case: &str, frame: u32, isolated: &Isolated, contents: &[&[u8]]) -> Self {
        let schedule = &isolated.schedule;
        let step = &schedule.steps[0];
        let (stage, size, bindings) = match &step.action {
            Action::Dispatch(dispatch) => {
                let size = match dispatch.size {
                    DispatchSize::Groups(groups) => CapturedSize::Groups(groups),
                    DispatchSize::Indirect(buffer) => CapturedSize::Indirect(buffer),
                };
                let bindings = dispatch.bindings.iter().map(|binding| CapturedBinding {
                    port: binding.port.into(),
                    buffer: binding.resource,
                    access: binding.access,
                });
                (dispatch.stage, size, bindings.collect())
            }
            Action::Clear(_) => ("", CapturedSize::Groups([0; 3]), Vec::new()),
        };
        let buffers = schedule.resources.iter().zip(contents);
        Self {
            version: VERSION,
            case: case.into(),
            frame,
            label: step.label.clone(),
            stage: stage.into(),
            size,
            bindings,
            buffers: buffers
                .map(|(resource, bytes)| CapturedBuffer {
                    key: resource.key.clone(),
                    element: resource.element.clone(),
                    len: resource.len,
                    image: resource.image,
                    bytes: bytes.to_vec(),
                })
                .collect(),
            results: Vec::new(),
        }
    }

    /// Indices of the buffers that the step writes, in the order of its ports.
    pub fn written(&self) -> Vec<u32> {
        let bindings = self.bindings.iter();
        bindings
            .filter(|binding| binding.access.writes())
            .map(|binding| binding.buffer)
            .collect()
    }

    /// Adds what a participant made, in the order of [`Capture::written`].
    pub(crate) fn add_results(&mut self, participant: Participant<'_>, outputs: Vec<Vec<u8>>) {
        let device = participant.backend.device();
        self.results.push(Origin {
            lane: participant.name.into(),
            device: device.name.clone(),
            driver: device.driver.clone(),
            buffers: self.written(),
            outputs,
        });
    }

    /// Writes it.
    ///
    /// # Errors
    /// [`CaptureError::File`].
    pub fn write(&self, file: &Path) -> Result<(), CaptureError> {
        let failed = |source| CaptureError::File {
            file: file.into(),
            source,
        };
        // Under another name first, so that nobody ever finds half a file.
        let partial = file.with_extension("npz.part");
        let write = || {
            let mut writer = Writer::new(BufWriter::new(File::create(&partial)?));
            writer.file("capture.json", &serde_json::to_vec_pretty(self)?)?;
            for buffer in &self.buffers {
                let name = format!("before/{}", buffer.key);
                writer.array(&name, &buffer.element, &buffer.bytes)?;
            }
            for origin in &self.results {
                for (&buffer, bytes) in origin.buffers.iter().zip(&origin.outputs) {
                    let buffer = &self.buffers[buffer as usize];
                    let name = format!("after-{}/{}", origin.lane, buffer.key);
                    writer.array(&name, &buffer.element, bytes)?;
                }
            }
            let done = writer.finish()?.into_inner();
            done.map_err(std::io::IntoInnerError::into_error)?
                .sync_all()?;
            std::fs::rename(&partial, file)
        };
        let written = write();
        if written.is_err() {
            // What is left of it helps nobody; that it cannot be removed either is not the error to tell.
            let _ = std::fs::remove_file(&partial);
        }
        written.map_err(failed)
    }

    /// Reads one.
    ///
    /// # Errors
    /// [`CaptureError::File`], [`CaptureError::Format`].
    pub fn read(file: &Path) -> Result<Self, CaptureError> {
        let opened = File::open(file).map_err(|source| CaptureError::File {
            file: file.into(),
            source,
        })?;
        Self::from_archive(BufReader::new(opened)).map_err(|problem| CaptureError::Format {
            file: file.into(),
            problem,
        })
    }

    /// Reads one from memory; the error says what is wrong.
    pub(crate) fn from_archive(from: impl std::io::Read + std::io::Seek) -> Result<Self, String> {
        let mut reader = Reader::new(from)?;
        let json = reader.file("capture.json", MOST_JSON)?;
        let mut capture: Self =
            serde_json::from_slice(&json).map_err(|e| format!("`capture.json`: {e}"))?;
        if capture.version != VERSION {
            return Err(format!("its format is {}, not {VERSION}", capture.version));
        }
        capture.check()?;
        for buffer in &mut capture.buffers {
            let name = format!("before/{}", buffer.key);
            buffer.bytes = reader.array(&name, &buffer.element, buffer.len)?;
        }
        let buffers = &capture.buffers;
        for origin in &mut capture.results {
            for &id in &origin.buffers {
                let buffer = &buffers[id as usize];
                let name = format!("after-{}/{}", origin.lane, buffer.key);
                origin
                    .outputs
                    .push(reader.array(&name, &buffer.element, buffer.len)?);
            }
        }
        Ok(capture)
    }

    /// What can be wrong with `capture.json` alone.
    fn check(&self) -> Result<(), String> {
        let count = self.buffers.len();
        let bound = self.bindings.iter().map(|binding| binding.buffer);
        let sized = match self.size {
            CapturedSize::Indirect(buffer) => Some(buffer),
            CapturedSize::Groups(_) => None,
        };
        let made = self
            .results
            .iter()
            .flat_map(|origin| origin.buffers.iter().copied());
        if let Some(id) = bound
            .chain(sized)
            .chain(made)
            .find(|&id| id as usize >= count)
        {
            return Err(format!("it names buffer {id} of {count}"));
        }
        self.check_names()?;
        if let Some(id) = sized
            && self.buffers[id as usize].element != DispatchArgs::layout()
        {
            let key = &self.buffers[id as usize].key;
            return Err(format!("`{key}` cannot say how many workgroups run"));
        }
        for buffer in &self.buffers {
            let texels = buffer.image.map(|image| image.size.map(u64::from));
            if buffer.len == 0
                || buffer.len > 1 << 32
                || plain_size(&buffer.element).is_none()
                || texels.is_some_and(|[w, h]| w.checked_mul(h) != Some(buffer.len))
            {
                return Err(format!("`{}` has an impossible type or length", buffer.key));
            }
        }
        Ok(())
    }

    /// Every buffer and every result is there once, so that the file's size bounds what is read of it; and a buffer that
    /// is written is bound once, since kernels rely on that.
    fn check_names(&self) -> Result<(), String> {
        let ports = self.bindings.iter().map(|binding| binding.port.as_str());
        let keys = self.buffers.iter().map(|buffer| buffer.key.as_str());
        let lanes = self.results.iter().map(|origin| origin.lane.as_str());
        let twice = twice(ports)
            .or_else(|| twice(keys))
            .or_else(|| twice(lanes));
        if let Some(name) = twice {
            return Err(format!("it has `{name}` twice"));
        }
        let written = self.written();
        for &id in &written {
            let bound = self.bindings.iter().filter(|binding| binding.buffer == id);
            if bound.count() > 1 {
                let key = &self.buffers[id as usize].key;
                return Err(format!("it binds `{key}` to two ports, and writes it"));
            }
        }
        match self.results.iter().find(|origin| origin.buffers != written) {
            None => Ok(()),
            Some(origin) => Err(format!(
                "`{}` has other results than the step writes",
                origin.lane
            )),
        }
    }

    /// A schedule of this step alone. `stages` are those that it may be of.
    ///
    /// # Errors
    /// [`CaptureError::UnknownStage`]; [`CaptureError::Changed`] where its ports are no longer those that were captured.
    pub fn schedule(&self, stages: &[StageInfo]) -> Result<Arc<Schedule>, CaptureError> {
        let stage = stages.iter().find(|stage| stage.name == self.stage);
        let stage = stage.ok_or_else(|| CaptureError::UnknownStage {
            stage: self.stage.clone(),
        })?;
        let changed = |problem: String| CaptureError::Changed {
            stage: self.stage.clone(),
            problem,
        };
        let mut ports = Vec::new();
        let mut bindings = Vec::new();
        let mut absent = Vec::new();
        for (i, port) in stage.ports.iter().enumerate() {
            let Some(bound) = self
                .bindings
                .iter()
                .find(|binding| binding.port == port.name)
            else {
                if !port.optional {
                    return Err(changed(format!("it has a port `{}` now", port.name)));
                }
                absent.push(i);
                continue;
            };
            let buffer = &self.buffers[bound.buffer as usize];
            let mut port = port.clone();
            if port.access == Access::Previous {
                port.access = Access::Read;
            }
            if port.access != bound.access
                || port.element != buffer.element
                || port.image != buffer.image.map(|image| image.format)
            {
                return Err(changed(format!(
                    "its port `{}` is another one now",
                    port.name
                )));
            }
            bindings.push(Binding {
                port: port.name,
                resource: bound.buffer,
                access: port.access,
            });
            ports.push(port);
        }
        if let Some(gone) = self
            .bindings
            .iter()
            .find(|bound| ports.iter().all(|p| p.name != bound.port))
        {
            return Err(changed(format!("it has no port `{}` any more", gone.port)));
        }
        let written = self.written();
        if (1..written.len()).any(|i| written[..i].contains(&written[i])) {
            return Err(changed("one buffer is written through two ports".into()));
        }
        let size = match self.size {
            CapturedSize::Groups(groups) => DispatchSize::Groups(groups),
            CapturedSize::Indirect(buffer) => DispatchSize::Indirect(buffer),
        };
        let resources: Vec<Resource> = (0..)
            .zip(&self.buffers)
            .map(|(id, buffer)| self.resource(id, buffer))
            .collect();
        let dispatch = DispatchStep {
            stage: stage.name,
            kernel: stage.kernel,
            ports,
            bindings,
            absent,
            size,
        };
        let outputs = written.iter().map(|&id| Output {
            name: resources[id as usize].key.clone(),
            resource: id,
        });
        Ok(Arc::new(Schedule {
            name: self.label.clone(),
            outputs: outputs.collect(),
            resources,
            steps: vec![Step {
                label: self.label.clone(),
                action: Action::Dispatch(Box::new(dispatch)),
                hazards: Vec::new(),
            }],
            removed: Vec::new(),
            edges: Vec::new(),
        }))
    }

    fn resource(&self, id: ResourceId, buffer: &CapturedBuffer) -> Resource {
        let touches = |fits: &dyn Fn(Access) -> bool| {
            let mut bindings = self.bindings.iter();
            bindings.any(|binding| binding.buffer == id && fits(binding.access))
        };
        let writes = touches(&Access::writes);
        let bytes = buffer.len * u64::from(buffer.element.size());
        Resource {
            key: buffer.key.clone(),
            kind: match (writes, buffer.image) {
                (true, Some(_)) => Kind::Transient,
                (true, None) => Kind::State(Initial::Zero),
                (false, _) => Kind::Input,
            },
            element: buffer.element.clone(),
            len: buffer.len,
            bytes,
            image: buffer.image,
            home: id,
            room: bytes,
            usage: Usage {
                uniform: touches(&|a| a == Access::Uniform),
                storage: touches(&|a| {
                    matches!(
                        a,
                        Access::Read | Access::Write | Access::ReadWrite | Access::Atomic
                    )
                }),
                indirect: self.size == CapturedSize::Indirect(id),
                image: touches(&Access::is_image),
                host: touches(&|a| a == Access::HostOnly),
            },
        }
    }
}

/// A name that comes twice.
fn twice<'a>(mut names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let mut seen = HashSet::new();
    names.find(|name| !seen.insert(*name))
}

/// Bytes of a type whose numbers lie within it and do not overlap, and which has no bytes beside them; `None` of any other.
fn plain_size(element: &Layout) -> Option<u32> {
    match element {
        Layout::Scalar(_) => Some(4),
        Layout::Vector(_, n) => (2..=4).contains(n).then(|| 4 * n),
        Layout::Array {
            element,
            count,
            stride,
        } => {
            let size = plain_size(element).filter(|size| size == stride)?;
            (1..=1 << 16)
                .contains(count)
                .then(|| count.checked_mul(size))?
        }
        Layout::Struct { size, fields, .. } => {
            let end = fields.iter().try_fold(0_u32, |end, field| {
                let size = plain_size(&field.layout).filter(|_| field.offset == end)?;
                end.checked_add(size)
            });
            end.filter(|end| end == size && *size > 0)
        }
    }
}
