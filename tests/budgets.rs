//! Budgets and capacities: held to the ray, and counted where they run out.
mod common;

use common::{all_backends, settings};
use gibs::graph::DispatchArgs;
use gibs::passes::frame::Settings;
use gibs::{Renderer, builtin};

/// The rays of a frame are exactly the budget, from none to more than the surfels asked for.
#[test]
fn rays_sum_to_the_budget() {
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    for backend in all_backends() {
        for budget in [0, 1, 999, 50_000] {
            let settings = settings(budget);
            let mut renderer =
                Renderer::new(backend.as_ref(), &scene, &view, [64, 64], &settings, 0)
                    .expect("prepares");
            for frame in 0..4 {
                renderer.frame().expect("renders");
                let exec = renderer.executable();
                let batch = exec
                    .schedule()
                    .output("rays")
                    .expect("the stage that shares rays out");
                let args: DispatchArgs =
                    bytemuck::pod_read_unaligned(&exec.read(batch).expect("reads"));
                assert_eq!(
                    args.count,
                    budget,
                    "{}: frame {frame}, budget {budget}",
                    backend.name()
                );
            }
        }
    }
}

/// With 16 slots for hundreds of births the stack runs empty; the rest is counted, and the picture stays finite.
#[test]
fn births_without_a_slot_are_counted() {
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    for backend in all_backends() {
        let settings = Settings {
            surfels: 16,
            ..settings(1_000)
        };
        let mut renderer = Renderer::new(backend.as_ref(), &scene, &view, [96, 96], &settings, 0)
            .expect("prepares");
        for _ in 0..6 {
            renderer.frame().expect("renders");
        }
        let counters = renderer.counters().expect("reads");
        assert_eq!(counters.live, 16, "{}", backend.name());
        assert!(counters.starved > 0, "{}", backend.name());
        let picture = renderer.picture().expect("a picture");
        assert!(
            picture.channels.values().flatten().all(|x| x.is_finite()),
            "{}",
            backend.name()
        );
    }
}

/// A surfel overlaps several cells; with room for one entry each, whole lists are dropped, the loss is counted, and
/// the bits are the same on every run.
#[test]
fn a_full_grid_is_counted() {
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    for backend in all_backends() {
        let settings = Settings {
            surfels: 64,
            grid_lists: 1,
            ..settings(1_000)
        };
        let run = || {
            let mut renderer =
                Renderer::new(backend.as_ref(), &scene, &view, [96, 96], &settings, 0)
                    .expect("prepares");
            for _ in 0..8 {
                renderer.frame().expect("renders");
            }
            (
                renderer.counters().expect("reads"),
                renderer.picture().expect("a picture"),
            )
        };
        let (counters, picture) = run();
        assert!(
            counters.overflow > 0,
            "{}: nothing overflowed",
            backend.name()
        );
        assert!(
            picture.channels.values().flatten().all(|x| x.is_finite()),
            "{}",
            backend.name()
        );
        let again = run();
        assert!(
            again.0 == counters && again.1 == picture,
            "{}: two runs differ",
            backend.name()
        );
    }
}
