//! A frame allocates nothing once the first few have run.
use gibs_backend_vulkan::{Options, VulkanBackend};
use gibs_graph::{Backend, BackendError, Dispatch, Graph, WgslSource, Workgroup, stage};
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
    let mut e = backend
        .prepare(Arc::new(g.compile(None).unwrap()), None)
        .unwrap();
    let source = e.schedule().resource("source").unwrap();
    let bytes = [7; 4096];
    let mut frame = || {
        for piece in 0..4 {
            e.upload(source, 1024 * piece, &bytes[..1024]).unwrap();
        }
        e.run().unwrap();
    };
    (0..10).for_each(|_| frame());
    let before = COUNT.get();
    (0..200).for_each(|_| frame());
    assert_eq!(COUNT.get() - before, 0);
}
