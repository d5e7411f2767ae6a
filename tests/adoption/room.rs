//! More and less room for surfels, and a reset.
use crate::common::{all_backends, settings};
use crate::harness::{SIZE, box_with_surfels, live, state, states};
use gibs::graph::Initial;
use gibs::passes::data::{SurfelCounters, SurfelPose};
use gibs::passes::frame::Settings;
use gibs::passes::shared::{depth, guide};
use gibs::{RenderError, Renderer, builtin};
use std::collections::BTreeSet;

/// A capacity that grows keeps what is there, and the new slots are free.
#[test]
fn more_room_keeps_every_surfel() {
    for backend in all_backends() {
        let (_, _, mut renderer) = box_with_surfels(backend.as_ref());
        let had = live(&mut renderer);
        let before = states(&mut renderer);
        let settings = Settings {
            surfels: 10_000,
            ..settings(4000)
        };
        renderer.set_settings(&settings).expect("more room");
        assert_eq!(live(&mut renderer), had);
        let after = states(&mut renderer);
        for (key, bytes) in &before {
            let kept = &after[key][..bytes.len()];
            assert!(kept == bytes, "{key} on {}", backend.name());
        }
        for _ in 0..4 {
            renderer.frame().expect("a frame");
            let exec = renderer.executable();
            let stack: Vec<u32> = state(exec, "surfel_free_slots");
            let poses: Vec<SurfelPose> = state(exec, "surfel_poses");
            let live = state::<SurfelCounters>(exec, "surfel_counters")[0].live;
            let free: BTreeSet<u32> = stack[live as usize..].iter().copied().collect();
            assert_eq!(free.len(), 10_000 - live as usize, "a slot is free twice");
            let is_free = |slot: &u32| poses[*slot as usize].radius <= 0.0;
            assert!(free.iter().all(is_free), "{}", backend.name());
        }
        assert!(live(&mut renderer) > had);
    }
}

/// Wider and narrower depth functions begin anew, as if no ray had told anything, and nothing else does: their texels would be those of
/// other surfels.
#[test]
fn depth_functions_of_another_size_begin_anew() {
    for backend in all_backends() {
        for side in [6, 3] {
            let (_, _, mut renderer) = box_with_surfels(backend.as_ref());
            let before = states(&mut renderer);
            let settings = Settings {
                depth_side: side,
                ..settings(4000)
            };
            renderer.set_settings(&settings).expect("another size");
            let mut after = states(&mut renderer);
            let depths = after.remove("surfel_depths").expect("a state");
            let texels = settings.slots() as usize * depth::count(side);
            assert!(depths == vec![0xff; 4 * texels], "{}", backend.name());
            for (key, bytes) in after {
                assert!(before[&key] == bytes, "{key} on {}", backend.name());
            }
            renderer.frame().expect("a frame");
            let depths: Vec<u32> = state(renderer.executable(), "surfel_depths");
            assert!(depths.iter().any(|&texel| texel != depth::UNKNOWN));
        }
    }
}

/// So do guides.
#[test]
fn guides_of_another_size_begin_anew() {
    for backend in all_backends() {
        let (_, _, mut renderer) = box_with_surfels(backend.as_ref());
        let guided = Settings {
            guiding: true,
            ..settings(4000)
        };
        renderer.set_settings(&guided).expect("guides");
        for side in [8, 2] {
            for _ in 0..3 {
                renderer.frame().expect("a frame");
            }
            let before = states(&mut renderer);
            assert!(before["surfel_guides"].iter().any(|&byte| byte != 0));
            let other = Settings {
                guide_side: side,
                ..guided.clone()
            };
            renderer.set_settings(&other).expect("another size");
            let mut after = states(&mut renderer);
            let guides = after.remove("surfel_guides").expect("a state");
            let words = guided.slots() as usize * guide::words(side);
            assert!(guides == vec![0; 4 * words], "{}", backend.name());
            for (key, bytes) in after {
                assert!(before[&key] == bytes, "{key} on {}", backend.name());
            }
        }
    }
}

/// Less room starts over: a slot beyond the end has no place to go.
#[test]
fn less_room_starts_over() {
    for backend in all_backends() {
        let (_, _, mut renderer) = box_with_surfels(backend.as_ref());
        let settings = Settings {
            surfels: 500,
            ..settings(4000)
        };
        renderer.set_settings(&settings).expect("less room");
        assert_eq!(live(&mut renderer), 0, "{}", backend.name());
        renderer.frame().expect("a frame");
        assert!(live(&mut renderer) > 0, "{}", backend.name());
    }
}

/// A state of a stage that extends the frame is none of the surfels' business.
#[test]
fn less_room_leaves_other_states_alone() {
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    for backend in all_backends() {
        let mut renderer = Renderer::extended(
            backend.as_ref(),
            &scene,
            &view,
            SIZE,
            &settings(1000),
            0,
            |g, _| {
                let (state, buffer) = g.state::<u32>("of_another", 3, Initial::Zero);
                g.output("of_another", &buffer);
                g.keep(state, buffer);
            },
        )
        .expect("prepares");
        renderer.frame().expect("a frame");
        let exec = renderer.executable();
        let id = exec.schedule().resource("of_another").expect("declared");
        let written = bytemuck::cast_slice(&[7u32, 8, 9]).to_vec();
        exec.upload(id, 0, &written).expect("written");
        let settings = Settings {
            surfels: 500,
            ..settings(1000)
        };
        renderer.set_settings(&settings).expect("less room");
        assert_eq!(live(&mut renderer), 0, "{}", backend.name());
        assert_eq!(
            state::<u32>(renderer.executable(), "of_another"),
            [7, 8, 9],
            "{}",
            backend.name()
        );
    }
}

/// After a reset come the frames that a new renderer would make.
#[test]
fn a_reset_starts_over() {
    for backend in all_backends() {
        let (_, _, mut renderer) = box_with_surfels(backend.as_ref());
        let (first, picture) = (
            states(&mut renderer),
            renderer.picture().expect("a picture"),
        );
        renderer.reset().expect("a reset");
        assert_eq!(renderer.gi().frames(), 0);
        assert_eq!(live(&mut renderer), 0, "{}", backend.name());
        assert!(matches!(
            renderer.picture(),
            Err(RenderError::NoFrame { .. })
        ));
        for _ in 0..6 {
            renderer.frame().expect("a frame");
        }
        assert!(states(&mut renderer) == first, "{}", backend.name());
        assert!(renderer.picture().expect("a picture") == picture);
    }
}
