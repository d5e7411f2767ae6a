//! What all tests share: a watched backend, and short names for common steps.
use gibs_backend_vulkan::{Options, VulkanBackend};
use gibs_graph::{Backend, BackendError, Element, Executable, Graph, Schedule, bytemuck};
use std::sync::Arc;

/// Runs `test` on a backend with full validation, and fails on any message of the layer, also one that comes while
/// the backend goes. Without a driver or the layer it fails if `GIBS_STRICT=1`, else says that it did not run.
pub fn watched(test: impl FnOnce(&VulkanBackend)) {
    let Some(backend) = start() else { return };
    let log = backend.validation_log();
    test(&backend);
    drop(backend);
    assert_eq!(log.messages(), Vec::<String>::new());
}

/// The backend of [`watched`], for tests that look at the messages themselves.
pub fn start() -> Option<VulkanBackend> {
    let options = Options {
        validation: true,
        sync_validation: true,
        device: None,
    };
    match VulkanBackend::new(options) {
        Ok(backend) => Some(backend),
        Err(error @ BackendError::Unavailable { .. }) if !strict() => {
            println!("not run: {error}");
            None
        }
        Err(error) => panic!("{error}"),
    }
}

fn strict() -> bool {
    std::env::var_os("GIBS_STRICT").is_some_and(|value| value == "1")
}

/// A schedule ready to run, without anything adopted.
pub fn prepare(backend: &VulkanBackend, graph: Graph) -> Box<dyn Executable> {
    backend.prepare(compile(graph)).unwrap()
}

pub fn compile(graph: Graph) -> Arc<Schedule> {
    Arc::new(graph.compile(None).unwrap())
}

/// Puts `values` at the start of the resource with this key.
pub fn upload<T: Element>(executable: &mut dyn Executable, key: &str, values: &[T]) {
    let resource = executable.schedule().resource(key).unwrap();
    executable
        .upload(resource, 0, bytemuck::cast_slice(values))
        .unwrap();
}

/// The content of the resource with this key.
pub fn read(executable: &mut dyn Executable, key: &str) -> Vec<u32> {
    let resource = executable.schedule().resource(key).unwrap();
    words(&executable.read(resource).unwrap())
}

/// Bytes as numbers.
pub fn words(bytes: &[u8]) -> Vec<u32> {
    bytes
        .as_chunks()
        .0
        .iter()
        .map(|word| u32::from_ne_bytes(*word))
        .collect()
}
