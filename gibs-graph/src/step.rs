//! The steps of a compiled frame, and what each waits for.
use crate::{Access, KernelSource, Port, ResourceId, WgslSource};
use serde::Serialize;

/// One step of a frame.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct Step {
    /// Name in the frame, `group/stage`; for a clear, `clear` and the resource's key.
    pub label: String,
    /// What happens.
    pub action: Action,
    /// Earlier work of this frame that must be finished and visible first, as far as no barrier before does that
    /// already; a barrier before a step orders everything before it. Empty: no barrier is needed. [`Schedule::edges`](crate::Schedule::edges)
    /// has every dependency. Whole frames are ordered by the backend: all work of a frame is finished and visible
    /// before the next frame starts.
    pub hazards: Vec<Hazard>,
}

/// What a step does.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub enum Action {
    /// Sets a resource to zero.
    Clear(ResourceId),
    /// Runs a kernel.
    Dispatch(Box<DispatchStep>),
}

/// A kernel, its bindings and its size.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct DispatchStep {
    /// Type name of the stage.
    pub stage: &'static str,
    /// The implementations.
    #[serde(skip)]
    pub kernel: KernelSource,
    /// The ports that are bound, as declared.
    pub ports: Vec<Port>,
    /// One binding per bound port, in the order of the ports.
    pub bindings: Vec<Binding>,
    /// Positions, among all ports that the stage declares, of optional ones that are not bound; ascending.
    pub absent: Vec<usize>,
    /// How many workgroups.
    pub size: DispatchSize,
}

/// A port bound to a resource.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct Binding {
    /// Port name.
    pub port: &'static str,
    /// Resource.
    pub resource: ResourceId,
    /// How it is touched. [`Access::Previous`] means the other allocation of a history.
    pub access: Access,
}

/// Number of workgroups of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub enum DispatchSize {
    /// Known to the host.
    Groups([u32; 3]),
    /// First element of a buffer of [`crate::DispatchArgs`].
    Indirect(ResourceId),
}

/// Why a step has to wait.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct Hazard {
    /// Resource in question.
    pub resource: ResourceId,
    /// Earlier step.
    pub after: u32,
    /// What meets what.
    pub kind: HazardKind,
}

/// Kinds of hazard.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[non_exhaustive]
pub enum HazardKind {
    /// Reads what was written.
    ReadAfterWrite,
    /// Writes what was read.
    WriteAfterRead,
    /// Writes what was written.
    WriteAfterWrite,
}

impl HazardKind {
    /// What touching a resource with `access` after a write is.
    pub(crate) fn after_write(access: Access) -> Self {
        if access.reads() {
            HazardKind::ReadAfterWrite
        } else {
            HazardKind::WriteAfterWrite
        }
    }
}

impl DispatchStep {
    /// What CPU kernels take: a binding per declared port in declaration order, `None` for one that is not bound.
    pub fn slots(&self) -> impl Iterator<Item = Option<&Binding>> {
        let mut bindings = self.bindings.iter();
        let declared = self.bindings.len() + self.absent.len();
        (0..declared).map(move |slot| match self.absent.contains(&slot) {
            true => None,
            false => bindings.next(),
        })
    }

    /// Features that the device kernel is composed with: its own, the names of the optional ports that are bound, and
    /// `RAY_QUERY` with an acceleration structure.
    pub fn features(&self) -> Vec<&'static str> {
        features(&self.kernel.wgsl, &self.ports)
    }
}

/// Features that a device kernel is composed with when `ports` are bound.
pub fn features(wgsl: &WgslSource, ports: &[Port]) -> Vec<&'static str> {
    let optional = ports
        .iter()
        .filter(|port| port.optional)
        .map(|port| port.name);
    let traces = ports.iter().any(|p| p.access == Access::Acceleration);
    let asked = traces.then_some("RAY_QUERY");
    wgsl.features
        .iter()
        .copied()
        .chain(optional)
        .chain(asked)
        .collect()
}

impl Step {
    /// What stands before the slash of the label; nothing for a clear.
    pub fn group(&self) -> &str {
        match &self.action {
            Action::Clear(_) => "",
            Action::Dispatch(_) => self.label.split_once('/').map_or("", |(group, _)| group),
        }
    }

    /// Resources that the step reads and writes, as `(resource, access)`; a clear counts as a write.
    pub fn touches(&self) -> Vec<(ResourceId, Access)> {
        match &self.action {
            Action::Clear(resource) => vec![(*resource, Access::Write)],
            Action::Dispatch(d) => {
                let mut touched: Vec<_> =
                    d.bindings.iter().map(|b| (b.resource, b.access)).collect();
                if let DispatchSize::Indirect(resource) = d.size {
                    touched.push((resource, Access::Indirect));
                }
                touched
            }
        }
    }
}
