//! A backend of one's own, from what `gibs-graph` has: the CPU kernels, one workgroup after the other on one thread.
//!
//! ```sh
//! cargo run --release --example custom_backend
//! ```
//!
//! It counts how often each resource is read and written, refuses a step that reads a transient which nothing has
//! written in this frame, and fills transients with garbage before each frame, so that nothing can live on what a frame
//! before left. Goes through the cross-check kit, and exits with 1 unless every stage gives the bits of `CpuBackend`.
//! `docs/extending.md` has the list of what a backend promises; the comments here name its points.
use gibs::check::{CheckOptions, Participant, Plan, Verdict, cases, check};
use gibs::graph::bytemuck::{self, Pod, Zeroable};
use gibs::graph::{
    Access, Action, Backend, BackendError, Capabilities, DeviceInfo, DispatchArgs, DispatchSize,
    DispatchStep, Executable, Kind, MAX_GROUPS, RawView, Resource, ResourceId, Schedule,
    Workgroups, check_image, check_range, check_step, unknown_step,
};
use gibs::passes::frame::Settings;
use gibs::{Renderer, builtin};
use gibs_backend_cpu::CpuBackend;
use std::any::Any;
use std::error::Error;
use std::process::ExitCode;
use std::sync::Arc;

const NAME: &str = "counting";

/// A cache line: what views want their memory aligned to.
#[derive(Clone, Copy, Pod, Zeroable)]
#[bytemuck(crate = "gibs::graph::bytemuck")]
#[repr(C, align(64))]
struct Line([u8; 64]);

/// Memory of one resource. Each has its own: sharing, which `Resource::home` offers, saves memory and is no duty.
struct Slot {
    /// The current allocation; of a history, behind it that of the frame before.
    memory: Vec<Vec<Line>>,
    /// Holds a value in this frame.
    written: bool,
    reads: u64,
    writes: u64,
}

fn slots(schedule: &Schedule) -> Result<Vec<Slot>, BackendError> {
    let slot = |resource: &Resource| {
        let allocations = 0..resource.kind.allocations();
        let memory: Result<_, _> = allocations.map(|_| filled(resource)).collect();
        Ok(Slot {
            memory: memory?,
            written: resource.kind.persists(),
            reads: 0,
            writes: 0,
        })
    };
    schedule.resources.iter().map(slot).collect()
}

/// What a resource holds before the first frame and after a reset.
fn filled(resource: &Resource) -> Result<Vec<Line>, BackendError> {
    let oom = || BackendError::OutOfMemory {
        device: NAME.into(),
        resource: resource.key.clone(),
        bytes: resource.bytes,
    };
    let bytes = usize::try_from(resource.bytes).map_err(|_| oom())?;
    let mut lines = Vec::new();
    let count = bytes.div_ceil(64);
    lines.try_reserve_exact(count).map_err(|_| oom())?;
    lines.resize(count, Line::zeroed());
    if let Kind::State(initial) | Kind::History(initial) = &resource.kind {
        bytes_of(&mut lines, resource).copy_from_slice(&initial.bytes(bytes));
    }
    Ok(lines)
}

fn bytes_of<'a>(lines: &'a mut [Line], resource: &Resource) -> &'a mut [u8] {
    &mut bytemuck::cast_slice_mut(lines)[..resource.bytes as usize]
}

struct Counting(CpuBackend); // which knows the machine

impl Backend for Counting {
    fn name(&self) -> &str {
        NAME
    }

    fn device(&self) -> &DeviceInfo {
        self.0.device()
    }

    fn capabilities(&self) -> &Capabilities {
        self.0.capabilities()
    }

    fn prepare(&self, schedule: Arc<Schedule>) -> Result<Box<dyn Executable>, BackendError> {
        self.capabilities().check(NAME, &schedule)?;
        Ok(Box::new(Run {
            slots: slots(&schedule)?,
            schedule,
            allowed: self.capabilities().clone(),
        }))
    }
}

struct Run {
    schedule: Arc<Schedule>,
    slots: Vec<Slot>,
    allowed: Capabilities,
}

impl Run {
    fn step(&mut self, index: usize) -> Result<(), BackendError> {
        let schedule = Arc::clone(&self.schedule);
        let step = &schedule.steps[index];
        for (id, access) in step.touches() {
            let slot = &mut self.slots[id as usize];
            if access.reads() && access != Access::Previous && !slot.written {
                let key = &schedule.resources[id as usize].key;
                let message = format!("reads `{key}`, which nothing has written in this frame");
                return Err(kernel_error(&step.label, message));
            }
            slot.reads += u64::from(access.reads());
            slot.writes += u64::from(access.writes());
            slot.written |= access.writes();
        }
        match &step.action {
            Action::Clear(id) => {
                self.slots[*id as usize].memory[0].fill(Line::zeroed());
                Ok(())
            }
            Action::Dispatch(dispatch) => self.dispatch(&step.label, dispatch),
            _ => Err(unknown_step(&step.label)),
        }
    }

    fn dispatch(&mut self, label: &str, dispatch: &DispatchStep) -> Result<(), BackendError> {
        let count = match dispatch.size {
            DispatchSize::Groups(groups) => groups,
            DispatchSize::Indirect(id) => {
                let bytes: &[u8] = bytemuck::cast_slice(&self.slots[id as usize].memory[0]);
                let args: DispatchArgs =
                    bytemuck::pod_read_unaligned(&bytes[..size_of::<DispatchArgs>()]);
                [args.x, args.y, args.z]
            }
            _ => return Err(unknown_step(label)),
        };
        let [x, y, z] = count.map(u64::from);
        // Sizes that a kernel made are input like any other: refused, not believed.
        if count.iter().any(|&n| n > MAX_GROUPS) || x * y * z > u32::MAX.into() {
            return Err(kernel_error(label, format!("{count:?} workgroups")));
        }
        let mut views = Vec::new();
        for binding in dispatch.slots() {
            let Some(binding) = binding else {
                views.push(RawView::absent());
                continue;
            };
            let resource = &self.schedule.resources[binding.resource as usize];
            let slot = &mut self.slots[binding.resource as usize];
            let lines = &mut slot.memory[usize::from(binding.access == Access::Previous)];
            let (start, bytes) = (lines.as_mut_ptr().cast(), resource.bytes as usize);
            // SAFETY: the memory is initialized, aligned to a `Line`, long enough and writable. It lives in `self.slots`,
            // which nothing moves or touches until the last use of `views` below. Two bindings are of one allocation only
            // where neither writes it: compiling refuses the rest, and a history's two allocations are apart.
            let view = unsafe { RawView::new(start, bytes, binding.access, None) };
            views.push(match resource.image {
                Some(image) => view.with_size(image.size),
                None => view,
            });
        }
        let size = dispatch.kernel.workgroup;
        let all = (x * y * z) as u32;
        (dispatch.kernel.cpu)(&views, Workgroups::new(0..all, count, size));
        Ok(())
    }
}

fn kernel_error(stage: &str, message: String) -> BackendError {
    BackendError::Kernel {
        stage: stage.into(),
        message,
    }
}

impl Executable for Run {
    fn schedule(&self) -> &Arc<Schedule> {
        &self.schedule
    }

    fn upload(&mut self, id: ResourceId, offset: u64, bytes: &[u8]) -> Result<(), BackendError> {
        check_range(&self.schedule, id, offset, bytes.len())?;
        let resource = &self.schedule.resources[id as usize];
        let memory = bytes_of(&mut self.slots[id as usize].memory[0], resource);
        if let Some(image) = resource.image {
            check_image(resource, bytes.len())?;
            // An image holds texels, so what is read later is rounded to its format.
            memory.copy_from_slice(&image.format.decode(&image.format.encode(bytes)));
            return Ok(());
        }
        memory[offset as usize..][..bytes.len()].copy_from_slice(bytes);
        Ok(())
    }

    fn run(&mut self) -> Result<(), BackendError> {
        self.rotate()?;
        (0..self.schedule.steps.len()).try_for_each(|i| self.step(i))
    }

    fn rotate(&mut self) -> Result<(), BackendError> {
        for (slot, resource) in self.slots.iter_mut().zip(&self.schedule.resources) {
            // A history's new value starts undefined, and so does what lives for a frame; images are the host's.
            if let Kind::History(_) = resource.kind {
                slot.memory.rotate_left(1);
                slot.written = false;
            } else if !resource.kind.persists() && resource.image.is_none() {
                slot.written = false;
                slot.memory[0].fill(Line([0xcd; 64]));
            }
        }
        Ok(())
    }

    fn run_step(&mut self, step: usize) -> Result<(), BackendError> {
        check_step(&self.schedule, step).and_then(|()| self.step(step))
    }

    fn read(&mut self, id: ResourceId) -> Result<Vec<u8>, BackendError> {
        check_range(&self.schedule, id, 0, 0)?;
        let resource = &self.schedule.resources[id as usize];
        Ok(bytes_of(&mut self.slots[id as usize].memory[0], resource).to_vec())
    }

    fn reset(&mut self) -> Result<(), BackendError> {
        // What can fail comes first, so that after an error nothing has changed.
        let fresh = slots(&self.schedule)?;
        let slots = self.slots.iter_mut().zip(fresh);
        for ((slot, fresh), resource) in slots.zip(&self.schedule.resources) {
            if let Kind::State(_) | Kind::History(_) = resource.kind {
                *slot = fresh;
            }
        }
        Ok(())
    }

    fn wait(&mut self) -> Result<(), BackendError> {
        Ok(())
    }

    fn adopt(&mut self, schedule: Arc<Schedule>) -> Result<(), BackendError> {
        self.allowed.check(NAME, &schedule)?;
        let mut slots = slots(&schedule)?;
        // Nothing fails from here on, so that after an error all is as it was.
        for (from, to) in schedule.adoptions(&self.schedule) {
            let resource = &self.schedule.resources[from as usize];
            let old = &mut self.slots[from as usize].memory;
            for (new, old) in slots[to as usize].memory.iter_mut().zip(old) {
                // What has become longer begins with what it held.
                bytes_of(new, resource).copy_from_slice(bytes_of(old, resource));
            }
        }
        (self.schedule, self.slots) = (schedule, slots);
        Ok(())
    }
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let cpu = CpuBackend::new(Default::default())?;
    let counting = Counting(CpuBackend::new(Default::default())?);
    let scene = builtin::by_name("cornell").ok_or("no such scene")?;
    let mut cases = cases(&[("cornell", &scene)], &Plan::default(), &cpu)?;
    let participants = [Participant::new(&cpu), Participant::new(&counting)];
    let options = CheckOptions::default();
    let report = check(&mut cases, &participants, &options, |_, _, _| {})?.report;
    let gaps = report.gaps(&cases, &participants);
    let steps: usize = report.cases.iter().map(|case| case.steps.len()).sum();
    println!(
        "{steps} steps of {} frames: {:?}, {} gaps",
        cases.len(),
        report.verdict(),
        gaps.len()
    );

    let (settings, size) = (Settings::default(), [48, 48]);
    let mut renderer = Renderer::new(&counting, &scene.0, &scene.1, size, &settings, 0)?;
    renderer.frame()?;
    let executable: &dyn Any = renderer.executable();
    let run = executable.downcast_ref::<Run>().ok_or("not our own")?;
    let mut counted: Vec<_> = run.schedule.resources.iter().zip(&run.slots).collect();
    counted.sort_by_key(|(_, slot)| std::cmp::Reverse(slot.reads + slot.writes));
    for (resource, slot) in counted.iter().take(8) {
        let (Slot { reads, writes, .. }, key) = (slot, &resource.key);
        println!("{reads:>5} reads, {writes:>3} writes of {key}");
    }
    Ok(ExitCode::from(u8::from(
        report.verdict() != Verdict::Equal || !gaps.is_empty(),
    )))
}
