//! Frames in command buffers of a host.
use crate::engine::{Engine, engaged};
use crate::images::bytes;
use crate::imports::{executable, id};
use crate::stages::*;
use crate::state::counting;
use crate::support::{read, upload, watched};
use gibs_backend_vulkan::VulkanExecutable;
use gibs_backend_vulkan::ash::vk;
use gibs_graph::{Backend, BackendError, Dispatch, Executable, Graph, bytemuck};

fn doubling(len: u64) -> Graph {
    let mut g = Graph::new("doubling");
    let source = g.input("source", len);
    let target_ = g.transient("target", len);
    let inputs = double::Inputs {
        source: &source,
        target_,
    };
    let out = g.add::<double::Double>("double", inputs, Dispatch::Elements(len));
    g.output("target", &out.target_);
    g
}

/// One frame in a command buffer of its own, submitted and not waited for.
fn frame(engine: &Engine, e: &mut VulkanExecutable) {
    let commands = engine.begin();
    // SAFETY: recorded outside of a render pass and submitted at once; callers wait after at most two.
    unsafe { e.record(commands) }.unwrap();
    engine.submit(commands);
}

#[test]
fn recorded_frames_are_frames() {
    engaged(|engine| {
        let backend = engine.backend();
        let mut recorded = executable(&backend, counting(10));
        let mut run = executable(&backend, counting(10));
        for i in 0..9u32 {
            for e in [&mut recorded, &mut run] {
                upload(e, "source", &[i; 10]);
            }
            // Some that run between those that are recorded.
            match i % 4 {
                3 => recorded.run().unwrap(),
                _ => frame(engine, &mut recorded),
            }
            run.run().unwrap();
            if i % 2 == 0 {
                engine.wait();
            }
            if i % 3 == 0 {
                for key in ["past", "total"] {
                    let got = read(&mut recorded, key);
                    assert_eq!(got, read(&mut run, key), "{key} after frame {i}");
                }
            }
        }
        engine.wait();
        assert_eq!(read(&mut recorded, "total"), (36..46).collect::<Vec<u32>>());
    });
}

/// Two frames and a copy, each of which works on what the one before left, with no barrier of the host between.
#[test]
fn executables_follow_each_other_in_one_command_buffer() {
    engaged(|engine| {
        let backend = engine.backend();
        let mut first = executable(&backend, doubling(100));
        let mut second = executable(&backend, doubling(100));
        let between = first.buffer(id(&first, "target")).unwrap();
        let out = second.buffer(id(&second, "target")).unwrap();
        // SAFETY: the buffer belongs to `first`, which outlives `second`.
        unsafe { second.import_buffer(id(&second, "source"), between) }.unwrap();
        let transfer = vk::PipelineStageFlags::TRANSFER;
        // A frame begins behind everything, whatever its neighbour says about what comes next.
        first.set_exit(vk::PipelineStageFlags::empty(), vk::AccessFlags::empty());
        second.set_exit(transfer, vk::AccessFlags::TRANSFER_READ);
        let rooms = [engine.room(400), engine.room(400)];
        for round in 0..3u32 {
            for (i, room) in (0..).zip(&rooms) {
                let numbers: Vec<u32> = (0..100).map(|n| n * (2 * round + i)).collect();
                upload(&mut first, "source", &numbers);
                let commands = engine.begin();
                // SAFETY: outside of a render pass; submitted at once, and two are waited for below. The copy is
                // inside both buffers.
                unsafe {
                    first.record(commands).unwrap();
                    second.record(commands).unwrap();
                    let region = [vk::BufferCopy::default().size(400)];
                    engine
                        .device
                        .cmd_copy_buffer(commands, out, room.buffer, &region);
                    let visible = [vk::MemoryBarrier::default()
                        .src_access_mask(vk::AccessFlags::TRANSFER_WRITE)
                        .dst_access_mask(vk::AccessFlags::HOST_READ)];
                    engine.device.cmd_pipeline_barrier(
                        commands,
                        transfer,
                        vk::PipelineStageFlags::HOST,
                        vk::DependencyFlags::empty(),
                        &visible,
                        &[],
                        &[],
                    );
                }
                engine.submit(commands);
            }
            engine.wait();
            for (i, room) in (0..).zip(&rooms) {
                let expected: Vec<u32> = (0..100).map(|n| 4 * n * (2 * round + i)).collect();
                assert_eq!(room.read(), bytemuck::cast_slice::<u32, u8>(&expected));
            }
        }
        drop(second);
    });
}

/// Recorded, then run, then read: with no wait of the host between, everything still sees what came before.
#[test]
fn other_calls_come_after_recorded_frames() {
    engaged(|engine| {
        let backend = engine.backend();
        let mut e = executable(&backend, doubling(8));
        for i in 0..4u32 {
            upload(&mut e, "source", &[i; 8]);
            frame(engine, &mut e);
            upload(&mut e, "source", &[i + 10; 8]);
            assert_eq!(read(&mut e, "target"), [2 * i; 8]);
            e.run_step(0).unwrap();
            assert_eq!(read(&mut e, "target"), [2 * i + 20; 8]);
        }
        engine.wait();
    });
}

#[test]
fn large_uploads_have_to_be_sent_off_first() {
    engaged(|engine| {
        let backend = engine.backend();
        let len = 400 << 10;
        let mut e = executable(&backend, doubling(len / 4));
        let source = id(&e, "source");
        let mut expected = vec![0u8; len as usize];
        let small = 64 << 10;
        // Too long, and too many at a time; the last of each is the first that does not come along.
        let mut uploads = vec![vec![(0, small + 4)], vec![(2, 4)], vec![(0, 6)]];
        uploads.push(vec![(4, small); 17]);
        for pieces in uploads {
            for (i, (offset, size)) in pieces.into_iter().enumerate() {
                let bytes = vec![i as u8 + 1; size];
                e.upload(source, offset, &bytes).unwrap();
                expected[offset as usize..][..size].copy_from_slice(&bytes);
            }
            let commands = engine.begin();
            // SAFETY: nothing is recorded.
            let error = unsafe { e.record(commands) }.unwrap_err();
            assert!(matches!(error, BackendError::Refused { .. }), "{error}");
            assert!(error.to_string().contains("wait()"), "{error}");
            engine.submit(commands);
            e.wait().unwrap();
            for (offset, size) in [(0, small), (small, small), (len as usize - 4, 4)] {
                e.upload(source, offset as u64, &vec![9; size]).unwrap();
                expected[offset..offset + size].fill(9);
            }
            frame(engine, &mut e);
            engine.wait();
            assert!(e.read(source).unwrap() == expected);
        }
    });
}

#[test]
fn a_reset_has_to_be_sent_off_first() {
    engaged(|engine| {
        let backend = engine.backend();
        let mut e = executable(&backend, counting(10));
        upload(&mut e, "source", &[5u32; 10]);
        frame(engine, &mut e);
        e.reset().unwrap();
        let commands = engine.begin();
        // SAFETY: nothing is recorded.
        let error = unsafe { e.record(commands) }.unwrap_err();
        assert!(error.to_string().contains("wait()"), "{error}");
        engine.submit(commands);
        e.wait().unwrap();
        frame(engine, &mut e);
        engine.wait();
        assert_eq!(read(&mut e, "total"), (5..15).collect::<Vec<u32>>());
        assert_eq!(read(&mut e, "past"), [7; 10]);
    });
}

/// Small and large uploads take effect in their order, however they are sent.
#[test]
fn uploads_of_all_sizes_keep_their_order() {
    watched(|backend| {
        let len = 300 << 10;
        let mut e = executable(backend, doubling(len / 4));
        let source = id(&e, "source");
        let mut expected = vec![0u8; len as usize];
        let sizes = [8, 65_540, 4, 65_536, 200 << 10, 12, 3, 40_000];
        for (i, size) in sizes.into_iter().cycle().take(60).enumerate() {
            let offset = (i * 7_001) % (len as usize - size);
            let offset = if i % 5 == 0 { offset } else { offset / 4 * 4 };
            e.upload(source, offset as u64, &vec![i as u8; size])
                .unwrap();
            expected[offset..offset + size].fill(i as u8);
            match i % 11 {
                3 => e.run().unwrap(),
                7 => assert!(e.read(source).unwrap() == expected),
                _ => {}
            }
        }
        assert!(e.read(source).unwrap() == expected);
    });
}

#[test]
fn recorded_frames_are_measured() {
    engaged(|engine| {
        let backend = engine.backend();
        if !backend.device().timestamps {
            return;
        }
        let mut e = executable(&backend, doubling(100));
        e.measure(true);
        for _ in 0..3 {
            frame(engine, &mut e);
            engine.wait();
            let times = e.timings().unwrap().unwrap();
            assert_eq!(times.iter().map(|t| t.step).collect::<Vec<_>>(), [0]);
        }
    });
}

/// Images that nobody lent are made for the first frame, and start at zero.
#[test]
fn own_images_are_made_on_the_way() {
    engaged(|engine| {
        let backend = engine.backend();
        let mut e = executable(&backend, bytes([7, 3]));
        let [source, target] = ["source", "target"].map(|key| id(&e, key));
        frame(engine, &mut e);
        assert_eq!(e.read(target).unwrap(), [0; 16 * 21]);
        let white = [1f32; 4 * 21];
        e.upload(source, 0, bytemuck::cast_slice(&white)).unwrap();
        e.wait().unwrap();
        frame(engine, &mut e);
        let got = e.read(target).unwrap();
        assert_eq!(got, bytemuck::cast_slice::<f32, u8>(&white));
    });
}
