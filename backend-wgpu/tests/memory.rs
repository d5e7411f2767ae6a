//! What a frame takes: no object of the API, and of the heap no more than wgpu itself. In a program of its own, because
//! the allocator is everybody's.
mod common;
mod stages;

use common::{Engine, aging, counting, engine, id, upload};
use gibs_backend_wgpu::{WgpuExecutable, wgpu};
use gibs_graph::{Access, Action, Backend, DispatchSize, Executable, Schedule};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::Arc;

/// The system's allocator, counting on this thread. wgpu has no threads of its own.
struct Counting;

thread_local! {
    static CALLS: Cell<i64> = const { Cell::new(0) };
    static HELD: Cell<i64> = const { Cell::new(0) };
}

fn count(calls: i64, bytes: i64) {
    CALLS.set(CALLS.get() + calls);
    HELD.set(HELD.get() + bytes);
}

// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(1, layout.size() as i64);
        // SAFETY: the caller's promise.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        count(0, -(layout.size() as i64));
        // SAFETY: the caller's promise; `memory` came from the system's allocator.
        unsafe { System.dealloc(memory, layout) }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count(1, size as i64 - layout.size() as i64);
        // SAFETY: as in `dealloc`.
        unsafe { System.realloc(memory, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Objects of the API that there are: what a frame must not make. Command encoders and fences come from wgpu's pools.
fn objects(device: &wgpu::Device) -> [isize; 13] {
    let counters = device.get_internal_counters().hal;
    [
        counters.buffers,
        counters.textures,
        counters.texture_views,
        counters.bind_groups,
        counters.bind_group_layouts,
        counters.render_pipelines,
        counters.compute_pipelines,
        counters.pipeline_layouts,
        counters.samplers,
        counters.shader_modules,
        counters.query_sets,
        counters.buffer_memory,
        counters.memory_allocations,
    ]
    .map(|counter| counter.read())
}

/// Uploads of both kinds that wait for a frame: whole words, and parts of words.
fn uploads(one: &mut WgpuExecutable, two: &mut WgpuExecutable, frame: u32) {
    upload(one, "numbers", &[frame; 1000]);
    let numbers = id(one, "numbers");
    one.upload(numbers, 5, &[frame as u8; 13]).unwrap();
    upload(two, "amount", &[frame, 0, 0, 0]);
}

#[test]
fn frames_make_no_objects() {
    let Some(engine) = engine() else { return };
    let mut one = engine.backend.prepare_wgpu(counting(1000)).unwrap();
    let mut two = engine.backend.prepare_wgpu(aging(9, 9)).unwrap();
    for recorded in [true, false] {
        let mut idle = [0; 13];
        for frame in 0..60 {
            uploads(&mut one, &mut two, frame);
            let mut encoder = engine.encoder();
            if recorded {
                one.record(&mut encoder).unwrap();
                uploads(&mut one, &mut two, frame + 1);
                one.record(&mut encoder).unwrap();
                two.record(&mut encoder).unwrap();
            } else {
                one.run().unwrap();
                two.run().unwrap();
            }
            // Until the submission all that recorded frames use is alive, also what they would make for themselves.
            let busy = objects(&engine.device);
            engine.submit(encoder);
            // How many staging buffers there are depends on how many frames the device is behind.
            engine.wait();
            if frame < 10 {
                idle = objects(&engine.device);
            }
            let now = objects(&engine.device);
            assert!(
                frame < 10 || [busy, now] == [idle; 2],
                "frame {frame}, recorded: {recorded}: {busy:?}, then {now:?}, at first {idle:?}"
            );
        }
        assert!(idle[0] > 0 && idle[6] > 0, "nothing is counted");
    }
}

#[test]
fn a_host_that_never_waits_does_not_pile_up_staging_buffers() {
    let Some(engine) = engine() else { return };
    // More work for the device than for the host.
    let schedule = aging(1 << 22, 1 << 22);
    let mut run = engine.backend.prepare_wgpu(schedule).unwrap();
    let mut buffers = Vec::new();
    for frame in 0..40 {
        upload(&mut run, "amount", &[frame, 0, 0, 0]);
        run.run().unwrap();
        buffers.push(objects(&engine.device)[0]);
    }
    // One for the frame that the device is at, and one for the next.
    let most = buffers.iter().max().unwrap();
    assert!(*most <= buffers[0] + 1, "{buffers:?}");
}

/// The frame of a schedule without histories in plain wgpu, as one would write it by hand.
struct Plain {
    schedule: Arc<Schedule>,
    stages: Vec<Option<(wgpu::ComputePipeline, wgpu::BindGroup)>>,
    buffers: Vec<Option<wgpu::Buffer>>,
    belt: wgpu::util::StagingBelt,
}

impl Plain {
    /// On the buffers of an executable. The kernels number their globals in the order of the ports.
    fn new(engine: &Engine, run: &WgpuExecutable) -> Self {
        let schedule = Arc::clone(run.schedule());
        let buffers: Vec<_> = (0..schedule.resources.len() as u32)
            .map(|r| run.buffer(r).cloned())
            .collect();
        let stage = |label: &str, action: &Action| {
            let Action::Dispatch(dispatch) = action else {
                return None;
            };
            let wgsl = dispatch.kernel.wgsl.text.into();
            let module = wgpu::ShaderModuleDescriptor {
                label: Some(label),
                source: wgpu::ShaderSource::Wgsl(wgsl),
            };
            let module = engine.device.create_shader_module(module);
            let bound = || dispatch.bindings.iter().filter(|b| b.access.is_bound());
            let entries: Vec<_> = (0..)
                .zip(bound())
                .map(|(binding, b)| layout_entry(binding, b.access))
                .collect();
            let layout = wgpu::BindGroupLayoutDescriptor {
                label: Some(label),
                entries: &entries,
            };
            let layout = engine.device.create_bind_group_layout(&layout);
            let pipeline_layout = wgpu::PipelineLayoutDescriptor {
                label: Some(label),
                bind_group_layouts: &[Some(&layout)],
                immediate_size: 0,
            };
            let pipeline_layout = engine.device.create_pipeline_layout(&pipeline_layout);
            let pipeline = wgpu::ComputePipelineDescriptor {
                label: Some(label),
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some("main"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            };
            let pipeline = engine.device.create_compute_pipeline(&pipeline);
            let entries: Vec<_> = (0..)
                .zip(bound())
                .map(|(binding, b)| wgpu::BindGroupEntry {
                    binding,
                    resource: buffers[b.resource as usize]
                        .as_ref()
                        .unwrap()
                        .as_entire_binding(),
                })
                .collect();
            let group = wgpu::BindGroupDescriptor {
                label: Some(label),
                layout: &layout,
                entries: &entries,
            };
            let group = engine.device.create_bind_group(&group);
            Some((pipeline, group))
        };
        Self {
            stages: schedule
                .steps
                .iter()
                .map(|step| stage(&step.label, &step.action))
                .collect(),
            belt: wgpu::util::StagingBelt::new(engine.device.clone(), 64 << 10),
            buffers,
            schedule,
        }
    }

    /// Uploads pieces of a resource through a belt of its own.
    fn upload(&mut self, encoder: &mut wgpu::CommandEncoder, resource: u32, pieces: &[&[u8]]) {
        let bytes = pieces.iter().map(|piece| piece.len()).sum::<usize>() as u64;
        let staged = self
            .belt
            .allocate(wgpu::BufferSize::new(bytes).unwrap(), wgpu::BufferSize::MIN);
        let mut view = staged.get_mapped_range_mut().unwrap();
        let target = self.buffers[resource as usize].as_ref().unwrap();
        let mut at = 0;
        for piece in pieces {
            let end = at + piece.len();
            view.slice(at..end).copy_from_slice(piece);
            let from = staged.offset() + at as u64;
            let len = piece.len() as u64;
            encoder.copy_buffer_to_buffer(staged.buffer(), from, target, at as u64, len);
            at = end;
        }
        drop(view);
        self.belt.finish_and_recall_on_submit(encoder);
    }

    fn record(&self, encoder: &mut wgpu::CommandEncoder) {
        let buffer = |resource: u32| self.buffers[resource as usize].as_ref().unwrap();
        let mut i = 0;
        while let Some(step) = self.schedule.steps.get(i) {
            if let Action::Clear(resource) = step.action {
                encoder.clear_buffer(buffer(resource), 0, None);
                i += 1;
                continue;
            }
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some(&step.label),
                timestamp_writes: None,
            });
            while let Some(Action::Dispatch(dispatch)) =
                self.schedule.steps.get(i).map(|step| &step.action)
            {
                let (pipeline, group) = self.stages[i].as_ref().unwrap();
                pass.set_pipeline(pipeline);
                pass.set_bind_group(0, group, &[]);
                match dispatch.size {
                    DispatchSize::Groups([x, y, z]) => pass.dispatch_workgroups(x, y, z),
                    DispatchSize::Indirect(args) => {
                        pass.dispatch_workgroups_indirect(buffer(args), 0);
                    }
                    other => panic!("{other:?}"),
                }
                i += 1;
            }
        }
    }
}

fn layout_entry(binding: u32, access: Access) -> wgpu::BindGroupLayoutEntry {
    let ty = match access {
        Access::Uniform => wgpu::BufferBindingType::Uniform,
        Access::Read => wgpu::BufferBindingType::Storage { read_only: true },
        _ => wgpu::BufferBindingType::Storage { read_only: false },
    };
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty,
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    }
}

/// What frames took of the heap.
#[derive(Debug)]
struct Taken {
    /// Allocations of the frame with the fewest, and with the most.
    least: i64,
    most: i64,
    /// Bytes that were held after all frames and not before.
    kept: i64,
}

/// Runs many frames, after some that make what is kept.
fn measure(engine: &Engine, mut frame: impl FnMut()) -> Taken {
    let mut run = |count: usize| {
        let (mut least, mut most) = (i64::MAX, 0);
        let held = HELD.get();
        for _ in 0..count {
            let before = CALLS.get();
            frame();
            // So that wgpu finds the same work done in every frame.
            engine.wait();
            let calls = CALLS.get() - before;
            (least, most) = (least.min(calls), most.max(calls));
        }
        Taken {
            least,
            most,
            kept: HELD.get() - held,
        }
    };
    run(50);
    run(200)
}

/// wgpu boxes the answer of an error scope, and a call to the backend that may fail opens three.
const SCOPES: i64 = 3;

/// The belt gets its staging buffers back through a channel of the standard library, which allocates a block for every
/// 31 of them.
const CHANNEL: i64 = 1;

#[test]
fn frames_take_of_the_heap_what_wgpu_takes() {
    let Some(engine) = engine() else { return };
    let mut run = engine.backend.prepare_wgpu(counting(1000)).unwrap();
    let numbers = id(&run, "numbers");
    let mut plain = Plain::new(&engine, &run);
    let bytes = [3; 4000];
    let pieces: Vec<&[u8]> = bytes.chunks(1000).collect();
    let upload = |run: &mut WgpuExecutable| {
        for (at, piece) in (0..).step_by(1000).zip(&pieces) {
            run.upload(numbers, at, piece).unwrap();
        }
    };
    let name = &engine.backend.device().name;
    let encoder = || {
        let label = Some(name.as_str());
        let descriptor = wgpu::CommandEncoderDescriptor { label };
        engine.device.create_command_encoder(&descriptor)
    };
    let mut last = None;
    // What wgpu takes grows with the number of objects that there are; in the second round there are all of them.
    for round in 0..2 {
        let empty = measure(&engine, || {
            engine.submit(encoder());
        });
        let without = measure(&engine, || {
            let mut encoder = encoder();
            plain.record(&mut encoder);
            engine.submit(encoder);
        });
        let by_hand = measure(&engine, || {
            let mut encoder = encoder();
            plain.upload(&mut encoder, numbers, &pieces);
            plain.record(&mut encoder);
            let submitted = engine.submit(encoder);
            // `run` waits for the frame before the last one, and so do those who do it by hand.
            if let Some(submission_index) = last.replace(submitted) {
                let poll = wgpu::PollType::Wait {
                    submission_index: Some(submission_index),
                    timeout: None,
                };
                engine.device.poll(poll).unwrap();
            }
        });
        let recorded = measure(&engine, || {
            let mut encoder = encoder();
            upload(&mut run);
            run.record(&mut encoder).unwrap();
            engine.submit(encoder);
        });
        let ran = measure(&engine, || {
            upload(&mut run);
            run.run().unwrap();
        });
        let parts = measure(&engine, || {
            run.upload(numbers, 5, &bytes[..101]).unwrap();
            run.run().unwrap();
        });
        if round == 0 {
            continue;
        }
        println!("an empty submission: {empty:?}");
        println!("a frame by hand: {by_hand:?}, without uploads {without:?}");
        println!(
            "recorded: {recorded:?}; run: {ran:?}; run after uploads of parts of words: {parts:?}"
        );
        let spread = by_hand.most - by_hand.least;
        for taken in [&recorded, &ran, &parts] {
            assert!(taken.kept <= 0, "{taken:?}");
            // What the device is done with comes back a frame early or late, by hand too.
            assert!(taken.most - taken.least <= spread + CHANNEL, "{taken:?}");
        }
        // A block of a channel may fall into either count.
        assert!(recorded.least <= by_hand.least + SCOPES + CHANNEL);
        // One call that waits, and one that submits.
        assert!(ran.least <= by_hand.least + 2 * SCOPES + CHANNEL);
    }
}
