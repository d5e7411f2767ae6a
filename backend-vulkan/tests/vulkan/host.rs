//! The backend on a device that somebody else made and keeps.
use crate::engine::engaged;
use crate::state::counting;
use crate::support::{prepare, read, upload};
use gibs_backend_vulkan::VulkanExecutable;
use gibs_graph::{Backend, Executable};
use std::any::Any;

#[test]
fn the_device_of_an_engine_is_used_and_left_alone() {
    engaged(|engine| {
        let backend = engine.backend();
        assert!(
            backend
                .device()
                .notes
                .iter()
                .any(|note| note.starts_with("Vulkan"))
        );
        let mut e = prepare(&backend, counting(10));
        upload(&mut *e, "source", &[2u32; 10]);
        e.run().unwrap();
        assert_eq!(read(&mut *e, "total"), (2..12).collect::<Vec<u32>>());

        let total = e.schedule().resource("total").unwrap();
        let e: Box<dyn Any> = e;
        let executable = e.downcast::<VulkanExecutable>().unwrap();
        assert!(executable.buffer(total).is_some());
        assert_eq!(executable.buffer(99), None);
        assert_eq!(executable.schedule().name, "counting");
    });
}
