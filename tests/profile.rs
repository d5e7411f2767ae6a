//! What `gibs profile` counts, against what the frame itself says: on all backends.
mod common;

use common::all_backends;
use gibs::builtin;
use gibs::gi::Gi;
use gibs::graph::Backend;
use gibs::passes::frame::{Screen, Settings};
use gibs::profile::{Options, Profile, StageCost, TimedFrame, measure, savings, table};

const OPTIONS: Options = Options {
    size: [48, 32],
    runs: 2,
    frames: 2,
    warm_up: 3,
    seed: 5,
};

fn profile(backend: &dyn Backend, scene: &str, rays: u32) -> (Profile, Vec<TimedFrame>) {
    let (loaded, view) = builtin::by_name(scene).unwrap();
    let settings = Settings {
        rays,
        surfels: 4096,
        ..Settings::default()
    };
    let mut heard = 0;
    let measured = measure(backend, (scene, &loaded), &view, &settings, &OPTIONS, |p| {
        assert!(p.done > heard, "{} after {heard}", p.done);
        assert_eq!(p.of, 2 * (3 + 2 * 2));
        heard = p.done;
    });
    assert_eq!(heard, 14, "the last frame is heard of");
    measured.unwrap()
}

fn stage<'a>(profile: &'a Profile, group: &str, name: &str) -> &'a StageCost {
    let mut stages = profile.stages.iter();
    stages
        .find(|stage| stage.group == group && stage.cost.name == name)
        .unwrap_or_else(|| panic!("no {group}/{name}"))
}

#[test]
fn counts_are_those_of_the_frame() {
    let mut first: Option<Profile> = None;
    for backend in all_backends() {
        let (profile, frames) = profile(backend.as_ref(), "atrium", 2000);
        assert_eq!(profile.backend, backend.name());
        assert_eq!(frames.len(), 2, "the timed frames of the first run");

        // Every pixel has a primary ray, and every surfel's ray is traced by one of the first two batches.
        let pixels = 48 * 32;
        assert_eq!(stage(&profile, "gbuffer", "ray_trace").work.rays, pixels);
        let traced = stage(&profile, "persistent", "ray_trace");
        assert_eq!(
            traced.times, 9,
            "surfels' rays and eight times paths that go on"
        );
        let steps = |name: &str| profile.steps.iter().find(|s| s.cost.name == name).unwrap();
        let own = steps("persistent/ray_trace").work;
        assert_eq!(own.items, Some(own.rays));
        let new = steps("spawn/ray_trace").work.rays;
        let all = own.rays + new;
        assert!(new > 0 && (1900..=2000).contains(&all), "{own:?}, {new}");
        assert!(traced.work.rays > own.rays, "some paths go on");
        assert!(own.invocations >= own.rays && own.invocations < own.rays + 64);
        // A step that traces nothing has no rays; its invocations are those of its workgroups.
        let commit = steps("spawn/commit").work;
        assert_eq!((commit.rays, commit.items), (0, None));
        assert!(commit.invocations > 0);

        // Every resource is made by somebody, or by the host.
        let held: u64 = profile.steps.iter().map(|step| step.work.bytes_held).sum();
        let memory = profile.memory;
        assert_eq!(memory.total, memory.inputs + memory.kept + memory.transient);
        let unshared = memory.kept + memory.transient + memory.saved_by_sharing;
        assert!(
            held <= unshared && held > memory.kept,
            "{held} of {unshared}"
        );
        assert_eq!(
            steps("gbuffer/primary_rays").work.bytes_written,
            pixels * 32
        );

        // Stages and groups are the steps, folded.
        let all = |rows: &[StageCost]| -> (u32, u64, u64) {
            let sum = |of: fn(&StageCost) -> u64| rows.iter().map(of).sum();
            let times = rows.iter().map(|row| row.times).sum();
            (
                times,
                sum(|row| row.work.rays),
                sum(|row| row.work.bytes_read),
            )
        };
        assert_eq!(all(&profile.stages), all(&profile.steps));
        let groups: Vec<&str> = profile.groups.iter().map(|g| g.name.as_str()).collect();
        assert_eq!(
            groups,
            ["gbuffer", "persistent", "spawn", "apply", "filtering"]
        );
        assert!(profile.counters.live > 0 && profile.counters.rays > 0);

        if backend.device().timestamps {
            for step in &profile.steps {
                let is_clear = step.cost.name.starts_with("clear");
                assert!(
                    step.cost.ms.is_some() || is_clear,
                    "{} has no time",
                    step.cost.name
                );
            }
        }
        let text = table(&profile, false);
        assert!(text.contains("ray_trace x9"), "{text}");

        // What is counted does not depend on who counts: the backends give equal bits.
        let works = |p: &Profile| -> Vec<_> { p.steps.iter().map(|step| step.work).collect() };
        match &first {
            Some(first) => assert_eq!(works(first), works(&profile), "{}", profile.backend),
            None => first = Some(profile),
        }
    }
}

#[test]
fn what_is_left_out_can_be_measured() {
    for backend in all_backends() {
        let (scene, view) = builtin::by_name("cornell").unwrap();
        let settings = Settings {
            rays: 500,
            surfels: 1024,
            ..Settings::default()
        };
        let gi = Gi::new(&scene, &view, [24, 16], &settings, Screen::Traced).unwrap();
        let known = savings(&gi, &view, None, |_, _| {}).unwrap();
        let needs = gi.needs().unwrap();
        assert_eq!(known.len(), needs.len());
        for (saving, need) in known.iter().zip(&needs) {
            assert_eq!(
                (saving.need.name, saving.need.bytes),
                (need.name, need.bytes)
            );
            assert_eq!(saving.time, None);
        }
        let mut last = (0, 1);
        let on = Some((backend.as_ref(), 2));
        let measured = savings(&gi, &view, on, |done, of| last = (done, of)).unwrap();
        assert_eq!(last.0, last.1);
        for saving in &measured {
            // Where the device has no ray queries, there is nothing to measure.
            let can = saving.need.name != "ray queries" || backend.device().ray_query;
            assert_eq!(
                saving.time.is_some(),
                !saving.need.present && can,
                "{}",
                saving.need.name
            );
            let ratio = saving.time.map_or(1.0, |time| time.ratio.ratio);
            assert!(ratio.is_finite() && ratio > 0.0, "{}", saving.need.name);
        }
        let left_out = |name: &str| {
            measured
                .iter()
                .any(|s| s.need.name == name && !s.need.present)
        };
        for name in ["direct light", "sky", "textures", "cut-outs", "ray guiding"] {
            assert!(left_out(name), "the box has no {name}");
        }
    }
}
