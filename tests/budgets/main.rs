//! Budgets and capacities: held to the ray, and counted where they run out.
#[path = "../common/mod.rs"]
mod common;
mod rays;
mod room;

use common::{all_backends, mean, settings};
use gibs::graph::{DispatchArgs, Executable, ResourceId};
use gibs::passes::data::{Hit, SurfelIrradiance, SurfelPose};
use gibs::passes::frame::{Screen, Settings};
use gibs::passes::scene::{Camera, Environment};
use gibs::{Gi, Renderer, builtin};
use glam::{DVec3, UVec2, Vec3};

fn state<T: bytemuck::Pod>(renderer: &mut Renderer, key: &str) -> Vec<T> {
    let exec = renderer.executable();
    let id = exec.schedule().resource(key).expect("a state");
    bytemuck::pod_collect_to_vec(&exec.read(id).expect("readable"))
}

fn is_finite(renderer: &mut Renderer) -> bool {
    let picture = renderer.picture().expect("a picture");
    picture.channels.values().flatten().all(|x| x.is_finite())
}

/// What a resource holds.
fn read<T: bytemuck::Pod>(exec: &mut dyn Executable, resource: ResourceId) -> Vec<T> {
    bytemuck::pod_collect_to_vec(&exec.read(resource).expect("reads"))
}

/// A camera that looks away from everything sees the sky, with surfels left over or without any.
#[test]
fn a_view_of_the_sky_alone_needs_no_surfel() {
    let (scene, mut view) = builtin::by_name("cornell").expect("built in");
    view.environment = Environment::Constant(Vec3::new(0.25, 0.5, 1.0));
    let there = view.camera;
    let away = Camera {
        target: there.position - (there.target - there.position),
        ..there
    };
    for backend in all_backends() {
        for surfels in [0, 64] {
            let settings = Settings {
                surfels,
                check_slots: true,
                ..settings(500)
            };
            let mut renderer =
                Renderer::new(backend.as_ref(), &scene, &view, [32, 32], &settings, 0)
                    .expect("prepares");
            for camera in [away, there, away] {
                renderer.set_camera(camera);
                for _ in 0..3 {
                    renderer.frame().expect("renders");
                }
                let counters = renderer.counters().expect("reads");
                assert_eq!(counters.slot_errors, Some(0), "{}", backend.name());
                assert!(is_finite(&mut renderer), "{}", backend.name());
            }
            let picture = renderer.picture().expect("a picture");
            let mask = picture.scalar("mask.A").expect("a mask");
            assert!(
                mask.iter().all(|m| *m == 0.0),
                "{}: sky alone",
                backend.name()
            );
            let blue = picture.rgb("").expect("the picture")[2];
            assert!(blue.iter().all(|x| *x == 1.0), "{}", backend.name());
        }
    }
}

/// A cut every frame, near and far, into walls and out of the scene: 200 of them leave every number finite, every slot in
/// its place, and count what did not fit.
#[test]
fn a_cut_every_frame_leaves_everything_sound() {
    let (scene, view) = builtin::by_name("atrium").expect("built in");
    let settings = Settings {
        surfels: 50,
        grid_lists: 2,
        check_slots: true,
        ..settings(500)
    };
    let mut ends = Vec::new();
    for backend in all_backends() {
        let mut renderer = Renderer::new(backend.as_ref(), &scene, &view, [40, 24], &settings, 0)
            .expect("prepares");
        let (mut most, mut overflow) = (0, 0_u64);
        for frame in 0..200 {
            // Multiples of the golden ratio and its powers: everywhere, and never the same place twice.
            let at = |step: f64| (f64::from(frame) * step).fract() * 2.0 - 1.0;
            let position = DVec3::new(
                14.0 * at(0.618_034),
                6.0 + 7.0 * at(0.381_966),
                9.0 * at(0.236_068),
            );
            let turn = f64::from(frame) * 2.4;
            renderer.set_camera(Camera {
                position,
                target: position + DVec3::new(turn.cos(), 0.3 * at(0.145_898), turn.sin()),
                ..view.camera
            });
            renderer.frame().expect("renders");
            let counters = renderer.counters().expect("reads");
            let place = format!("{}: frame {frame}: {counters:?}", backend.name());
            assert_eq!(counters.slot_errors, Some(0), "{place}");
            assert!(counters.live <= 50 && counters.rays <= 500, "{place}");
            assert_eq!(counters.live, counters.born - counters.recycled, "{place}");
            most = most.max(counters.live);
            overflow += u64::from(counters.overflow);
            if frame % 20 == 0 {
                assert!(is_finite(&mut renderer), "{place}");
            }
        }
        let counters = renderer.counters().expect("reads");
        println!("{}: {counters:?}, at most {most} live", backend.name());
        assert!(
            counters.recycled > 500,
            "{}: slots come back",
            backend.name()
        );
        assert!(counters.starved > 0 && overflow > 0, "{}", backend.name());
        ends.push(counters);
    }
    assert!(ends.windows(2).all(|pair| pair[0] == pair[1]), "{ends:?}");
}
