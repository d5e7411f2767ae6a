//! Buffers that a host lends, and what it cannot lend.
use crate::engine::{FRESH, Room, TRANSFER_READ, engaged};
use crate::images::bytes;
use crate::imports::{executable, id};
use crate::stages::*;
use crate::support::{compile, read, upload, watched, words};
use gibs_backend_vulkan::ImportedImage;
use gibs_backend_vulkan::ash::vk;
use gibs_graph::{BackendError, Dispatch, Executable, Graph, bytemuck};

fn affine() -> Graph {
    let mut g = Graph::new("line");
    let line = g.input("line", 1);
    let source = g.input("source", 4);
    let target_ = g.transient("target", 4);
    let inputs = line::Inputs {
        line: &line,
        source: &source,
        target_,
    };
    let out = g.add::<line::Affine>("line", inputs, Dispatch::Elements(4));
    g.output("target", &out.target_);
    g
}

#[test]
fn buffers_are_used_in_place() {
    engaged(|engine| {
        let backend = engine.backend();
        let mut e = executable(&backend, affine());
        upload(&mut e, "source", &[10u32, 20, 30, 40]);
        let lines: [Room; 2] = std::array::from_fn(|_| engine.room(16));
        let numbers = engine.room(16);
        for frame in 0..6u32 {
            let line = &lines[frame as usize % 2];
            line.write(bytemuck::bytes_of(&Line {
                factor: frame,
                offset: 1,
                ..Line::default()
            }));
            // SAFETY: the buffers live until the engine ends, and are large enough.
            unsafe {
                e.import_buffer(id(&e, "line"), line.buffer).unwrap();
                if frame >= 3 {
                    numbers.write(bytemuck::cast_slice(&[1u32, 2, 3, frame]));
                    e.import_buffer(id(&e, "source"), numbers.buffer).unwrap();
                }
            }
            e.run().unwrap();
            let source = if frame < 3 {
                [10, 20, 30, 40]
            } else {
                [1, 2, 3, frame]
            };
            assert_eq!(read(&mut e, "target"), source.map(|x| frame * x + 1));
        }
        assert_eq!(e.buffer(id(&e, "source")), Some(numbers.buffer));
        assert!(e.read(id(&e, "source")).is_err(), "it is the host's");
        // SAFETY: reading waited for everything.
        unsafe { e.forget_imports() }.unwrap();
        assert_eq!(read(&mut e, "source"), [10, 20, 30, 40], "its own again");
        assert_eq!(words(&e.read(id(&e, "line")).unwrap()), [0; 4]);
    });
}

#[test]
fn a_new_schedule_starts_without_imports() {
    engaged(|engine| {
        let backend = engine.backend();
        let mut e = executable(&backend, affine());
        upload(&mut e, "source", &[10u32, 20, 30, 40]);
        let numbers = engine.room(16);
        // SAFETY: the buffer lives until the engine ends, and is large enough.
        unsafe { e.import_buffer(id(&e, "source"), numbers.buffer) }.unwrap();
        e.run().unwrap();
        e.adopt(compile(affine())).unwrap();
        assert_eq!(read(&mut e, "source"), [10, 20, 30, 40]);
    });
}

#[test]
fn what_does_not_fit_is_refused() {
    watched(|backend| {
        let mut images = executable(backend, bytes([7, 3]));
        let mut buffers = executable(backend, affine());
        let nothing = ImportedImage {
            image: vk::Image::null(),
            view: vk::ImageView::null(),
            aspect: vk::ImageAspectFlags::COLOR,
            entry: FRESH,
            exit: TRANSFER_READ,
        };
        let kept = ImportedImage {
            exit: FRESH,
            ..nothing
        };
        let [source, target] = ["source", "target"].map(|key| id(&buffers, key));
        let image = id(&images, "source");
        // SAFETY: nothing is used, because everything is refused.
        let errors = unsafe {
            [
                (buffers.import_image(source, nothing), "use import_buffer"),
                (images.import_image(image, kept), "UNDEFINED"),
                (
                    images.import_buffer(image, vk::Buffer::null()),
                    "use import_image",
                ),
                (
                    buffers.import_buffer(target, vk::Buffer::null()),
                    "no input",
                ),
            ]
        };
        for (result, expected) in errors {
            let error = result.unwrap_err();
            assert!(matches!(error, BackendError::Refused { .. }), "{error}");
            assert!(error.to_string().contains(expected), "{error}");
        }
        // SAFETY: as above.
        unsafe {
            for error in [
                images.import_image(99, nothing),
                images.import_buffer(99, vk::Buffer::null()),
            ] {
                let error = error.unwrap_err();
                assert!(matches!(error, BackendError::Refused { .. }), "{error}");
            }
        }
        images.run().unwrap();
        buffers.run().unwrap();
    });
}
