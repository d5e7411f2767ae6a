//! Recording a frame: resources and stages.
use crate::handle::GraphToken;
use crate::{
    Access, Buffer, DispatchArgs, Element, GraphError, Image, ImageShape, Initial, KernelSource,
    Kind, Layout, Port, Previous, Sampled, Stage, State, Stored, Texel,
};
use std::marker::PhantomData;
use std::sync::atomic::{AtomicU64, Ordering};

/// A frame as it is recorded: resources, and stages that make versions of them.
#[derive(Debug)]
pub struct Graph {
    pub(crate) name: String,
    token: GraphToken,
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
pub enum Dispatch<'g> {
    /// A fixed number along each axis.
    Groups([u32; 3]),
    /// As many as this number of invocations needs, folded into two axes where one is too short.
    Elements(u64),
    /// What the device finds in the first element when the stage starts.
    Indirect(&'g Buffer<DispatchArgs>),
}

/// Most workgroups along one axis that WebGPU guarantees.
pub const MAX_GROUPS: u32 = 65_535;

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

    /// A buffer that the host writes between frames and stages only read. Its content stays until it is written
    /// again, also across schedules, as long as key, type and length agree.
    pub fn input<T: Element>(&mut self, key: &str, len: u64) -> Buffer<T> {
        self.declare(key, Kind::Input, len)
    }

    /// An image that the host provides and stages only read. Without one from the host, a backend makes its own, which
    /// is written as an input is, one value per texel.
    pub fn import_image<T: Sampled>(&mut self, key: &str, size: [u32; 2]) -> Image<T> {
        self.declare_image(key, Kind::Input, size)
    }

    /// An image that a stage writes for the host, who may provide it; undefined at the start of the frame. Pass its
    /// last version to [`Graph::output_image`].
    pub fn export_image<T: Stored>(&mut self, key: &str, size: [u32; 2]) -> Image<T> {
        self.declare_image(key, Kind::Transient, size)
    }

    /// A buffer that lives within the frame, undefined at its start.
    pub fn transient<T: Element>(&mut self, name: &str, len: u64) -> Buffer<T> {
        self.declare(name, Kind::Transient, len)
    }

    /// A buffer that lives within the frame, zero at its start.
    pub fn zeroed<T: Element>(&mut self, name: &str, len: u64) -> Buffer<T> {
        self.declare(name, Kind::Zeroed, len)
    }

    /// A buffer that outlives the frame and changes in place. [`Graph::keep`] names its last version.
    pub fn state<T: Element>(
        &mut self,
        key: &str,
        len: u64,
        initial: Initial,
    ) -> (State<T>, Buffer<T>) {
        let buffer = self.declare(key, Kind::State(initial), len);
        (
            State {
                token: self.token,
                resource: buffer.resource,
                element: PhantomData,
            },
            buffer,
        )
    }

    /// A buffer that outlives the frame, with the value of the frame before beside the new one. The new one starts
    /// undefined.
    pub fn history<T: Element>(
        &mut self,
        key: &str,
        len: u64,
        initial: Initial,
    ) -> (State<T>, Previous<T>, Buffer<T>) {
        let buffer = self.declare(key, Kind::History(initial), len);
        let state = State {
            token: self.token,
            resource: buffer.resource,
            element: PhantomData,
        };
        let previous = Previous {
            token: self.token,
            resource: buffer.resource,
            len,
            element: PhantomData,
        };
        (state, previous, buffer)
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
        let token = self.token;
        let mut bindings = Vec::new();
        let dispatch = match dispatch {
            Dispatch::Groups(groups) => DispatchDecl::Groups(groups),
            Dispatch::Elements(count) => {
                DispatchDecl::Groups(groups_for(count, kernel.workgroup.iter().product()))
            }
            Dispatch::Indirect(args) => {
                let mut recorder = Recorder {
                    token,
                    stage: label,
                    bindings: &mut bindings,
                    errors: &mut self.errors,
                };
                recorder.read(args, "(indirect)", Access::Indirect);
                DispatchDecl::Indirect {
                    resource: args.resource,
                }
            }
        };
        let mut recorder = Recorder {
            token,
            stage: label,
            bindings: &mut bindings,
            errors: &mut self.errors,
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
        });
        outputs
    }

    fn declare<T: Element>(&mut self, key: &str, kind: Kind, len: u64) -> Buffer<T> {
        const { assert!(size_of::<T>() > 0, "an element of a buffer has bytes") };
        let resource = self.resources.len() as u32;
        self.resources.push(ResourceDecl {
            key: key.into(),
            kind,
            element: T::layout(),
            len: len.max(1),
            image: None,
            kept: None,
        });
        Buffer {
            token: self.token,
            resource,
            version: 0,
            len: len.max(1),
            element: PhantomData,
        }
    }
}

impl Graph {
    fn declare_image<T: Texel>(&mut self, key: &str, kind: Kind, size: [u32; 2]) -> Image<T> {
        let size = size.map(|side| side.max(1));
        let resource = self.resources.len() as u32;
        self.resources.push(ResourceDecl {
            key: key.into(),
            kind,
            element: T::FORMAT.value(),
            len: u64::from(size[0]) * u64::from(size[1]),
            image: Some(ImageShape {
                format: T::FORMAT,
                size,
            }),
            kept: None,
        });
        Image {
            token: self.token,
            resource,
            version: 0,
            size,
            texel: PhantomData,
        }
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

/// Collects the bindings of a stage while it is added.
pub struct Recorder<'r> {
    token: GraphToken,
    stage: &'r str,
    bindings: &'r mut Vec<BindingDecl>,
    errors: &'r mut Vec<GraphError>,
}

impl Recorder<'_> {
    pub(crate) fn bind(
        &mut self,
        token: GraphToken,
        resource: u32,
        version: Option<u32>,
        port: &'static str,
        access: Access,
    ) {
        if token == self.token {
            self.bindings.push(BindingDecl {
                port,
                resource,
                version,
                access,
            });
        } else {
            self.errors.push(GraphError::ForeignHandle {
                stage: self.stage.into(),
                port: port.into(),
            });
        }
    }
}
