//! A captured step as a schedule of its own.
use super::{Capture, CapturedBuffer, CapturedSize};
use crate::check::error::CaptureError;
use crate::{
    Access, Action, Binding, DispatchSize, DispatchStep, Initial, Kind, Output, Resource,
    ResourceId, Schedule, StageInfo, Step, Usage,
};
use std::sync::Arc;

impl Capture {
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
            triangles: buffer.triangles,
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
                acceleration: touches(&|a| a == Access::Acceleration),
                triangles: self.buffers.iter().any(|b| b.triangles == Some(id)),
                host: touches(&|a| a == Access::HostOnly),
            },
        }
    }
}
