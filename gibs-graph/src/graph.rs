//! Recording a frame: resources and stages.
use crate::handle::GraphToken;
use crate::{
    Access, Buffer, DispatchArgs, Element, GraphError, Image, ImageShape, KernelSource, Kind,
    Layout, Port, Recorder, Stage, State, Texel,
};
use std::sync::atomic::{AtomicU64, Ordering};

/// A frame as it is recorded: resources, and stages that make versions of them.
#[derive(Debug)]
pub struct Graph {
    pub(crate) name: String,
    pub(crate) token: GraphToken,
    pub(crate) resources: Vec<ResourceDecl>,
    pub(crate) stages: Vec<StageDecl>,
    pub(crate) outputs: Vec<OutputDecl>,
    pub(crate) errors: Vec<GraphError>,
    /// Transients may share memory.
    pub(crate) shares: bool,
}

/// A resource as declared.
#[derive(Clone, Debug)]
pub(crate) struct ResourceDecl {
    pub key: String,
    pub kind: Kind,
    pub element: Layout,
    pub len: u64,
    pub image: Option<ImageShape>,
    /// Of an acceleration structure, the resource with its triangles.
    pub triangles: Option<u32>,
    /// Version that the next frame starts from.
    pub kept: Option<u32>,
}

/// A stage as recorded.
#[derive(Clone, Debug)]
pub(crate) struct StageDecl {
    pub label: String,
    pub stage: &'static str,
    /// Those that are bound.
    pub ports: Vec<Port>,
    /// Optional ports that are not, with their position among all.
    pub absent: Vec<(usize, Port)>,
    pub kernel: KernelSource,
    pub bindings: Vec<BindingDecl>,
    pub dispatch: DispatchDecl,
    /// A handle of another graph was passed, which leaves its port unbound.
    pub foreign: bool,
}

/// One port bound to one version.
#[derive(Clone, Debug)]
pub(crate) struct BindingDecl {
    pub port: &'static str,
    pub resource: u32,
    /// Version that is read, or replaced; `None` for the frame before.
    pub version: Option<u32>,
    pub access: Access,
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum DispatchDecl {
    Groups([u32; 3]),
    Elements(u64),
    Indirect { resource: u32 },
}

#[derive(Clone, Debug)]
pub(crate) struct OutputDecl {
    pub name: String,
    pub resource: u32,
    pub version: u32,
}

/// How many workgroups run.
#[derive(Debug)]
#[non_exhaustive]
pub enum Dispatch<'g> {
    /// A fixed number along each axis.
    Groups([u32; 3]),
    /// As many as this number of invocations needs, folded into two axes where one is too short. Kernels number
    /// invocations in 32 bits, those beyond the count that fill up the last row of workgroups included; compiling the
    /// graph refuses more.
    Elements(u64),
    /// What the device finds in the first element when the stage starts.
    Indirect(&'g Buffer<DispatchArgs>),
}

/// Most workgroups along one axis that WebGPU guarantees.
pub const MAX_GROUPS: u32 = 65_535;

impl StageDecl {
    /// Workgroups along each axis, where the host knows them.
    pub fn groups(&self) -> Option<[u32; 3]> {
        match self.dispatch {
            DispatchDecl::Groups(groups) => Some(groups),
            DispatchDecl::Elements(count) => Some(groups_for(count, self.lanes())),
            DispatchDecl::Indirect { .. } => None,
        }
    }

    /// Invocations per workgroup.
    pub fn lanes(&self) -> u32 {
        let sides = self.kernel.workgroup.iter();
        sides.fold(1, |product: u32, &side| product.saturating_mul(side))
    }
}

impl Graph {
    /// An empty frame.
    pub fn new(name: impl Into<String>) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self {
            name: name.into(),
            token: GraphToken(NEXT.fetch_add(1, Ordering::Relaxed)),
            resources: Vec::new(),
            stages: Vec::new(),
            outputs: Vec::new(),
            errors: Vec::new(),
            shares: true,
        }
    }

    /// Gives every transient memory of its own, so that each still holds its last value after the frame: for checks that
    /// read everything. Otherwise transients share memory where their lifetimes do not meet.
    pub fn keep_transients(&mut self) {
        self.shares = false;
    }

    /// Makes `last` what the next frame starts from.
    pub fn keep<T: Element>(&mut self, state: State<T>, last: Buffer<T>) {
        if state.token != self.token || last.token != self.token {
            self.errors.push(GraphError::ForeignHandle {
                stage: "keep".into(),
                port: "state".into(),
            });
        } else if state.resource != last.resource {
            self.errors.push(GraphError::WrongState {
                state: self.resources[state.resource as usize].key.clone(),
                kept: self.resources[last.resource as usize].key.clone(),
            });
        } else {
            self.resources[state.resource as usize].kept = Some(last.version);
        }
    }

    /// Makes a version readable by the host after each frame, and everything that it needs live. It must be the last
    /// version of its resource in the frame.
    pub fn output<T: Element>(&mut self, name: &str, buffer: &Buffer<T>) {
        if buffer.token != self.token {
            self.errors.push(GraphError::ForeignHandle {
                stage: "output".into(),
                port: name.into(),
            });
            return;
        }
        self.outputs.push(OutputDecl {
            name: name.into(),
            resource: buffer.resource,
            version: buffer.version,
        });
    }

    /// As [`Graph::output`], for an image.
    pub fn output_image<T: Texel>(&mut self, name: &str, image: &Image<T>) {
        if image.token != self.token {
            self.errors.push(GraphError::ForeignHandle {
                stage: "output".into(),
                port: name.into(),
            });
            return;
        }
        self.outputs.push(OutputDecl {
            name: name.into(),
            resource: image.resource,
            version: image.version,
        });
    }

    /// Adds a stage. `label` is its name in the frame, such as `persistent/ray_trace`; what stands before the slash
    /// is its group.
    pub fn add<S: Stage>(
        &mut self,
        label: &str,
        inputs: S::Inputs<'_>,
        dispatch: Dispatch<'_>,
    ) -> S::Outputs {
        let kernel = S::kernel();
        let errors_before = self.errors.len();
        let mut bindings = Vec::new();
        let mut recorder = Recorder {
            token: self.token,
            stage: label,
            bindings: &mut bindings,
            errors: &mut self.errors,
        };
        let dispatch = match dispatch {
            Dispatch::Groups(groups) => DispatchDecl::Groups(groups),
            Dispatch::Elements(count) => DispatchDecl::Elements(count),
            Dispatch::Indirect(args) => {
                recorder.indirect(args);
                DispatchDecl::Indirect {
                    resource: args.resource,
                }
            }
        };
        let outputs = S::bind(&mut recorder, inputs);
        let declared = S::ports().into_iter().enumerate();
        let (absent, ports): (Vec<_>, Vec<_>) = declared
            .partition(|(_, port)| port.optional && bindings.iter().all(|b| b.port != port.name));
        self.stages.push(StageDecl {
            label: label.into(),
            stage: S::NAME,
            ports: ports.into_iter().map(|(_, port)| port).collect(),
            absent,
            kernel,
            bindings,
            dispatch,
            foreign: self.errors.len() > errors_before,
        });
        outputs
    }
}

/// Workgroups for `count` invocations in groups of `lanes`, folded into rows of [`MAX_GROUPS`] where one row is too
/// short. Kernels number groups row by row. Of more than [`MAX_GROUPS`]² groups, the second axis is too long, and
/// compiling the graph reports it.
pub fn groups_for(count: u64, lanes: u32) -> [u32; 3] {
    let groups = count.div_ceil(u64::from(lanes.max(1)));
    if groups <= u64::from(MAX_GROUPS) {
        [groups as u32, 1, 1]
    } else {
        let rows = groups.div_ceil(u64::from(MAX_GROUPS));
        [MAX_GROUPS, u32::try_from(rows).unwrap_or(u32::MAX), 1]
    }
}
