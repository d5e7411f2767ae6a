//! One step of a schedule as a schedule of its own.
use crate::{
    Access, Action, Binding, DispatchSize, DispatchStep, Initial, Kind, Output, Resource,
    ResourceId, Schedule, Step,
};
use std::collections::HashMap;
use std::sync::Arc;

/// A step alone, and where its resources come from.
pub(crate) struct Isolated {
    pub schedule: Arc<Schedule>,
    /// For each resource, the one that it was, and whether it was the value of the frame before.
    pub sources: Vec<(ResourceId, bool)>,
}

/// A dispatch alone; its resources hold whatever is uploaded. The value of the frame before is a resource of its own.
pub(crate) fn isolate(schedule: &Schedule, step: usize) -> Option<Isolated> {
    let found = schedule.steps.get(step)?;
    let Action::Dispatch(dispatch) = &found.action else {
        return None;
    };
    let mut sources = Vec::new();
    let mut places = HashMap::new();
    let mut place = |resource: ResourceId, previous: bool| {
        *places.entry((resource, previous)).or_insert_with(|| {
            sources.push((resource, previous));
            (sources.len() - 1) as ResourceId
        })
    };
    let bindings: Vec<Binding> = dispatch
        .bindings
        .iter()
        .map(|binding| Binding {
            port: binding.port,
            resource: place(binding.resource, binding.access == Access::Previous),
            access: settled(binding.access),
        })
        .collect();
    let mut structures = HashMap::new();
    for binding in &dispatch.bindings {
        if let Some(triangles) = schedule.resources[binding.resource as usize].triangles {
            let structure = place(binding.resource, false);
            structures.insert(structure, place(triangles, false));
        }
    }
    let size = match dispatch.size {
        DispatchSize::Indirect(resource) => DispatchSize::Indirect(place(resource, false)),
        size => size,
    };
    let mut ports = dispatch.ports.clone();
    for port in &mut ports {
        port.access = settled(port.access);
    }
    let written: Vec<ResourceId> = bindings
        .iter()
        .filter(|binding| binding.access.writes())
        .map(|binding| binding.resource)
        .collect();
    let resources: Vec<Resource> = (0..)
        .zip(&sources)
        .map(|(id, &(source, previous))| {
            let resource = &schedule.resources[source as usize];
            let key = match previous {
                true => format!("{} before", resource.key),
                false => resource.key.clone(),
            };
            let kind = match written.contains(&id) {
                true => Kind::State(Initial::Zero),
                false => Kind::Input,
            };
            Resource {
                key,
                // An image is no state: it is the host's.
                kind: if resource.image.is_some() {
                    resource.kind.clone()
                } else {
                    kind
                },
                triangles: structures.get(&id).copied(),
                home: id,
                room: resource.bytes,
                ..resource.clone()
            }
        })
        .collect();
    let outputs = written
        .iter()
        .map(|&id| Output {
            name: resources[id as usize].key.clone(),
            resource: id,
        })
        .collect();
    Some(Isolated {
        schedule: Arc::new(Schedule {
            name: found.label.clone(),
            resources,
            steps: vec![Step {
                label: found.label.clone(),
                action: Action::Dispatch(Box::new(DispatchStep {
                    ports,
                    bindings,
                    size,
                    ..dispatch.as_ref().clone()
                })),
                hazards: Vec::new(),
            }],
            outputs,
            removed: Vec::new(),
            edges: Vec::new(),
        }),
        sources,
    })
}

/// The value of the frame before is read like any other.
fn settled(access: Access) -> Access {
    match access {
        Access::Previous => Access::Read,
        access => access,
    }
}
