//! What can be wrong with a recorded frame, apart from its device kernels.
use crate::graph::{DispatchDecl, StageDecl};
use crate::{Access, Graph, GraphError, Initial, Kind, MAX_GROUPS};
use std::collections::HashSet;

/// Adds everything that is wrong with what was recorded to `errors`.
pub(super) fn validate(graph: &Graph, errors: &mut Vec<GraphError>) {
    let mut keys = HashSet::new();
    for resource in &graph.resources {
        if !keys.insert(&resource.key) {
            errors.push(GraphError::DuplicateKey {
                key: resource.key.clone(),
            });
        }
        if let Kind::State(Initial::Fill(bytes)) | Kind::History(Initial::Fill(bytes)) =
            &resource.kind
            && bytes.len() != resource.element.size() as usize
        {
            errors.push(GraphError::InitialSize {
                state: resource.key.clone(),
                got: bytes.len(),
                want: resource.element.size(),
            });
        }
        if matches!(resource.kind, Kind::State(_) | Kind::History(_)) && resource.kept.is_none() {
            errors.push(GraphError::NotKept {
                state: resource.key.clone(),
            });
        }
    }
    let mut labels = HashSet::new();
    let mut last = vec![0; graph.resources.len()];
    for stage in &graph.stages {
        if !labels.insert(&stage.label) {
            errors.push(GraphError::DuplicateLabel {
                label: stage.label.clone(),
            });
        }
        validate_stage(graph, stage, errors);
        for binding in stage.bindings.iter().filter(|b| b.access.writes()) {
            last[binding.resource as usize] = binding.version.map_or(0, |v| v + 1);
        }
    }
    validate_ends(graph, &last, errors);
}

/// What the host reads and what the next frame starts from; `last` is the last version of each resource.
fn validate_ends(graph: &Graph, last: &[u32], errors: &mut Vec<GraphError>) {
    let mut names = HashSet::new();
    for output in &graph.outputs {
        if !names.insert(&output.name) {
            errors.push(GraphError::DuplicateOutput {
                name: output.name.clone(),
            });
        }
        if starts_undefined(graph, output.resource) && output.version == 0 {
            errors.push(GraphError::Uninitialized {
                stage: "output".into(),
                port: output.name.clone(),
                resource: graph.resources[output.resource as usize].key.clone(),
            });
        }
    }
    for (i, resource) in graph.resources.iter().enumerate() {
        if resource.kept == Some(0) && starts_undefined(graph, i as u32) {
            errors.push(GraphError::Uninitialized {
                stage: "keep".into(),
                port: "last".into(),
                resource: resource.key.clone(),
            });
        }
    }
    let named = graph.outputs.iter().map(|o| (o.resource, o.version));
    let kept = graph
        .resources
        .iter()
        .enumerate()
        .filter_map(|(i, r)| Some((i as u32, r.kept?)));
    for (resource, version) in named.chain(kept) {
        if last[resource as usize] != version {
            let key = graph.resources[resource as usize].key.clone();
            errors.push(GraphError::NotLast {
                resource: key,
                version,
            });
        }
    }
}

/// What version 0 holds is no value.
fn starts_undefined(graph: &Graph, resource: u32) -> bool {
    matches!(
        graph.resources[resource as usize].kind,
        Kind::Transient | Kind::History(_)
    )
}

fn validate_stage(graph: &Graph, stage: &StageDecl, errors: &mut Vec<GraphError>) {
    let name = |resource: u32| graph.resources[resource as usize].key.clone();
    validate_size(stage, errors);
    validate_ports(graph, stage, errors);
    for (i, binding) in stage.bindings.iter().enumerate() {
        let resource = &graph.resources[binding.resource as usize];
        let (label, port) = (stage.label.clone(), binding.port.to_string());
        let is_history = matches!(resource.kind, Kind::History(_));
        let reads_now = binding.access.reads() && binding.access != Access::Previous;
        if binding.access == Access::Previous && !is_history {
            errors.push(GraphError::NoHistory {
                stage: label,
                port,
                resource: name(binding.resource),
            });
        } else if reads_now
            && binding.version == Some(0)
            && starts_undefined(graph, binding.resource)
        {
            errors.push(GraphError::Uninitialized {
                stage: label,
                port,
                resource: name(binding.resource),
            });
        } else if binding.access.writes() && resource.kind == Kind::Input {
            errors.push(GraphError::WritesInput {
                stage: label,
                port,
                resource: name(binding.resource),
            });
        } else if binding.access == Access::Uniform {
            let size = resource.element.size();
            if !size.is_multiple_of(16) || size > 65_536 {
                let element = resource.element.clone();
                errors.push(GraphError::UniformSize {
                    stage: label,
                    port,
                    element,
                    size,
                });
            }
        }
        // The two allocations of a history do not overlap, so reading the one beside writing the other is fine.
        let clash = stage.bindings[..i].iter().find(|other| {
            other.resource == binding.resource
                && (other.access.writes() || binding.access.writes())
                && !(is_history
                    && (other.access == Access::Previous || binding.access == Access::Previous))
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

/// What WebGPU guarantees, and what kernels can number.
fn validate_size(stage: &StageDecl, errors: &mut Vec<GraphError>) {
    let label = || stage.label.clone();
    let size = stage.kernel.workgroup;
    if size.contains(&0) || stage.lanes() > 256 || size[2] > 64 {
        errors.push(GraphError::WorkgroupSize {
            stage: label(),
            size,
        });
        return;
    }
    let total = |groups: [u32; 3]| {
        let sides = groups.iter();
        sides.fold(1, |product: u64, &n| product.saturating_mul(u64::from(n)))
    };
    match (&stage.dispatch, stage.groups()) {
        (&DispatchDecl::Elements(count), Some(groups)) => {
            let invocations = total(groups).saturating_mul(u64::from(stage.lanes()));
            if count > u64::from(u32::MAX) || invocations > 1 << 32 {
                errors.push(GraphError::Invocations {
                    stage: label(),
                    count,
                });
            }
        }
        (_, Some(groups))
            if groups.iter().any(|&n| n > MAX_GROUPS) || total(groups) > u64::from(u32::MAX) =>
        {
            errors.push(GraphError::DispatchSize {
                stage: label(),
                groups,
            });
        }
        _ => {}
    }
}

/// A stage that is written by hand could bind what its ports do not say. A handle of another graph leaves its port
/// unbound, which is an error already.
fn validate_ports(graph: &Graph, stage: &StageDecl, errors: &mut Vec<GraphError>) {
    let mut bindings = stage
        .bindings
        .iter()
        .filter(|b| b.access != Access::Indirect)
        .peekable();
    let mut mismatch = |port: &str| {
        errors.push(GraphError::PortMismatch {
            stage: stage.label.clone(),
            port: port.into(),
        });
    };
    for port in &stage.ports {
        let Some(binding) = bindings.next_if(|b| b.port == port.name) else {
            if !stage.foreign {
                mismatch(port.name);
            }
            continue;
        };
        let resource = &graph.resources[binding.resource as usize];
        let agree = binding.access == port.access
            && resource.element == port.element
            && resource.image.map(|image| image.format) == port.image;
        if !agree {
            mismatch(port.name);
        }
    }
    if let Some(binding) = bindings.next() {
        mismatch(binding.port);
    }
}
