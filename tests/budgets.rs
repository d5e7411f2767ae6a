//! Budgets and capacities: held to the ray, and counted where they run out.
mod common;

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

/// Counted, binned and traced are as many rays as the budget has: those of the surfels, the counts of the bins, the batches that
/// are traced, places that are each taken once, and hits.
#[test]
fn as_many_rays_are_binned_and_traced_as_were_counted() {
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    for backend in all_backends() {
        for budget in [0_u32, 1, 999, 50_000] {
            let settings = Settings {
                sorting: true,
                ..settings(budget)
            };
            let size = [64, 64];
            let mut renderer = Renderer::new(backend.as_ref(), &scene, &view, size, &settings, 0)
                .expect("prepares");
            renderer.frame().expect("renders");
            let exec = renderer.executable();
            let schedule = exec.schedule().clone();
            let id = |key: &str| schedule.resource(key).expect("a resource");
            let hits = id("persistent_hits");
            let unwritten = vec![0xff; schedule.resources[hits as usize].bytes as usize];
            let mut checked = 0;
            exec.rotate().expect("rotates");
            for (index, step) in schedule.steps.iter().enumerate() {
                if step.label == "persistent/ray_trace" {
                    exec.upload(hits, 0, &unwritten).expect("uploads");
                }
                exec.run_step(index).expect("runs");
                let place = format!("{}, budget {budget}", backend.name());
                match step.label.as_str() {
                    "persistent/ray_sorting_order" | "spawn/ray_sorting_order" => {
                        let spans: Vec<UVec2> = read(exec, id("ray_spans"));
                        let counted = spans.iter().map(|span| span.y).sum::<u32>();
                        let [old, new] = ["persistent_batch", "spawned_batch"]
                            .map(|key| read::<DispatchArgs>(exec, id(key))[0]);
                        assert_eq!(counted, budget, "{place}: counted");
                        assert_eq!(old.count + new.count, budget, "{place}: to trace");
                        assert_eq!((old.first, new.first), (0, old.count), "{place}");
                        let (name, count) = match step.label.starts_with("spawn") {
                            true => ("spawn_ray_bin_counts", new.count),
                            false => ("persistent_ray_bin_counts", old.count),
                        };
                        let bins: Vec<u32> = read(exec, id(name));
                        assert_eq!(bins.iter().sum::<u32>(), count, "{place}: binned");
                    }
                    "spawn/ray_sorting_reorder" => {
                        let mut places: Vec<u32> = read(exec, id("ray_places"));
                        places.truncate(budget as usize);
                        places.sort_unstable();
                        assert!(places.into_iter().eq(0..budget), "{place}: places");
                    }
                    "spawn/ray_trace" => {
                        let found: Vec<Hit> = read(exec, hits);
                        let traced = found.iter().filter(|hit| !hit.t.is_nan()).count();
                        assert_eq!(traced, budget as usize, "{place}: traced");
                        checked += 1;
                    }
                    _ => {}
                }
            }
            assert_eq!(checked, 1, "new surfels have a trace of their own");
        }
    }
}

/// What a resource holds.
fn read<T: bytemuck::Pod>(exec: &mut dyn Executable, resource: ResourceId) -> Vec<T> {
    bytemuck::pod_collect_to_vec(&exec.read(resource).expect("reads"))
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

/// With one ray a frame there is exactly one, and every surfel gets its turn: slots are few, so that all are soon in use,
/// and requests differ by at most 128 to one.
#[test]
fn one_ray_goes_around() {
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    for backend in all_backends() {
        let settings = Settings {
            surfels: 24,
            check_slots: true,
            ..settings(1)
        };
        let mut renderer = Renderer::new(backend.as_ref(), &scene, &view, [32, 32], &settings, 0)
            .expect("prepares");
        for frame in 0..160 {
            renderer.frame().expect("renders");
            let counters = renderer.counters().expect("reads");
            assert_eq!(counters.rays, 1, "{}: frame {frame}", backend.name());
            assert_eq!(
                counters.slot_errors,
                Some(0),
                "{}: frame {frame}",
                backend.name()
            );
        }
        let poses: Vec<SurfelPose> = state(&mut renderer, "surfel_poses");
        let irradiance: Vec<SurfelIrradiance> = state(&mut renderer, "surfel_irradiance");
        let samples: Vec<u32> = poses
            .iter()
            .zip(&irradiance)
            .filter(|(pose, _)| pose.radius > 0.0)
            .map(|(_, irradiance)| irradiance.samples)
            .collect();
        assert_eq!(samples.len(), 24, "{}", backend.name());
        assert!(
            samples.iter().all(|&samples| samples > 0),
            "{}: rays of each surfel: {samples:?}",
            backend.name()
        );
        assert!(is_finite(&mut renderer), "{}", backend.name());
    }
}

/// Without surfels the picture is direct light and what the lamp shows; births are counted as starved, and none happens.
/// Going back to some finds the frame as it was.
#[test]
fn no_surfels_is_direct_light_only() {
    let (scene, view) = builtin::by_name("atrium").expect("built in");
    for backend in all_backends() {
        for half_resolution in [true, false] {
            let none = Settings {
                surfels: 0,
                check_slots: true,
                guiding: true,
                half_resolution,
                hit_births: 16,
                ..settings(1_000)
            };
            let mut renderer = Renderer::new(backend.as_ref(), &scene, &view, [48, 32], &none, 0)
                .unwrap_or_else(|e| panic!("{}: {e}", backend.name()));
            for _ in 0..3 {
                renderer.frame().expect("renders");
            }
            let counters = renderer.counters().expect("reads");
            let name = backend.name();
            assert_eq!((counters.live, counters.born), (0, 0), "{name}");
            assert!(counters.starved > 0, "{name}");
            assert_eq!(
                (counters.rays, counters.slot_errors),
                (0, Some(0)),
                "{name}"
            );
            let picture = renderer.picture().expect("a picture");
            let irradiance = picture.rgb("E").expect("E");
            assert!(
                irradiance.iter().all(|c| c.iter().all(|x| *x == 0.0)),
                "{name}"
            );
            assert!(mean(&picture, "direct") > 0.1, "{name}: the sun shines");
            assert!(is_finite(&mut renderer), "{name}");
            let some = Settings {
                surfels: 256,
                ..none.clone()
            };
            for settings in [&some, &none] {
                renderer.set_settings(settings).expect("other settings");
                for _ in 0..2 {
                    renderer.frame().expect("renders");
                }
                let counters = renderer.counters().expect("reads");
                assert_eq!(
                    counters.live > 0,
                    settings.surfels > 0,
                    "{name}: {counters:?}"
                );
                assert_eq!(counters.slot_errors, Some(0), "{name}");
            }
        }
    }
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

/// What a surfel of capacity takes from frame to frame, with everything switched on: the budget of 256 bytes, where depth functions
/// and guides have the default sizes, and as many more as wider ones have texels. While a frame runs, there are lists of the grid,
/// and what stages hand on; a grid of fixed size and what belongs to rays do not grow with the capacity.
#[test]
fn a_surfel_takes_at_most_256_bytes_and_160_within_a_frame() {
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    let states = |surfels: u32, guiding: bool, side: Option<u32>| -> (u64, u64) {
        let usual = Settings::default();
        let settings = Settings {
            surfels,
            guiding,
            depth_side: side.unwrap_or(usual.depth_side),
            guide_side: side.unwrap_or(usual.guide_side),
            rays: 1000,
            grid_side: 40,
            ..usual
        };
        let gi = Gi::new(&scene, &view, [64, 64], &settings, Screen::Traced).expect("compiles");
        let schedule = gi.schedule();
        let kept = schedule.resources.iter().filter(|r| r.kind.persists());
        let kept = kept.map(|r| r.bytes * r.kind.allocations()).sum();
        (kept, schedule.bytes(false))
    };
    // Inputs persist as well, but do not grow with the capacity.
    let wide = 256 + (8 * 8 - 4 * 4) * 4 + (8 * 8 - 6 * 6);
    for (guiding, side, expected) in [(true, None, 256), (false, None, 216), (true, Some(8), wide)]
    {
        const MORE: u64 = 65_536;
        let (few, many) = (
            states(65_536, guiding, side),
            states(131_072, guiding, side),
        );
        let kept = (many.0 - few.0) / MORE;
        assert_eq!(kept, expected, "guiding {guiding}");
        let within_a_frame = (many.1 - few.1) / MORE - kept;
        assert_eq!(within_a_frame, 160, "guiding {guiding}");
    }
}
