//! From a recorded graph to a schedule, as one numbered procedure.
use crate::graph::{DispatchDecl, StageDecl};
use crate::schedule::{Action, Binding, DispatchSize, DispatchStep, Hazard, HazardKind, Output, Resource, Step, Usage};
use crate::{Access, Graph, GraphError, GraphErrors, Initial, Kind, MAX_GROUPS, Schedule, ShaderCompiler};
use petgraph::graph::{DiGraph, NodeIndex};
use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap, HashSet};

impl Graph {
    /// Compiles the frame. With `shaders`, every live device kernel is held against its ports first; a program with
    /// the CPU backend alone may leave that out.
    ///
    /// # Errors
    /// Everything that is wrong, at once.
    pub fn compile(mut self, shaders: Option<&dyn ShaderCompiler>) -> Result<Schedule, GraphErrors> {
        // 1. Validate what was recorded.
        let mut errors = std::mem::take(&mut self.errors);
        validate(&self, &mut errors);
        // 2. Make the DAG: a node per stage, an edge per dependency.
        let dag = dependencies(&self.stages);
        // 3. Traverse from the outputs; what is not reached is dead.
        let live = live_stages(&self, &dag);
        // 4. Order: topological, ties by insertion.
        let order = order(&self.stages, &dag, &live, &mut errors);
        // 5. Hold the live device kernels against their ports.
        if let Some(shaders) = shaders {
            check_shaders(&self, &order, shaders, &mut errors);
        }
        if !errors.is_empty() {
            return Err(GraphErrors { graph: self.name, errors });
        }
        // 6. Place resources: the ones that live stages touch.
        let (resources, place) = place_resources(&self, &order);
        // 7. Lay out steps, each clear right before the first use of its resource.
        let mut steps = lay_out(&self, &order, &resources, &place);
        // 8. Find hazards; barriers only where one is.
        let edges = find_hazards(&mut steps, resources.len());
        let outputs = self
            .outputs
            .iter()
            .filter_map(|o| Some(Output { name: o.name.clone(), resource: *place.get(&o.resource)? }))
            .collect();
        let removed = (0..self.stages.len())
            .filter(|i| !live.contains(i))
            .map(|i| self.stages[i].label.clone())
            .collect();
        Ok(Schedule { name: self.name, resources, steps, outputs, removed, edges })
    }
}

fn validate(graph: &Graph, errors: &mut Vec<GraphError>) {
    let mut keys = HashSet::new();
    for resource in &graph.resources {
        if !keys.insert(&resource.key) {
            errors.push(GraphError::DuplicateKey { key: resource.key.clone() });
        }
        if let Kind::State(Initial::Fill(bytes)) | Kind::History(Initial::Fill(bytes)) = &resource.kind
            && bytes.len() != resource.element.size() as usize
        {
            errors.push(GraphError::InitialSize {
                state: resource.key.clone(),
                got: bytes.len(),
                want: resource.element.size(),
            });
        }
        if matches!(resource.kind, Kind::State(_) | Kind::History(_)) && resource.kept.is_none() {
            errors.push(GraphError::NotKept { state: resource.key.clone() });
        }
    }
    let mut labels = HashSet::new();
    let mut last = vec![0; graph.resources.len()];
    for stage in &graph.stages {
        if !labels.insert(&stage.label) {
            errors.push(GraphError::DuplicateLabel { label: stage.label.clone() });
        }
        validate_stage(graph, stage, errors);
        for binding in stage.bindings.iter().filter(|b| b.access.writes()) {
            last[binding.resource as usize] = binding.version.map_or(0, |v| v + 1);
        }
    }
    let named = graph.outputs.iter().map(|o| (o.resource, o.version));
    let kept = graph.resources.iter().enumerate().filter_map(|(i, r)| Some((i as u32, r.kept?)));
    for (resource, version) in named.chain(kept) {
        if last[resource as usize] != version {
            let key = graph.resources[resource as usize].key.clone();
            errors.push(GraphError::NotLast { resource: key, version });
        }
    }
}

fn validate_stage(graph: &Graph, stage: &StageDecl, errors: &mut Vec<GraphError>) {
    let name = |resource: u32| graph.resources[resource as usize].key.clone();
    if let DispatchDecl::Groups(groups) = stage.dispatch
        && groups.iter().any(|&n| n > MAX_GROUPS)
    {
        errors.push(GraphError::DispatchSize { stage: stage.label.clone(), groups });
    }
    for (i, binding) in stage.bindings.iter().enumerate() {
        let resource = &graph.resources[binding.resource as usize];
        let (label, port) = (stage.label.clone(), binding.port.to_string());
        let starts_undefined = matches!(resource.kind, Kind::Transient | Kind::History(_));
        let reads_now = binding.access.reads() && binding.access != Access::Previous;
        if reads_now && starts_undefined && binding.version == Some(0) {
            errors.push(GraphError::Uninitialized { stage: label, port, resource: name(binding.resource) });
        } else if binding.access.writes() && resource.kind == Kind::Input {
            errors.push(GraphError::WritesInput { stage: label, port, resource: name(binding.resource) });
        } else if binding.access == Access::Uniform {
            let size = resource.element.size();
            if !size.is_multiple_of(16) || size > 65_536 {
                let element = resource.element.clone();
                errors.push(GraphError::UniformSize { stage: label, port, element, size });
            }
        }
        // The two allocations of a history do not overlap, so reading the one beside writing the other is fine.
        let clash = stage.bindings[..i].iter().find(|other| {
            other.resource == binding.resource
                && (other.access.writes() || binding.access.writes())
                && other.access != Access::Previous
                && binding.access != Access::Previous
        });
        if let Some(other) = clash {
            errors.push(GraphError::Aliased {
                stage: stage.label.clone(),
                resource: name(binding.resource),
                first: other.port.into(),
                second: binding.port.into(),
            });
        }
    }
}

/// Weight of an edge: the resource and what meets what.
type Dag = DiGraph<(), (u32, HazardKind)>;

fn dependencies(stages: &[StageDecl]) -> Dag {
    let mut dag = Dag::with_capacity(stages.len(), stages.len() * 4);
    for _ in stages {
        dag.add_node(());
    }
    let node = |i: usize| NodeIndex::new(i);
    // Who made and who reads the current version of each resource.
    let mut maker: HashMap<u32, usize> = HashMap::new();
    let mut readers: HashMap<u32, Vec<usize>> = HashMap::new();
    for (i, stage) in stages.iter().enumerate() {
        for binding in stage.bindings.iter().filter(|b| b.access != Access::Previous) {
            let made = maker.get(&binding.resource).copied();
            if binding.access.writes() {
                for &reader in readers.get(&binding.resource).into_iter().flatten() {
                    if reader != i {
                        dag.add_edge(node(reader), node(i), (binding.resource, HazardKind::WriteAfterRead));
                    }
                }
                if let Some(maker) = made.filter(|&m| m != i) {
                    let kind = match binding.access {
                        Access::Write => HazardKind::WriteAfterWrite,
                        _ => HazardKind::ReadAfterWrite,
                    };
                    dag.add_edge(node(maker), node(i), (binding.resource, kind));
                }
            } else {
                readers.entry(binding.resource).or_default().push(i);
                if let Some(maker) = made.filter(|&m| m != i) {
                    dag.add_edge(node(maker), node(i), (binding.resource, HazardKind::ReadAfterWrite));
                }
            }
        }
        for binding in stage.bindings.iter().filter(|b| b.access.writes()) {
            maker.insert(binding.resource, i);
            readers.remove(&binding.resource);
        }
    }
    dag
}

/// Stages that an output needs. A kept state is needed once a live stage reads what the frame before left of it.
fn live_stages(graph: &Graph, dag: &Dag) -> HashSet<usize> {
    let makers_of = |resource: u32| {
        graph.stages.iter().enumerate().filter(move |(_, stage)| {
            stage.bindings.iter().any(|b| b.resource == resource && b.access.writes())
        })
    };
    let mut live = HashSet::new();
    let mut wanted: Vec<usize> = Vec::new();
    let mut wanted_resources = HashSet::new();
    let mut pending: Vec<u32> = graph.outputs.iter().map(|o| o.resource).collect();
    loop {
        while let Some(resource) = pending.pop() {
            if wanted_resources.insert(resource) {
                wanted.extend(makers_of(resource).map(|(i, _)| i));
            }
        }
        let Some(stage) = wanted.pop() else { break };
        if !live.insert(stage) {
            continue;
        }
        for edge in dag.edges_directed(NodeIndex::new(stage), petgraph::Direction::Incoming) {
            use petgraph::visit::EdgeRef;
            // Only data makes a stage live: what is merely overwritten is not needed. A partial write does keep the
            // earlier writer of the same resource.
            if edge.weight().1 != HazardKind::WriteAfterRead {
                wanted.push(edge.source().index());
            }
        }
        for binding in &graph.stages[stage].bindings {
            let kind = &graph.resources[binding.resource as usize].kind;
            let across = binding.access == Access::Previous
                || (matches!(kind, Kind::State(_)) && (binding.version == Some(0) || binding.access.writes()));
            if across {
                pending.push(binding.resource);
            }
        }
    }
    live
}

fn order(stages: &[StageDecl], dag: &Dag, live: &HashSet<usize>, errors: &mut Vec<GraphError>) -> Vec<usize> {
    let incoming = |i: usize| {
        dag.neighbors_directed(NodeIndex::new(i), petgraph::Direction::Incoming)
            .filter(|n| live.contains(&n.index()))
            .count()
    };
    let mut waiting: HashMap<usize, usize> = live.iter().map(|&i| (i, incoming(i))).collect();
    let mut ready: BinaryHeap<Reverse<usize>> =
        waiting.iter().filter(|(_, n)| **n == 0).map(|(&i, _)| Reverse(i)).collect();
    let mut order = Vec::with_capacity(live.len());
    while let Some(Reverse(i)) = ready.pop() {
        order.push(i);
        for next in dag.neighbors(NodeIndex::new(i)) {
            if let Some(count) = waiting.get_mut(&next.index()) {
                *count -= 1;
                if *count == 0 {
                    ready.push(Reverse(next.index()));
                }
            }
        }
    }
    if order.len() != live.len()
        && let Some(stuck) = live.iter().filter(|i| !order.contains(i)).min()
    {
        errors.push(GraphError::Cycle { stage: stages[*stuck].label.clone() });
    }
    order
}

fn check_shaders(graph: &Graph, order: &[usize], shaders: &dyn ShaderCompiler, errors: &mut Vec<GraphError>) {
    let mut seen = HashSet::new();
    for &i in order {
        let stage = &graph.stages[i];
        if seen.insert((stage.kernel.wgsl.name, stage.stage))
            && let Err(found) = shaders.check(&stage.label, &stage.kernel, &stage.ports)
        {
            errors.extend(found);
        }
    }
}

fn place_resources(graph: &Graph, order: &[usize]) -> (Vec<Resource>, HashMap<u32, u32>) {
    let mut usage: HashMap<u32, Usage> = HashMap::new();
    for binding in order.iter().flat_map(|&i| &graph.stages[i].bindings) {
        let used = usage.entry(binding.resource).or_default();
        match binding.access {
            Access::Uniform => used.uniform = true,
            Access::HostOnly => used.host = true,
            Access::Indirect => used.indirect = true,
            _ => used.storage = true,
        }
    }
    for output in &graph.outputs {
        usage.entry(output.resource).or_default().storage = true;
    }
    let mut place = HashMap::new();
    let mut resources = Vec::new();
    for (i, declared) in graph.resources.iter().enumerate() {
        let Some(&usage) = usage.get(&(i as u32)) else { continue };
        place.insert(i as u32, resources.len() as u32);
        resources.push(Resource {
            key: declared.key.clone(),
            kind: declared.kind.clone(),
            element: declared.element.clone(),
            len: declared.len,
            bytes: declared.len * u64::from(declared.element.size()),
            usage,
        });
    }
    (resources, place)
}

fn lay_out(graph: &Graph, order: &[usize], resources: &[Resource], place: &HashMap<u32, u32>) -> Vec<Step> {
    let mut steps = Vec::new();
    let mut cleared = HashSet::new();
    for &i in order {
        let stage = &graph.stages[i];
        let bindings: Vec<Binding> = stage
            .bindings
            .iter()
            .filter(|b| b.access != Access::Indirect)
            .map(|b| Binding { port: b.port, resource: place[&b.resource], access: b.access })
            .collect();
        for binding in &bindings {
            let resource = &resources[binding.resource as usize];
            if resource.kind == Kind::Zeroed && cleared.insert(binding.resource) {
                let action = Action::Clear(binding.resource);
                steps.push(Step { label: format!("clear {}", resource.key), action, hazards: Vec::new() });
            }
        }
        let size = match stage.dispatch {
            DispatchDecl::Groups(groups) => DispatchSize::Groups(groups),
            DispatchDecl::Indirect { resource } => DispatchSize::Indirect(place[&resource]),
        };
        let dispatch =
            DispatchStep { stage: stage.stage, kernel: stage.kernel, ports: stage.ports.clone(), bindings, size };
        let action = Action::Dispatch(Box::new(dispatch));
        steps.push(Step { label: stage.label.clone(), action, hazards: Vec::new() });
    }
    steps
}

/// Fills in every step's hazards and returns all dependencies. A barrier before a step orders everything before it,
/// so a hazard counts only against steps since the last barrier.
fn find_hazards(steps: &mut [Step], resources: usize) -> Vec<(u32, u32, u32)> {
    let mut writer: Vec<Option<u32>> = vec![None; resources];
    let mut readers: Vec<Vec<u32>> = vec![Vec::new(); resources];
    let mut fence = 0;
    let mut edges = Vec::new();
    for i in 0..steps.len() as u32 {
        let touches = steps[i as usize].touches();
        let mut hazards = Vec::new();
        for &(resource, access) in touches.iter().filter(|(_, a)| !matches!(a, Access::Previous)) {
            let r = resource as usize;
            let write_kind = if access.reads() { HazardKind::ReadAfterWrite } else { HazardKind::WriteAfterWrite };
            let after_write = writer[r].map(|w| (w, write_kind));
            let after_reads = readers[r].iter().filter(|_| access.writes()).map(|&s| (s, HazardKind::WriteAfterRead));
            for (after, kind) in after_write.into_iter().chain(after_reads).filter(|(after, _)| *after != i) {
                edges.push((after, i, resource));
                if after >= fence {
                    hazards.push(Hazard { resource, after, kind });
                }
            }
        }
        if !hazards.is_empty() {
            fence = i;
        }
        for &(resource, access) in &touches {
            if access.writes() {
                writer[resource as usize] = Some(i);
                readers[resource as usize].clear();
            } else if access != Access::Previous {
                readers[resource as usize].push(i);
            }
        }
        steps[i as usize].hazards = hazards;
    }
    edges
}
