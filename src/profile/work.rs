//! What each step does in a frame.
use super::Work;
use crate::{RenderError, Renderer};
use gibs_graph::bytemuck::pod_read_unaligned;
use gibs_graph::{
    Access, Action, BackendError, DispatchArgs, DispatchSize, DispatchStep, Element, Executable,
    ResourceId, Schedule,
};
use gibs_passes::stages::traces_rays;
use std::sync::Arc;

/// Runs the next frame step by step and counts what each step does. Counts on the device are read right before the
/// step that works by them, while they are still there.
pub(super) fn work(renderer: &mut Renderer) -> Result<Vec<Work>, RenderError> {
    renderer.begin()?;
    let exec = renderer.executable();
    let schedule = Arc::clone(exec.schedule());
    let first = first_writes(&schedule);
    exec.rotate()?;
    let mut all = Vec::with_capacity(schedule.steps.len());
    for (index, step) in schedule.steps.iter().enumerate() {
        let mut work = match &step.action {
            Action::Dispatch(dispatch) => of_dispatch(exec, &schedule, dispatch)?,
            _ => Work::default(),
        };
        for (resource, access) in step.touches() {
            let bytes = schedule.resources[resource as usize].bytes;
            if access.writes() {
                work.bytes_written += bytes;
            }
            if access.reads() {
                work.bytes_read += bytes;
            }
        }
        let made = (0..).zip(&first).filter(|(_, step)| **step == Some(index));
        work.bytes_held = made
            .map(|(resource, _): (usize, _)| &schedule.resources[resource])
            .map(|resource| resource.bytes * resource.kind.allocations())
            .sum();
        all.push(work);
        exec.run_step(index)?;
    }
    exec.wait()?;
    Ok(all)
}

fn of_dispatch(
    exec: &mut (dyn Executable + 'static),
    schedule: &Schedule,
    dispatch: &DispatchStep,
) -> Result<Work, RenderError> {
    let groups = match dispatch.size {
        DispatchSize::Groups(groups) => groups,
        DispatchSize::Indirect(resource) => {
            let args = args(exec, resource)?;
            [args.x, args.y, args.z]
        }
        _ => [0; 3],
    };
    let product = |sides: [u32; 3]| sides.iter().map(|&side| u64::from(side)).product::<u64>();
    // What a stage works on is its first batch: those that make batches write theirs.
    let batch = dispatch.bindings.iter().find(|binding| {
        let is_batch =
            schedule.resources[binding.resource as usize].element == DispatchArgs::layout();
        is_batch && binding.access == Access::Uniform
    });
    let items = match batch {
        Some(batch) => Some(u64::from(args(exec, batch.resource)?.count)),
        None => None,
    };
    Ok(Work {
        invocations: product(groups) * product(dispatch.kernel.workgroup),
        items,
        rays: match traces_rays(dispatch.stage) {
            true => items.unwrap_or_default(),
            false => 0,
        },
        ..Work::default()
    })
}

fn args(
    exec: &mut (dyn Executable + 'static),
    resource: ResourceId,
) -> Result<DispatchArgs, BackendError> {
    let bytes = exec.read(resource)?;
    let first = bytes.get(..size_of::<DispatchArgs>());
    Ok(first.map(pod_read_unaligned).unwrap_or_default())
}

/// The first step that writes each resource.
fn first_writes(schedule: &Schedule) -> Vec<Option<usize>> {
    let mut first = vec![None; schedule.resources.len()];
    for (index, step) in schedule.steps.iter().enumerate() {
        let writes = step
            .touches()
            .into_iter()
            .filter(|(_, access)| access.writes());
        for (resource, _) in writes {
            first[resource as usize].get_or_insert(index);
        }
    }
    first
}
