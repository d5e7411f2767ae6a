//! What can be wrong with a graph.
use crate::Layout;
use thiserror::Error;

/// One thing that is wrong with a graph. The stage and the port are those of the frame.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum GraphError {
    /// A handle of one graph was used in another.
    #[error(
        "stage `{stage}`, port `{port}`: the handle belongs to another graph; make it with this graph's methods"
    )]
    ForeignHandle {
        /// Stage.
        stage: String,
        /// Port.
        port: String,
    },
    /// A transient or the new value of a history is read, kept or an output before any stage wrote it.
    #[error(
        "stage `{stage}`, port `{port}` reads `{resource}`, which no stage has written; write it first, or declare it zeroed"
    )]
    Uninitialized {
        /// Stage.
        stage: String,
        /// Port.
        port: String,
        /// Resource.
        resource: String,
    },
    /// A stage writes what only the host may write.
    #[error(
        "stage `{stage}`, port `{port}` writes `{resource}`, which is an input; copy it or declare a state"
    )]
    WritesInput {
        /// Stage.
        stage: String,
        /// Port.
        port: String,
        /// Resource.
        resource: String,
    },
    /// One resource is bound twice and one of the ports writes it.
    #[error(
        "stage `{stage}` binds `{resource}` to `{first}` and `{second}`, and writes it; bind it once as read_write"
    )]
    Aliased {
        /// Stage.
        stage: String,
        /// Resource.
        resource: String,
        /// One port.
        first: String,
        /// Another port.
        second: String,
    },
    /// A state has no version for the next frame.
    #[error("state `{state}` is never kept; pass its last version to `Graph::keep`")]
    NotKept {
        /// State.
        state: String,
    },
    /// A state was kept with a version of something else.
    #[error(
        "state `{state}` was kept with a version of `{kept}`; pass the version that came out of its own stages"
    )]
    WrongState {
        /// State.
        state: String,
        /// Resource that was passed.
        kept: String,
    },
    /// An output or a kept version is overwritten later in the frame.
    #[error(
        "`{resource}` is read by the host or kept at version {version}, but a later stage writes it again; use its last version"
    )]
    NotLast {
        /// Resource.
        resource: String,
        /// Version that was named.
        version: u32,
    },
    /// Two resources share a key.
    #[error("two resources are called `{key}`; give each its own")]
    DuplicateKey {
        /// Key.
        key: String,
    },
    /// Two outputs share a name.
    #[error("two outputs are called `{name}`; give each its own name")]
    DuplicateOutput {
        /// Name.
        name: String,
    },
    /// Two stages share a label.
    #[error("two stages are called `{label}`; give each its own label")]
    DuplicateLabel {
        /// Label.
        label: String,
    },
    /// An initial value does not fit the element.
    #[error(
        "state `{state}`: its initial value has {got} bytes, an element has {want}; make it with Initial::fill from one element"
    )]
    InitialSize {
        /// State.
        state: String,
        /// Bytes given.
        got: usize,
        /// Bytes of an element.
        want: u32,
    },
    /// A stage reads the value of the frame before of something that has none.
    #[error(
        "stage `{stage}`, port `{port}` reads what `{resource}` held in the frame before, but it is no history; declare it with Graph::history, or bind it as read"
    )]
    NoHistory {
        /// Stage.
        stage: String,
        /// Port.
        port: String,
        /// Resource.
        resource: String,
    },
    /// What a stage binds is not what its ports say.
    #[error(
        "stage `{stage}`, port `{port}`: its ports and what it binds differ; declare it with stage!, which makes both from one list"
    )]
    PortMismatch {
        /// Stage.
        stage: String,
        /// Port.
        port: String,
    },
    /// A stage has more invocations than kernels can number.
    #[error(
        "stage `{stage}` asks for {count} invocations; kernels number them in 32 bits, those that fill up the last row of workgroups included; have each do several elements, or split the stage"
    )]
    Invocations {
        /// Stage.
        stage: String,
        /// Invocations.
        count: u64,
    },
    /// A workgroup has no invocations, or more than WebGPU guarantees.
    #[error(
        "stage `{stage}` has workgroups of {size:?} invocations; give it at least 1 along each axis, at most 64 along z and 256 in all"
    )]
    WorkgroupSize {
        /// Stage.
        stage: String,
        /// Invocations along each axis.
        size: [u32; 3],
    },
    /// A fixed dispatch is beyond what WebGPU guarantees, or its workgroups cannot be numbered in 32 bits.
    #[error("stage `{stage}` asks for {groups:?} workgroups; at most {max} along each axis and 2^32 - 1 in all; use Dispatch::Elements, which folds them, or larger workgroups", max = crate::MAX_GROUPS)]
    DispatchSize {
        /// Stage.
        stage: String,
        /// Workgroups.
        groups: [u32; 3],
    },
    /// A uniform element has a size that WGSL does not allow.
    #[error(
        "stage `{stage}`, port `{port}`: `{element}` has {size} bytes; a uniform has a multiple of 16, at most 65536; pad the struct or bind it as read"
    )]
    UniformSize {
        /// Stage.
        stage: String,
        /// Port.
        port: String,
        /// Element type.
        element: Layout,
        /// Its size.
        size: u32,
    },
    /// The device kernel does not match the ports.
    #[error("stage `{stage}`{}: {message}", port.as_ref().map(|p| format!(", port `{p}`")).unwrap_or_default())]
    Shader {
        /// Stage.
        stage: String,
        /// Port, where the problem has one.
        port: Option<String>,
        /// What is wrong, with the position in the WGSL.
        message: String,
    },
    /// The stages depend on each other in a circle.
    #[error(
        "stage `{stage}` depends on itself through other stages; give one of them a resource of its own to write"
    )]
    Cycle {
        /// One stage of the circle.
        stage: String,
    },
}

/// Everything that is wrong with a graph.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("the graph `{graph}` cannot be compiled:{}", errors.iter().map(|e| format!("\n  - {e}")).collect::<String>())]
pub struct GraphErrors {
    /// Name of the graph.
    pub graph: String,
    /// Each problem, in order of discovery.
    pub errors: Vec<GraphError>,
}
