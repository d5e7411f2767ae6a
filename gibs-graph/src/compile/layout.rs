//! What is allocated, and the steps in a row.
use crate::graph::DispatchDecl;
use crate::schedule::{Resource, Usage};
use crate::step::{Action, Binding, DispatchSize, DispatchStep, Step};
use crate::{Access, Graph, Kind};
use std::collections::{HashMap, HashSet};

/// Resources that live stages or outputs touch, and where each of the graph's resources went.
pub(super) fn place_resources(
    graph: &Graph,
    order: &[usize],
) -> (Vec<Resource>, HashMap<u32, u32>) {
    let mut usage: HashMap<u32, Usage> = HashMap::new();
    for binding in order.iter().flat_map(|&i| &graph.stages[i].bindings) {
        let used = usage.entry(binding.resource).or_default();
        match binding.access {
            Access::Uniform => used.uniform = true,
            Access::HostOnly => used.host = true,
            Access::Indirect => used.indirect = true,
            Access::Sampled | Access::Stored => used.image = true,
            Access::Acceleration => used.acceleration = true,
            _ => used.storage = true,
        }
    }
    for (i, declared) in graph.resources.iter().enumerate() {
        let is_traced = usage.get(&(i as u32)).is_some_and(|u| u.acceleration);
        if let Some(triangles) = declared.triangles.filter(|_| is_traced) {
            usage.entry(triangles).or_default().triangles = true;
        }
    }
    for output in &graph.outputs {
        let used = usage.entry(output.resource).or_default();
        match graph.resources[output.resource as usize].image {
            Some(_) => used.image = true,
            None => used.storage = true,
        }
    }
    let mut place = HashMap::new();
    let mut resources = Vec::new();
    for (i, declared) in graph.resources.iter().enumerate() {
        let Some(&usage) = usage.get(&(i as u32)) else {
            continue;
        };
        let home = resources.len() as u32;
        place.insert(i as u32, home);
        let bytes = declared
            .len
            .saturating_mul(u64::from(declared.element.size()));
        resources.push(Resource {
            key: declared.key.clone(),
            kind: declared.kind.clone(),
            element: declared.element.clone(),
            len: declared.len,
            bytes,
            image: declared.image,
            // Declared before the structure, so placed already.
            triangles: declared.triangles.and_then(|t| place.get(&t).copied()),
            home,
            room: bytes,
            usage,
        });
    }
    (resources, place)
}

/// Live stages as steps, and before each the clears of zeroed resources that it is the first to touch.
pub(super) fn lay_out(
    graph: &Graph,
    order: &[usize],
    resources: &[Resource],
    place: &HashMap<u32, u32>,
) -> Vec<Step> {
    let mut steps = Vec::new();
    let mut cleared = HashSet::new();
    for &i in order {
        let stage = &graph.stages[i];
        let bindings: Vec<Binding> = stage
            .bindings
            .iter()
            .filter(|b| b.access != Access::Indirect)
            .map(|b| Binding {
                port: b.port,
                resource: place[&b.resource],
                access: b.access,
            })
            .collect();
        // The sizes of an indirect dispatch are no binding of the step, but they are read.
        for id in stage.bindings.iter().map(|b| place[&b.resource]) {
            let resource = &resources[id as usize];
            if resource.kind == Kind::Zeroed && cleared.insert(id) {
                let action = Action::Clear(id);
                steps.push(Step {
                    label: format!("clear {}", resource.key),
                    action,
                    hazards: Vec::new(),
                });
            }
        }
        let size = match (&stage.dispatch, stage.groups()) {
            (DispatchDecl::Indirect { resource }, _) => DispatchSize::Indirect(place[resource]),
            (_, groups) => DispatchSize::Groups(groups.unwrap_or_default()),
        };
        let dispatch = DispatchStep {
            stage: stage.stage,
            kernel: stage.kernel,
            ports: stage.ports.clone(),
            absent: stage.absent.iter().map(|(slot, _)| *slot).collect(),
            bindings,
            size,
        };
        let action = Action::Dispatch(Box::new(dispatch));
        steps.push(Step {
            label: stage.label.clone(),
            action,
            hazards: Vec::new(),
        });
    }
    steps
}
