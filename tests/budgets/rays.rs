//! Budgets of rays.
use super::*;

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
                        // Of slots that were never in use nothing is said.
                        let used =
                            read::<gibs::passes::data::SurfelCounters>(exec, id("surfel_counters"))
                                [0]
                            .used;
                        let spans = &spans[..used as usize];
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
