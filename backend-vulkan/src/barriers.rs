//! Which memory a barrier has to make visible to whom.
use ash::vk;
use gibs_graph::{Access, Action, ResourceId, Schedule};

/// Everything that the backend's commands do, as pipeline stages.
const ALL_STAGES: vk::PipelineStageFlags = vk::PipelineStageFlags::from_raw(
    vk::PipelineStageFlags::COMPUTE_SHADER.as_raw()
        | vk::PipelineStageFlags::TRANSFER.as_raw()
        | vk::PipelineStageFlags::DRAW_INDIRECT.as_raw(),
);
const WRITES: vk::AccessFlags = vk::AccessFlags::from_raw(
    vk::AccessFlags::SHADER_WRITE.as_raw() | vk::AccessFlags::TRANSFER_WRITE.as_raw(),
);
const READS: vk::AccessFlags = vk::AccessFlags::from_raw(
    vk::AccessFlags::SHADER_READ.as_raw()
        | vk::AccessFlags::UNIFORM_READ.as_raw()
        | vk::AccessFlags::INDIRECT_COMMAND_READ.as_raw()
        | vk::AccessFlags::TRANSFER_READ.as_raw(),
);

/// A barrier over all memory. Work before it finishes before work after it starts; beyond that, what `from` wrote
/// becomes visible to `to`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Barrier {
    pub from: vk::AccessFlags,
    pub to: vk::AccessFlags,
}

impl Barrier {
    /// Between anything and anything that the backend records.
    pub const FULL: Self = Self {
        from: WRITES,
        to: vk::AccessFlags::from_raw(WRITES.as_raw() | READS.as_raw()),
    };

    /// Records it.
    ///
    /// # Safety
    /// `commands` is a command buffer of `device` that is being recorded.
    pub unsafe fn record(self, device: &ash::Device, commands: vk::CommandBuffer) {
        let memory = [vk::MemoryBarrier::default()
            .src_access_mask(self.from)
            .dst_access_mask(self.to)];
        // A write after a read needs an order, but nothing made visible.
        let memory = if self.from.is_empty() {
            &memory[..0]
        } else {
            &memory[..]
        };
        // SAFETY: the caller's promise; the accesses are ones that these stages make.
        unsafe {
            let flags = vk::DependencyFlags::empty();
            device.cmd_pipeline_barrier(commands, ALL_STAGES, ALL_STAGES, flags, memory, &[], &[]);
        }
    }
}

/// Records that work starts behind everything that the queue did before, also on behalf of a host.
///
/// # Safety
/// `commands` is a command buffer of `device` that is being recorded.
pub(crate) unsafe fn open(device: &ash::Device, commands: vk::CommandBuffer) {
    let memory = [vk::MemoryBarrier::default()
        .src_access_mask(vk::AccessFlags::MEMORY_WRITE)
        .dst_access_mask(Barrier::FULL.to)];
    let (from, flags) = (
        vk::PipelineStageFlags::ALL_COMMANDS,
        vk::DependencyFlags::empty(),
    );
    // SAFETY: the caller's promise; the accesses are ones that these stages make.
    unsafe { device.cmd_pipeline_barrier(commands, from, ALL_STAGES, flags, &memory, &[], &[]) };
}

/// Records that what a frame wrote is visible to what a host does next.
///
/// # Safety
/// `commands` is a command buffer of `device` that is being recorded; its queue has the stages, which make the
/// accesses.
pub(crate) unsafe fn close(
    device: &ash::Device,
    commands: vk::CommandBuffer,
    stage: vk::PipelineStageFlags,
    access: vk::AccessFlags,
) {
    let memory = [vk::MemoryBarrier::default()
        .src_access_mask(WRITES)
        .dst_access_mask(access)];
    let flags = vk::DependencyFlags::empty();
    // SAFETY: the caller's promise.
    unsafe { device.cmd_pipeline_barrier(commands, ALL_STAGES, stage, flags, &memory, &[], &[]) };
}

/// The barrier before each step of a schedule, where it needs one.
///
/// The schedule lists a hazard only against steps since the last barrier, taking for granted that a barrier settles
/// everything before it. So each dependency, whether listed or not, is entered into the first barrier after its earlier
/// step.
pub(crate) fn plan(schedule: &Schedule) -> Vec<Option<Barrier>> {
    let needed = |hazards: &[_]| (!hazards.is_empty()).then(Barrier::default);
    let mut plan: Vec<_> = schedule
        .steps
        .iter()
        .map(|step| needed(&step.hazards))
        .collect();
    for &(earlier, later, resource) in &schedule.edges {
        let between = plan
            .get_mut(earlier as usize + 1..=later as usize)
            .unwrap_or_default();
        let Some(barrier) = between.iter_mut().flatten().next() else {
            continue;
        };
        let written = accesses(schedule, earlier, resource) & WRITES;
        if !written.is_empty() {
            barrier.from |= written;
            barrier.to |= accesses(schedule, later, resource);
        }
    }
    plan
}

/// How a step touches the memory of a resource, whichever of those that share it the step names.
fn accesses(schedule: &Schedule, step: u32, resource: ResourceId) -> vk::AccessFlags {
    let home = |resource: ResourceId| schedule.resources[resource as usize].home;
    let step = &schedule.steps[step as usize];
    if matches!(step.action, Action::Clear(_)) {
        return vk::AccessFlags::TRANSFER_WRITE;
    }
    step.touches()
        .into_iter()
        .filter(|(touched, _)| home(*touched) == home(resource))
        .fold(vk::AccessFlags::empty(), |flags, (_, access)| {
            flags | flags_of(access)
        })
}

fn flags_of(access: Access) -> vk::AccessFlags {
    match access {
        Access::Uniform => vk::AccessFlags::UNIFORM_READ,
        Access::Read | Access::Previous | Access::Sampled => vk::AccessFlags::SHADER_READ,
        Access::Write | Access::Stored => vk::AccessFlags::SHADER_WRITE,
        Access::ReadWrite | Access::Atomic => {
            vk::AccessFlags::SHADER_READ | vk::AccessFlags::SHADER_WRITE
        }
        Access::Indirect => vk::AccessFlags::INDIRECT_COMMAND_READ,
        _ => vk::AccessFlags::empty(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gibs_graph::{Dispatch, Graph, WgslSource, Workgroup, stage};

    stage! {
        /// Two numbers from one.
        pub stage Fork {
            wgsl: WgslSource { name: "fork", text: "", modules: &[], features: &[] },
            workgroup: [64, 1, 1],
            ports: { read source: u32, write left: u32, write right: u32 },
            cpu: kernel,
            wide: None,
        }
    }

    fn kernel(_: &Views<'_>, _: Workgroup) {}

    /// What nobody reads is written over through another resource: the write before must not come after that.
    #[test]
    fn writes_to_shared_memory_are_ordered() {
        let mut g = Graph::new("shared");
        let source = g.input("source", 64);
        let fork = |g: &mut Graph, source: &_, names: [&str; 2]| {
            let [left, right] = names.map(|name| g.transient(name, 64));
            let inputs = Inputs {
                source,
                left,
                right,
            };
            g.add::<Fork>(names[0], inputs, Dispatch::Elements(64))
        };
        let first = fork(&mut g, &source, ["first", "unread"]);
        let second = fork(&mut g, &first.left, ["second", "beside"]);
        g.output("second", &second.left);
        let schedule = g.compile(None).unwrap();
        let home = |key| schedule.resources[schedule.resource(key).unwrap() as usize].home;
        assert_eq!(home("beside"), home("unread"));
        let barrier = Barrier {
            from: vk::AccessFlags::SHADER_WRITE,
            to: vk::AccessFlags::SHADER_READ | vk::AccessFlags::SHADER_WRITE,
        };
        assert_eq!(plan(&schedule), [None, Some(barrier)]);
    }
}
