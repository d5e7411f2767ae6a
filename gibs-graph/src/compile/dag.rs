//! Stages as a DAG: who depends on whom, who is needed, and in which order they run.
use crate::graph::StageDecl;
use crate::step::HazardKind;
use crate::{Access, Graph, GraphError, Kind};
use petgraph::Direction::Incoming;
use petgraph::graph::{DiGraph, NodeIndex};
use petgraph::visit::EdgeRef;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A node per stage; an edge from a stage to one that has to wait for it, with what meets what.
pub(super) type Dag = DiGraph<(), HazardKind>;

/// Dependencies within the frame. The value of the frame before ([`Access::Previous`]) lies in an allocation that this
/// frame does not write, so reading it makes no edge.
pub(super) fn dependencies(stages: &[StageDecl], resources: usize) -> Dag {
    let mut dag = Dag::with_capacity(stages.len(), stages.len() * 4);
    // Who made and who reads the current version of each resource.
    let mut makers: Vec<Option<NodeIndex>> = vec![None; resources];
    let mut readers: Vec<Vec<NodeIndex>> = vec![Vec::new(); resources];
    for stage in stages {
        let node = dag.add_node(());
        let touched = || {
            let bindings = stage.bindings.iter();
            bindings
                .filter(|b| b.access != Access::Previous)
                .map(|b| (b.resource as usize, b.access))
        };
        for (resource, access) in touched() {
            if let Some(maker) = makers[resource] {
                dag.add_edge(maker, node, HazardKind::after_write(access));
            }
            if access.writes() {
                for &reader in &readers[resource] {
                    dag.add_edge(reader, node, HazardKind::WriteAfterRead);
                }
            }
        }
        for (resource, access) in touched() {
            if access.writes() {
                makers[resource] = Some(node);
                readers[resource].clear();
            } else {
                readers[resource].push(node);
            }
        }
    }
    dag
}

/// Which stages an output needs, per stage.
///
/// A stage may write a part of its resource only, so a version holds what its stage wrote over all earlier versions:
/// needing one means needing the stages of those, too. What a state held before its first version of this frame is what
/// *all* its stages left in the frame before; so a state keeps its stages live once a live stage sees that value, and
/// a state that only its own stages see keeps nothing.
pub(super) fn live_stages(graph: &Graph, dag: &Dag) -> Vec<bool> {
    let mut writers: Vec<Vec<usize>> = vec![Vec::new(); graph.resources.len()];
    for (i, stage) in graph.stages.iter().enumerate() {
        for binding in stage.bindings.iter().filter(|b| b.access.writes()) {
            writers[binding.resource as usize].push(i);
        }
    }
    let mut live = vec![false; graph.stages.len()];
    let mut wanted = Vec::new();
    // Taking the list leaves none, so each resource is entered once.
    for output in &graph.outputs {
        wanted.append(&mut writers[output.resource as usize]);
    }
    while let Some(stage) = wanted.pop() {
        if std::mem::replace(&mut live[stage], true) {
            continue;
        }
        // That a stage overwrites what another one read does not make it need that one.
        let needs = dag.edges_directed(NodeIndex::new(stage), Incoming);
        let needs = needs.filter(|edge| *edge.weight() != HazardKind::WriteAfterRead);
        wanted.extend(needs.map(|edge| edge.source().index()));
        for binding in &graph.stages[stage].bindings {
            // A later version of a state leads to version 0 through the edges above.
            let state = matches!(
                graph.resources[binding.resource as usize].kind,
                Kind::State(_)
            );
            if binding.access == Access::Previous || (state && binding.version == Some(0)) {
                wanted.append(&mut writers[binding.resource as usize]);
            }
        }
    }
    live
}

/// Live stages in an order that keeps every edge; of those that could come next, the first inserted.
pub(super) fn order(
    stages: &[StageDecl],
    dag: &Dag,
    live: &[bool],
    errors: &mut Vec<GraphError>,
) -> Vec<usize> {
    let is_live = |node: &NodeIndex| live[node.index()];
    let mut waiting: Vec<usize> = dag
        .node_indices()
        .map(|node| {
            dag.neighbors_directed(node, Incoming)
                .filter(is_live)
                .count()
        })
        .collect();
    let mut ready: BinaryHeap<Reverse<usize>> = (0..stages.len())
        .filter(|&i| live[i] && waiting[i] == 0)
        .map(Reverse)
        .collect();
    let mut order = Vec::with_capacity(stages.len());
    while let Some(Reverse(i)) = ready.pop() {
        order.push(i);
        for next in dag.neighbors(NodeIndex::new(i)).filter(is_live) {
            let count = &mut waiting[next.index()];
            *count -= 1;
            if *count == 0 {
                ready.push(Reverse(next.index()));
            }
        }
    }
    if let Some(stuck) = (0..stages.len()).find(|&i| live[i] && waiting[i] > 0) {
        errors.push(GraphError::Cycle {
            stage: stages[stuck].label.clone(),
        });
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Access, Graph, KernelSource, WgslSource, Workgroups};

    fn stages(labels: &[&str]) -> Vec<StageDecl> {
        fn nothing(_: &[crate::RawView<'_>], _: Workgroups) {}
        let wgsl = WgslSource {
            name: "none",
            text: "",
            modules: &[],
            features: &[],
        };
        let kernel = KernelSource {
            wgsl,
            cpu: nothing,
            cpu_wide: None,
            workgroup: [1; 3],
        };
        labels
            .iter()
            .map(|label| StageDecl {
                label: (*label).into(),
                stage: "None",
                ports: Vec::new(),
                absent: Vec::new(),
                kernel,
                bindings: Vec::new(),
                dispatch: crate::graph::DispatchDecl::Groups([1; 3]),
                foreign: false,
            })
            .collect()
    }

    #[test]
    fn ties_go_by_insertion_and_edges_go_first() {
        let stages = stages(&["a", "b", "c", "d"]);
        let mut dag = dependencies(&stages, 0);
        // The first inserted waits for the last; the two between are free.
        dag.add_edge(
            NodeIndex::new(3),
            NodeIndex::new(0),
            HazardKind::ReadAfterWrite,
        );
        let mut errors = Vec::new();
        assert_eq!(order(&stages, &dag, &[true; 4], &mut errors), [1, 2, 3, 0]);
        // A dead stage holds nobody up.
        let live = [true, true, true, false];
        assert_eq!(order(&stages, &dag, &live, &mut errors), [0, 1, 2]);
        assert!(errors.is_empty());
    }

    /// Handles cannot make a circle, so it is made by hand.
    #[test]
    fn a_circle_is_an_error_that_names_a_stage_of_it() {
        let stages = stages(&["free", "first", "second"]);
        let mut dag = dependencies(&stages, 0);
        for (from, to) in [(1, 2), (2, 1)] {
            dag.add_edge(
                NodeIndex::new(from),
                NodeIndex::new(to),
                HazardKind::ReadAfterWrite,
            );
        }
        let mut errors = Vec::new();
        assert_eq!(order(&stages, &dag, &[true; 3], &mut errors), [0]);
        let text = errors.iter().map(ToString::to_string).collect::<String>();
        assert_eq!(
            text,
            "stage `first` depends on itself through other stages; give one of them a resource of its own to write"
        );
    }

    /// The two allocations of a history are apart; anything else that is bound as the frame before's is one memory.
    #[test]
    fn the_frame_before_of_no_history_is_an_error_and_aliases() {
        let forged = |declare: fn(&mut Graph)| {
            let mut graph = Graph::new("forged");
            declare(&mut graph);
            let mut stages = stages(&["forger"]);
            for (port, access, version) in [
                ("before", Access::Previous, None),
                ("now", Access::Write, Some(0)),
            ] {
                stages[0].bindings.push(crate::graph::BindingDecl {
                    port,
                    resource: 0,
                    version,
                    access,
                });
            }
            graph.stages = stages;
            graph.compile(None).unwrap_err().to_string()
        };
        let wants = [
            "stage `forger`, port `before` reads what `shared` held in the frame before, but it is no history; declare \
             it with Graph::history, or bind it as read",
            "stage `forger` binds `shared` to `before` and `now`, and writes it",
        ];
        let text = forged(|graph| drop(graph.zeroed::<u32>("shared", 4)));
        assert!(wants.iter().all(|want| text.contains(want)), "{text}");
        let text = forged(|graph| drop(graph.history::<u32>("shared", 4, crate::Initial::Zero)));
        assert!(wants.iter().all(|want| !text.contains(want)), "{text}");
    }

    /// Handles cannot bind one resource twice where a port writes it, so it is done by hand.
    #[test]
    fn aliased_ports_are_an_error_that_names_both() {
        let mut graph = Graph::new("forged");
        let _ = graph.zeroed::<u32>("shared", 4);
        let mut stages = stages(&["forger"]);
        for (port, access) in [("from", Access::Read), ("to", Access::Write)] {
            stages[0].bindings.push(crate::graph::BindingDecl {
                port,
                resource: 0,
                version: Some(0),
                access,
            });
        }
        graph.stages = stages;
        let text = graph.compile(None).unwrap_err().to_string();
        let want = "stage `forger` binds `shared` to `from` and `to`, and writes it; bind it once as read_write";
        assert!(text.contains(want), "{text}");
    }
}
