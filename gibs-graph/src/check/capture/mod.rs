//! A capture: one stage with its inputs and what backends made of them.
mod file;
mod schedule;

use super::Participant;
use super::isolate::Isolated;
use crate::{Access, Action, DispatchSize, ImageShape, Layout};
use serde::{Deserialize, Serialize};

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
    /// Of an acceleration structure, index of the buffer with its triangles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub triangles: Option<u32>,
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
                    triangles: resource.triangles,
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

    /// Adds what a participant made, in the order of [`Capture::written`]; nothing, where some of it is missing.
    pub fn add_results(&mut self, participant: Participant<'_>, outputs: Vec<Vec<u8>>) {
        let written = self.written();
        let mut made = written.iter().zip(&outputs);
        let whole = made.all(|(&id, bytes)| bytes.len() == self.buffers[id as usize].bytes.len());
        if !whole || written.len() != outputs.len() {
            return;
        }
        let device = participant.backend.device();
        self.results.push(Origin {
            lane: participant.name.into(),
            device: device.name.clone(),
            driver: device.driver.clone(),
            buffers: self.written(),
            outputs,
        });
    }
}
