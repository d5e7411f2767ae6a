//! What the tests of this backend share: opening devices, and a few graphs.
// Every test program uses some of it.
#![allow(dead_code)]
use crate::stages::{add, age, count_odd, double, mark, plan};
use gibs_backend_wgpu::{Options, WgpuBackend, wgpu};
use gibs_graph::{Dispatch, DispatchArgs, Executable, Graph, Initial, ResourceId, Schedule};
use glam::UVec4;
use std::sync::Arc;

/// A backend, or `None` with a message on a machine without a driver.
pub fn open(options: Options) -> Option<WgpuBackend> {
    match WgpuBackend::new(options) {
        Ok(backend) => Some(backend),
        Err(error) if std::env::var("GIBS_STRICT").as_deref() == Ok("1") => panic!("{error}"),
        Err(error) => {
            println!("not run: {error}");
            None
        }
    }
}

pub fn backend() -> Option<WgpuBackend> {
    open(Options::default())
}

pub fn compile(graph: Graph) -> Arc<Schedule> {
    Arc::new(graph.compile(None).unwrap())
}

pub fn id(executable: &dyn Executable, key: &str) -> ResourceId {
    executable.schedule().resource(key).unwrap()
}

pub fn upload(executable: &mut dyn Executable, key: &str, values: &[u32]) {
    executable
        .upload(id(executable, key), 0, bytemuck::cast_slice(values))
        .unwrap();
}

pub fn read(executable: &mut dyn Executable, key: &str) -> Vec<u32> {
    bytemuck::pod_collect_to_vec(&executable.read(id(executable, key)).unwrap())
}

/// `doubled = 2 * numbers`.
pub fn doubling(len: u64) -> Arc<Schedule> {
    let mut g = Graph::new("doubling");
    let numbers = g.input::<u32>("numbers", len);
    let doubled = g.transient::<u32>("doubled", len);
    let out = g.add::<double::Double>(
        "double",
        double::Inputs {
            numbers: &numbers,
            doubled,
        },
        Dispatch::Elements(len),
    );
    g.output("doubled", &out.doubled);
    compile(g)
}

/// `totals += amount`, and `ages += 1` through a history, per frame. Both start at 5.
pub fn aging(totals: u64, ages: u64) -> Arc<Schedule> {
    let mut g = Graph::new("aging");
    let amount = g.input::<UVec4>("amount", 1);
    let (total_state, total) = g.state::<u32>("totals", totals, Initial::fill(5_u32));
    let (age_state, before, now) = g.history::<u32>("ages", ages, Initial::fill(5_u32));
    let add = g.add::<add::Add>(
        "state/add",
        add::Inputs {
            amount: &amount,
            totals: total,
        },
        Dispatch::Elements(totals),
    );
    let age = g.add::<age::Age>(
        "history/age",
        age::Inputs {
            before: &before,
            now,
        },
        Dispatch::Elements(ages),
    );
    g.output("totals", &add.totals);
    g.output("ages", &age.now);
    g.keep(total_state, add.totals);
    g.keep(age_state, age.now);
    compile(g)
}

/// Counts odd numbers and marks as many elements, with a dispatch whose size the device computes.
pub fn counting(len: u64) -> Arc<Schedule> {
    let mut g = Graph::new("counting");
    let numbers = g.input::<u32>("numbers", len);
    let count = g.zeroed::<u32>("count", 1);
    let plan = g.transient::<DispatchArgs>("plan", 1);
    let marks = g.zeroed::<u32>("marks", len);
    let counted = g.add::<count_odd::CountOdd>(
        "count",
        count_odd::Inputs {
            numbers: &numbers,
            count,
        },
        Dispatch::Elements(len),
    );
    let planned = g.add::<plan::Plan>(
        "plan",
        plan::Inputs {
            count: &counted.count,
            plan,
        },
        Dispatch::Groups([1; 3]),
    );
    let marked = g.add::<mark::Mark>(
        "mark",
        mark::Inputs {
            plan: &planned.plan,
            marks,
        },
        Dispatch::Indirect(&planned.plan),
    );
    g.output("count", &counted.count);
    g.output("marks", &marked.marks);
    compile(g)
}

/// A device that an engine made, and the backend on it.
pub struct Engine {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    pub backend: WgpuBackend,
}

/// An engine, or `None` with a message on a machine without a driver.
pub fn engine() -> Option<Engine> {
    backend()?;
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let options = wgpu::RequestAdapterOptions::default();
    let adapter = pollster::block_on(instance.request_adapter(&options)).unwrap();
    let request = adapter.request_device(&wgpu::DeviceDescriptor::default());
    let (device, queue) = pollster::block_on(request).unwrap();
    let backend = WgpuBackend::from_device(&adapter.get_info(), device.clone(), queue.clone());
    Some(Engine {
        device,
        queue,
        backend,
    })
}

impl Engine {
    pub fn encoder(&self) -> wgpu::CommandEncoder {
        self.device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
    }

    pub fn submit(&self, encoder: wgpu::CommandEncoder) -> wgpu::SubmissionIndex {
        self.queue.submit([encoder.finish()])
    }

    /// Waits for everything submitted so far.
    pub fn wait(&self) {
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .unwrap();
    }

    pub fn buffer(&self, bytes: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: bytes,
            usage,
            mapped_at_creation: false,
        })
    }

    /// Waits, and returns what a buffer with the usage `COPY_SRC` holds.
    pub fn read(&self, buffer: &wgpu::Buffer) -> Vec<u32> {
        let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
        let staging = self.buffer(buffer.size(), usage);
        let mut encoder = self.encoder();
        encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, buffer.size());
        self.submit(encoder);
        staging.map_async(wgpu::MapMode::Read, .., |mapped| mapped.unwrap());
        self.wait();
        bytemuck::pod_collect_to_vec(&staging.get_mapped_range(..).unwrap())
    }
}
