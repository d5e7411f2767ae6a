//! Images that a host lends.
use crate::engine::{
    Engine, FRESH, Lent, Room, TRANSFER_READ, TRANSFER_WRITE, engaged, overheard, whole,
};
use crate::images::bytes;
use crate::stages::*;
use crate::support::{compile, read};
use gibs_backend_vulkan::ash::vk;
use gibs_backend_vulkan::{ImageUse, ImportedImage, VulkanBackend, VulkanExecutable};
use gibs_graph::{BackendError, Dispatch, Executable, Float, Graph, ResourceId, bytemuck};

pub fn executable(backend: &VulkanBackend, graph: Graph) -> VulkanExecutable {
    backend.prepare_vulkan(compile(graph)).unwrap()
}

pub fn id(e: &VulkanExecutable, key: &str) -> ResourceId {
    e.schedule().resource(key).unwrap()
}

fn color(lent: Lent, entry: ImageUse, exit: ImageUse) -> ImportedImage {
    ImportedImage {
        image: lent.image,
        view: lent.view,
        aspect: vk::ImageAspectFlags::COLOR,
        entry,
        exit,
    }
}

const SIZE: [u32; 2] = [7, 3];

/// Two sources and three targets that take turns, so that every pair of them comes at either parity.
struct Turns {
    sources: [Lent; 2],
    targets: [Lent; 3],
    room: Room,
}

impl Turns {
    fn new(engine: &Engine) -> Self {
        let format = vk::Format::R8G8B8A8_UNORM;
        let seen = vk::ImageAspectFlags::COLOR;
        let image = |usage| engine.image(format, usage, SIZE, seen);
        Self {
            sources: std::array::from_fn(|_| image(vk::ImageUsageFlags::SAMPLED)),
            targets: std::array::from_fn(|_| image(vk::ImageUsageFlags::STORAGE)),
            room: engine.room(4 * 21),
        }
    }

    /// Fills a source, has it stored in a target, and copies that. Gives what should be found there.
    fn frame(
        &self,
        engine: &Engine,
        e: &mut VulkanExecutable,
        frame: usize,
        recorded: bool,
    ) -> [u8; 4] {
        let (source, target) = (self.sources[frame % 2], self.targets[frame % 3]);
        let expected = [frame as u8, 255 - frame as u8, 7, 128];
        let color_in = expected.map(|x| f32::from(x) / 255.0);
        let (from, to) = (id(e, "source"), id(e, "target"));
        let mut commands = engine.begin();
        engine.fill(commands, source.image, color_in);
        // SAFETY: images and views live until the engine ends, fit the resources, and come as the entries say.
        unsafe {
            e.import_image(from, color(source, TRANSFER_WRITE, TRANSFER_WRITE))
                .unwrap();
            e.import_image(to, color(target, FRESH, TRANSFER_READ))
                .unwrap();
        }
        if recorded {
            // SAFETY: submitted below, once, and waited for.
            unsafe { e.record(commands) }.unwrap();
        } else {
            engine.submit(commands);
            e.run().unwrap();
            commands = engine.begin();
        }
        engine.copy(commands, target.image, SIZE, &self.room);
        engine.submit(commands);
        expected
    }
}

#[test]
fn images_that_take_turns_are_used_in_place() {
    engaged(|engine| {
        let backend = engine.backend();
        let mut e = executable(&backend, bytes(SIZE));
        let turns = Turns::new(engine);
        for recorded in [false, true] {
            for frame in 0..13 {
                // Recording and running in turns, at the end.
                let recorded = recorded ^ (frame > 8 && frame % 2 == 0);
                let expected = turns.frame(engine, &mut e, frame, recorded);
                engine.wait();
                assert_eq!(turns.room.read(), expected.repeat(21), "frame {frame}");
            }
            // SAFETY: everything was waited for.
            unsafe { e.forget_imports() }.unwrap();
        }
    });
}

/// More combinations than there is room for at first, and again after they were forgotten.
#[test]
fn any_number_of_images_may_take_turns() {
    engaged(|engine| {
        let backend = engine.backend();
        let mut e = executable(&backend, bytes(SIZE));
        for _ in 0..2 {
            for frame in 0..10 {
                let turns = Turns::new(engine);
                let expected = turns.frame(engine, &mut e, frame, frame % 2 == 0);
                engine.wait();
                assert_eq!(turns.room.read(), expected.repeat(21));
            }
            // SAFETY: everything was waited for.
            unsafe { e.forget_imports() }.unwrap();
        }
    });
}

/// Images come to a step that runs alone as they come to a frame.
#[test]
fn a_step_takes_images_and_gives_them_back() {
    engaged(|engine| {
        let backend = engine.backend();
        let mut e = executable(&backend, bytes(SIZE));
        let turns = Turns::new(engine);
        turns.frame(engine, &mut e, 0, false);
        let source = turns.sources[0].image;
        let commands = engine.begin();
        engine.fill(commands, source, [1.0, 0.0, 1.0, 0.0]);
        engine.submit(commands);
        e.run_step(0).unwrap();
        let commands = engine.begin();
        engine.copy(commands, turns.targets[0].image, SIZE, &turns.room);
        engine.submit(commands);
        engine.wait();
        assert_eq!(turns.room.read(), [255, 0, 255, 0].repeat(21));
    });
}

/// What was lent does not touch the executable's own image, which is used again afterwards.
#[test]
fn own_images_come_back() {
    engaged(|engine| {
        let backend = engine.backend();
        let mut e = executable(&backend, bytes(SIZE));
        let [source, target] = ["source", "target"].map(|key| id(&e, key));
        let white = [1f32; 4 * 21];
        e.upload(source, 0, bytemuck::cast_slice(&white)).unwrap();
        let turns = Turns::new(engine);
        turns.frame(engine, &mut e, 5, false);
        for error in [
            e.upload(source, 0, &[0; 16]).err(),
            e.read(source).err(),
            e.read(target).err(),
        ] {
            let said = error.as_ref().unwrap().to_string();
            assert!(
                matches!(error, Some(BackendError::Refused { .. })),
                "{said}"
            );
            assert!(said.contains("the host has lent it"), "{said}");
        }
        engine.wait();
        // SAFETY: everything was waited for.
        unsafe { e.forget_imports() }.unwrap();
        e.run().unwrap();
        assert_eq!(
            e.read(target).unwrap(),
            bytemuck::cast_slice::<f32, u8>(&white)
        );
    });
}

#[test]
fn a_depth_is_in_the_first_component() {
    engaged(|engine| {
        let backend = engine.backend();
        let aspects = vk::ImageAspectFlags::DEPTH | vk::ImageAspectFlags::STENCIL;
        for (format, aspect) in [
            (vk::Format::D32_SFLOAT, vk::ImageAspectFlags::DEPTH),
            (vk::Format::D32_SFLOAT_S8_UINT, aspects),
        ] {
            // SAFETY: the physical device is the engine's.
            let properties = unsafe {
                engine
                    .instance
                    .get_physical_device_format_properties(engine.physical, format)
            };
            let wanted =
                vk::FormatFeatureFlags::SAMPLED_IMAGE | vk::FormatFeatureFlags::TRANSFER_DST;
            if !properties.optimal_tiling_features.contains(wanted) {
                continue;
            }
            let mut g = Graph::new("depth");
            let source = g.import_image::<Float>("source", SIZE);
            let target_ = g.transient("target", 21);
            let inputs = texel_bits::Inputs {
                source: &source,
                target_,
            };
            let elements = Dispatch::Elements(21);
            let out = g.add::<texel_bits::TexelBits>("load", inputs, elements);
            g.output("target", &out.target_);
            let mut e = executable(&backend, g);
            let usage = vk::ImageUsageFlags::SAMPLED;
            let depth = engine.image(format, usage, SIZE, vk::ImageAspectFlags::DEPTH);
            let commands = engine.begin();
            engine.pass(commands, depth.image, aspect, FRESH, TRANSFER_WRITE);
            let value = vk::ClearDepthStencilValue {
                depth: 0.375,
                stencil: 9,
            };
            let layout = TRANSFER_WRITE.layout;
            // SAFETY: the command buffer is being recorded; the image lives until the engine ends, and comes as its
            // entry says.
            unsafe {
                let (image, all) = (depth.image, [whole(aspect)]);
                engine
                    .device
                    .cmd_clear_depth_stencil_image(commands, image, layout, &value, &all);
                let mut lent = color(depth, TRANSFER_WRITE, TRANSFER_WRITE);
                lent.aspect = aspect;
                e.import_image(id(&e, "source"), lent).unwrap();
            }
            engine.submit(commands);
            e.run().unwrap();
            for texel in read(&mut e, "target").as_chunks::<4>().0 {
                assert_eq!(f32::from_bits(texel[0]), 0.375);
            }
        }
    });
}

/// The positive control: what the host says about an image is what the barriers are made of.
#[test]
fn wrong_uses_are_reported() {
    let wrong = |entry, exit, message: &str| {
        let messages = overheard(|engine| {
            let backend = engine.backend();
            let mut e = executable(&backend, bytes(SIZE));
            let turns = Turns::new(engine);
            let (from, to) = (id(&e, "source"), id(&e, "target"));
            let commands = engine.begin();
            engine.fill(commands, turns.sources[0].image, [0.5; 4]);
            // SAFETY: but for a wrong layout, which is what the layer is to find and the device does not mind, as in
            // the other tests.
            unsafe {
                e.import_image(from, color(turns.sources[0], entry, TRANSFER_WRITE))
                    .unwrap();
                e.import_image(to, color(turns.targets[0], FRESH, exit))
                    .unwrap();
                // Else the barrier at the end would do for the image, too.
                e.set_exit(vk::PipelineStageFlags::empty(), vk::AccessFlags::empty());
                e.record(commands).unwrap();
            }
            engine.copy(commands, turns.targets[0].image, SIZE, &turns.room);
            engine.submit(commands);
            engine.wait();
        });
        let found = |messages: &Vec<String>| messages.iter().any(|m| m.contains(message));
        assert!(messages.as_ref().is_none_or(found), "{messages:?}");
    };
    wrong(TRANSFER_READ, TRANSFER_READ, "layout");
    let unordered = ImageUse {
        stage: vk::PipelineStageFlags::empty(),
        access: vk::AccessFlags::empty(),
        ..TRANSFER_READ
    };
    wrong(TRANSFER_WRITE, unordered, "SYNC-HAZARD");
}
