//! A frame allocates nothing once the first few have run.
#[allow(dead_code, unused_imports)]
#[path = "vulkan/engine/mod.rs"]
mod engine;
#[allow(dead_code)]
#[path = "vulkan/support.rs"]
mod support;

use engine::{FRESH, TRANSFER_READ, TRANSFER_WRITE};
use gibs_backend_vulkan::ash::vk;
use gibs_backend_vulkan::{ImportedImage, Options, VulkanBackend, VulkanExecutable};
use gibs_graph::{
    Backend, BackendError, Dispatch, Executable, Float, Graph, Rgba8Unorm, WgslSource, Workgroup,
    stage,
};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::Arc;

/// The system's allocator, counting on this thread.
struct Counting;

thread_local! {
    static COUNT: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.with(|count| count.set(count.get() + 1));
        // SAFETY: the caller's promise.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise.
        unsafe { System.dealloc(memory, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

stage! {
    /// Copies.
    pub stage Copy {
        wgsl: WgslSource {
            name: "copy",
            text: "@group(0) @binding(0) var<storage, read> source: array<u32>;
                   @group(0) @binding(1) var<storage, read_write> target_: array<u32>;
                   @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
                       if id.x < arrayLength(&source) { target_[id.x] = source[id.x]; }
                   }",
            modules: &[],
            features: &[],
        },
        workgroup: [64, 1, 1],
        ports: { read source: u32, write target_: u32 },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(_: &Views<'_>, _: Workgroup) {}

#[test]
fn frames_do_not_allocate() {
    let backend = match VulkanBackend::new(Options::default()) {
        Ok(backend) => backend,
        Err(error @ BackendError::Unavailable { .. })
            if std::env::var_os("GIBS_STRICT").is_none_or(|value| value != "1") =>
        {
            return println!("not run: {error}");
        }
        Err(error) => panic!("{error}"),
    };
    let mut g = Graph::new("copy");
    let source = g.input("source", 1024);
    let target_ = g.transient("target", 1024);
    let out = g.add::<Copy>(
        "copy",
        Inputs {
            source: &source,
            target_,
        },
        Dispatch::Elements(1024),
    );
    g.output("target", &out.target_);
    let mut e = backend.prepare(Arc::new(g.compile(None).unwrap())).unwrap();
    let source = e.schedule().resource("source").unwrap();
    let bytes = [7; 4096];
    let mut frame = || {
        for piece in 0..4 {
            e.upload(source, 1024 * piece, &bytes[..1024]).unwrap();
        }
        // Too odd to be held back.
        e.upload(source, 5, &bytes[..1001]).unwrap();
        e.run().unwrap();
    };
    (0..10).for_each(|_| frame());
    let before = COUNT.get();
    (0..200).for_each(|_| frame());
    assert_eq!(COUNT.get() - before, 0);
}

/// Stages of the frame in which images are lent.
mod show {
    use super::*;

    stage! {
        /// Adds a number to every texel.
        pub stage Show {
            wgsl: WgslSource {
                name: "show",
                text: "@group(0) @binding(0) var seen: texture_2d<f32>;
                       @group(0) @binding(1) var<storage, read> source: array<f32>;
                       @group(0) @binding(2) var shown: texture_storage_2d<rgba8unorm, write>;
                       @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
                           let at = vec2(id.x % 8u, id.x / 8u);
                           textureStore(shown, at, textureLoad(seen, at, 0) + source[id.x]);
                       }",
                modules: &[],
                features: &[],
            },
            workgroup: [64, 1, 1],
            ports: { sampled seen: Float, read source: f32, stored shown: Rgba8Unorm },
            cpu: super::unused,
            wide: None,
        }
    }
}

fn unused(_: &show::Views<'_>, _: Workgroup) {}

/// With other images every frame, recorded for the host or run.
#[test]
fn frames_with_images_that_take_turns_do_not_allocate() {
    engine::engaged(|engine| {
        let backend = engine.backend();
        let mut g = Graph::new("show");
        let seen = g.import_image("seen", [8, 8]);
        let source = g.input("source", 64);
        let shown = g.export_image("shown", [8, 8]);
        let inputs = show::Inputs {
            seen: &seen,
            source: &source,
            shown,
        };
        let out = g.add::<show::Show>("show", inputs, Dispatch::Elements(64));
        g.output_image("shown", &out.shown);
        let mut e = backend.prepare_vulkan(support::compile(g)).unwrap();
        let id = |e: &VulkanExecutable, key: &str| e.schedule().resource(key).unwrap();
        let [seen, source, shown] = ["seen", "source", "shown"].map(|key| id(&e, key));
        let color = vk::ImageAspectFlags::COLOR;
        let image = |usage| {
            let format = vk::Format::R8G8B8A8_UNORM;
            engine.image(format, usage, [8, 8], color)
        };
        let sources: [_; 2] = std::array::from_fn(|_| image(vk::ImageUsageFlags::SAMPLED));
        let targets: [_; 3] = std::array::from_fn(|_| image(vk::ImageUsageFlags::STORAGE));
        for lent in sources {
            let commands = engine.begin();
            engine.fill(commands, lent.image, [0.5; 4]);
            engine.submit(commands);
        }
        let mut frame = |number: usize, recorded: bool| {
            let commands = engine.begin();
            let before = COUNT.get();
            let lend = |lent: engine::Lent, entry, exit| ImportedImage {
                image: lent.image,
                view: lent.view,
                aspect: color,
                entry,
                exit,
            };
            // SAFETY: the images live until the engine ends, fit, and come as their entries say; what is recorded is
            // submitted at once, and waited for.
            unsafe {
                let from = lend(sources[number % 2], TRANSFER_WRITE, TRANSFER_WRITE);
                let to = lend(targets[number % 3], FRESH, TRANSFER_READ);
                e.import_image(seen, from).unwrap();
                e.import_image(shown, to).unwrap();
                e.upload(source, 4, &[number as u8; 64]).unwrap();
                if recorded {
                    e.record(commands).unwrap();
                } else {
                    e.run().unwrap();
                }
            }
            let allocated = COUNT.get() - before;
            engine.submit(commands);
            engine.wait();
            allocated
        };
        for recorded in [true, false] {
            for i in 0..12 {
                frame(i, recorded);
            }
            let allocated: u64 = (0..60).map(|i| frame(i, recorded)).sum();
            assert_eq!(allocated, 0, "recorded: {recorded}");
        }
        let allocated: u64 = (0..60).map(|i| frame(i, i % 5 < 2)).sum();
        assert_eq!(allocated, 0, "in turns");
    });
}
