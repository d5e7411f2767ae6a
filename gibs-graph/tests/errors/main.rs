//! What a graph that cannot be compiled says. Three errors, of ports that alias, of
//! the frame before of what is no history, and of circles, cannot be reached through
//! handles; they are tested beside the code that finds them.
#[path = "../common/mod.rs"]
mod common;
mod sizes;

use common::*;
use gibs_graph::{
    Access, Buffer, Dispatch, Element, Graph, GraphError, Initial, KernelSource, MAX_GROUPS, Port,
    Recorder, ShaderCompiler, Stage,
};

/// The messages of a graph that does not compile.
fn messages(graph: Graph) -> Vec<String> {
    graph
        .compile(None)
        .unwrap_err()
        .errors
        .iter()
        .map(ToString::to_string)
        .collect()
}

/// A stage `fill` that writes `target`.
fn fill(g: &mut Graph, label: &str, target: Buffer<u32>) -> Buffer<u32> {
    let source = g.input(&format!("source of {label}"), LEN);
    g.add::<pass::Pass>(
        label,
        pass::Inputs {
            source: &source,
            target,
        },
        all(),
    )
    .target
}

#[test]
fn a_handle_of_another_graph() {
    let mut other = Graph::new("other");
    let foreign = other.input("foreign", LEN);
    let foreign_args = other.input("args", 1);
    let (foreign_state, foreign_value) = other.state::<u32>("state", LEN, Initial::Zero);
    let mut g = Graph::new("test");
    let target = g.transient("target", LEN);
    let inputs = pass::Inputs {
        source: &foreign,
        target,
    };
    let made = g.add::<pass::Pass>("draw/copy", inputs, Dispatch::Indirect(&foreign_args));
    g.output("result", &made.target);
    g.output("theirs", &foreign);
    g.keep(foreign_state, foreign_value);
    let remedy = "the handle belongs to another graph; make it with this graph's methods";
    let want = [
        format!("stage `draw/copy`, port `(indirect)`: {remedy}"),
        format!("stage `draw/copy`, port `source`: {remedy}"),
        format!("stage `output`, port `theirs`: {remedy}"),
        format!("stage `keep`, port `state`: {remedy}"),
    ];
    assert_eq!(messages(g), want);
}

#[test]
fn a_read_before_any_write() {
    let remedy = "which no stage has written; write it first, or declare it zeroed";
    let mut g = Graph::new("test");
    let source = g.transient("nothing", LEN);
    let target = g.transient("target", LEN);
    let made = g.add::<pass::Pass>(
        "draw/copy",
        pass::Inputs {
            source: &source,
            target,
        },
        all(),
    );
    g.output("result", &made.target);
    assert_eq!(
        messages(g),
        [format!(
            "stage `draw/copy`, port `source` reads `nothing`, {remedy}"
        )]
    );

    // Changing in place reads, too, and the new value of a history starts undefined.
    let mut g = Graph::new("test");
    let source = g.input("source", LEN);
    let (state, _, now) = g.history("past", LEN, Initial::Zero);
    let made = g.add::<tally::Tally>(
        "count",
        tally::Inputs {
            source: &source,
            target: now,
        },
        all(),
    );
    g.keep(state, made.target);
    assert_eq!(
        messages(g),
        [format!(
            "stage `count`, port `target` reads `past`, {remedy}"
        )]
    );

    // Nor can the host or the next frame start from it.
    let mut g = Graph::new("test");
    let target = g.transient::<u32>("target", LEN);
    g.output("result", &target);
    let (state, _, now) = g.history::<u32>("past", LEN, Initial::Zero);
    g.keep(state, now);
    let want = [
        format!("stage `output`, port `result` reads `target`, {remedy}"),
        format!("stage `keep`, port `last` reads `past`, {remedy}"),
    ];
    assert_eq!(messages(g), want);
}

#[test]
fn what_starts_defined_may_be_read() {
    let mut g = Graph::new("test");
    let source = g.zeroed("zeros", LEN);
    let (state, value) = g.state("state", LEN, Initial::Zero);
    let (past_state, before, now) = g.history("past", LEN, Initial::Zero);
    let now = g
        .add::<recall::Recall>(
            "recall",
            recall::Inputs {
                before: &before,
                target: now,
            },
            all(),
        )
        .target;
    let inputs = merge::Inputs {
        first: &source,
        second: &now,
        target: value,
    };
    let value = g.add::<merge::Merge>("merge", inputs, all()).target;
    g.output("result", &value);
    g.keep(state, value);
    g.keep(past_state, now);
    assert!(g.compile(None).is_ok());
}

#[test]
fn a_stage_that_writes_an_input() {
    let mut g = Graph::new("test");
    let target = g.input("camera", LEN);
    let made = fill(&mut g, "move", target);
    g.output("result", &made);
    let want = "stage `move`, port `target` writes `camera`, which is an input; copy it or declare a state";
    assert_eq!(messages(g), [want]);
}

#[test]
fn a_state_that_is_not_kept() {
    let mut g = Graph::new("test");
    let (_state, value) = g.state::<u32>("surfels", LEN, Initial::Zero);
    g.output("result", &value);
    assert_eq!(
        messages(g),
        ["state `surfels` is never kept; pass its last version to `Graph::keep`"]
    );
}

#[test]
fn a_state_kept_with_something_else() {
    let mut g = Graph::new("test");
    let (first_state, first) = g.state::<u32>("first", LEN, Initial::Zero);
    let (second_state, second) = g.state::<u32>("second", LEN, Initial::Zero);
    g.keep(first_state, second);
    g.keep(second_state, first);
    let messages = messages(g);
    let wants = [
        "state `first` was kept with a version of `second`; pass the version that came out of its own stages",
        "state `second` was kept with a version of `first`; pass the version that came out of its own stages",
    ];
    for want in wants {
        assert!(
            messages.iter().any(|message| message == want),
            "{messages:?}"
        );
    }
}

#[test]
fn an_output_that_is_overwritten() {
    let mut g = Graph::new("test");
    let target = g.transient("image", LEN);
    let first = fill(&mut g, "first", target);
    g.output("result", &first);
    let _second = fill(&mut g, "second", first);
    let want = "`image` is read by the host or kept at version 1, but a later stage writes it again; use its last version";
    assert_eq!(messages(g), [want]);
}

#[test]
fn names_that_are_taken() {
    let mut g = Graph::new("test");
    let first = g.zeroed::<u32>("buffer", LEN);
    let second = g.zeroed::<f32>("buffer", LEN);
    g.output("result", &first);
    g.output("result", &second);
    let target = g.transient("target", LEN);
    let target = fill(&mut g, "draw/fill", target);
    let other = g.transient("other", LEN);
    let inputs = pass::Inputs {
        source: &target,
        target: other,
    };
    let _ = g.add::<pass::Pass>("draw/fill", inputs, all());
    let want = [
        "two resources are called `buffer`; give each its own",
        "two stages are called `draw/fill`; give each its own label",
        "two outputs are called `result`; give each its own name",
    ];
    assert_eq!(messages(g), want);
}

mod sized {
    use gibs_graph::{Dispatch, Graph, GraphErrors, Schedule, Workgroup, stage};

    macro_rules! sizes {
        ($($module:ident $size:expr;)*) => {
            $(mod $module {
                use super::*;

                stage! {
                    /// Has workgroups of an odd size.
                    pub stage Sized {
                        wgsl: super::super::NO_KERNEL,
                        workgroup: $size,
                        ports: { read source: u32, write target: u32 },
                        cpu: kernel,
                        wide: None,
                    }
                }

                fn kernel(_: &Views<'_>, _: Workgroup) {}

                pub fn compile() -> Result<Schedule, GraphErrors> {
                    let mut g = Graph::new("test");
                    let source = g.input("source", 4);
                    let target = g.transient("target", 4);
                    let inputs = Inputs { source: &source, target };
                    let made = g.add::<Sized>("fill", inputs, Dispatch::Elements(4));
                    g.output("result", &made.target);
                    g.compile(None)
                }
            })*

            pub fn all() -> Vec<([u32; 3], Result<Schedule, GraphErrors>)> {
                vec![$(($size, $module::compile()),)*]
            }
        };
    }

    sizes! {
        flat [256, 1, 1];
        solid [2, 2, 64];
        none [64, 0, 1];
        large [257, 1, 1];
        deep [1, 1, 65];
        overflowing [1 << 16, 1 << 16, 1 << 16];
    }
}

/// Written by hand: says that it reads what it writes, and takes a second port that it never binds.
struct Forged;

impl Stage for Forged {
    type Inputs<'g> = Buffer<u32>;
    type Outputs = Buffer<u32>;
    const NAME: &'static str = "Forged";

    fn ports() -> Vec<Port> {
        let port = |name| Port::new(name, Access::Read, u32::layout(), None, false);
        vec![port("target"), port("other")]
    }

    fn kernel() -> KernelSource {
        pass::Pass::kernel()
    }

    fn bind(recorder: &mut Recorder<'_>, target: Buffer<u32>) -> Buffer<u32> {
        recorder.write(target, "target")
    }
}

#[test]
fn a_stage_that_binds_something_else_than_its_ports() {
    let mut g = Graph::new("test");
    let target = g.transient("target", LEN);
    let made = g.add::<Forged>("forged", target, all());
    g.output("result", &made);
    let want = |port: &str| {
        format!(
            "stage `forged`, port `{port}`: its ports and what it binds differ; declare it with stage!, which makes both \
             from one list"
        )
    };
    assert_eq!(messages(g), [want("target"), want("other")]);
}

/// Refuses every kernel, twice.
struct Strict;

impl ShaderCompiler for Strict {
    fn check(
        &self,
        stage: &str,
        kernel: &KernelSource,
        ports: &[Port],
        _: &[Port],
    ) -> Result<(), Vec<GraphError>> {
        let port = Some(ports[0].name.into());
        let message = format!("`{}` has no global for it; declare one", kernel.wgsl.name);
        let whole = GraphError::Shader {
            stage: stage.into(),
            port: None,
            message: "no entry point".into(),
        };
        Err(vec![
            GraphError::Shader {
                stage: stage.into(),
                port,
                message,
            },
            whole,
        ])
    }
}

#[test]
fn a_kernel_that_does_not_match_its_ports() {
    let mut g = Graph::new("test");
    let target = g.transient("target", LEN);
    let made = fill(&mut g, "draw/fill", target);
    g.output("result", &made);
    // Kernels are checked once per type of stage, and only of live stages.
    let again = g.transient("again", LEN);
    let again = fill(&mut g, "draw/again", again);
    g.output("again", &again);
    let target = g.zeroed("dead", LEN);
    let _ = g.add::<tally::Tally>(
        "dead",
        tally::Inputs {
            source: &again,
            target,
        },
        all(),
    );
    let errors = g.compile(Some(&Strict)).unwrap_err();
    let want = "the graph `test` cannot be compiled:\
                \n  - stage `draw/fill`, port `source`: `none` has no global for it; declare one\
                \n  - stage `draw/fill`: no entry point";
    assert_eq!(errors.to_string(), want);
}
