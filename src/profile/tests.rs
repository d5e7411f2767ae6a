use super::*;
use crate::stages::stage_of;
use gibs_graph::StepTime;
use gibs_passes::shared::hash;
use std::time::Duration;

fn figure(of_runs: &[f64]) -> Figure {
    let runs: Vec<Vec<f64>> = of_runs.iter().map(|ms| vec![*ms]).collect();
    Figure::of(&runs)
}

fn profile(frame: &[f64], stages: &[(&str, &[f64])]) -> Profile {
    let cost = |name: &str, of_runs: &[f64]| Cost {
        name: name.into(),
        ms: Some(figure(of_runs)),
        share: 0.5,
    };
    let stages: Vec<StageCost> = stages
        .iter()
        .map(|(name, of_runs)| StageCost {
            group: "apply".into(),
            cost: cost(name, of_runs),
            times: 1,
            work: Work::default(),
        })
        .collect();
    Profile {
        version: "1".into(),
        scene: "cornell".into(),
        view: serde_json::json!({ "exposure": 1 }),
        backend: "cpu".into(),
        device: "a processor".into(),
        driver: "none".into(),
        notes: vec!["2 threads".into()],
        size: [4, 3],
        settings: [("rays".to_owned(), serde_json::Value::from(100))].into(),
        runs: frame.len() as u32,
        seed: 0,
        frames: 1,
        warm_up: 0,
        frame: FrameCost {
            wall_ms: figure(frame),
            timed_ms: figure(frame),
            steps_ms: Some(figure(frame)),
            tracing_ms: None,
            covered: Some(1.0),
            over_tracing: None,
            overhead: Interval {
                ratio: 1.0,
                bounds: None,
            },
        },
        memory: MemoryCost::default(),
        counters: Counters::default(),
        groups: vec![cost("apply", frame)],
        steps: stages.clone(),
        stages,
    }
}

#[test]
fn backends_stand_beside_each_other_by_stage() {
    let first = profile(
        &[8.0, 8.0],
        &[("trace", &[4.0, 4.0]), ("shade", &[2.0, 2.0])],
    );
    let mut second = profile(
        &[2.0, 2.0],
        &[("shade", &[3.0, 3.0]), ("trace", &[1.0, 1.0])],
    );
    second.backend = "vulkan".into();
    let mut untimed = first.clone();
    untimed.backend = "wgpu".into();
    untimed.frame.steps_ms = None;
    for cost in untimed.stages.iter_mut().map(|row| &mut row.cost) {
        cost.ms = None;
    }
    let text = beside(&[&first, &second, &untimed]);
    let rows: Vec<Vec<&str>> = text
        .lines()
        .map(|l| l.split_whitespace().collect())
        .collect();
    assert_eq!(rows[0][rows[0].len() - 3..], ["cpu", "vulkan", "wgpu"]);
    assert_eq!(
        rows[1],
        ["a", "frame", "8.000", "2.000", "x0.25", "8.000", "x1.00"]
    );
    assert_eq!(rows[2], ["its", "steps", "8.000", "2.000", "x0.25", "-"]);
    assert_eq!(rows[4], ["trace", "4.000", "1.000", "x0.25", "-"]);
    assert_eq!(rows[5], ["shade", "2.000", "3.000", "x1.50", "-"]);
    // One without times does not make the others' vanish.
    let text = beside(&[&untimed, &first]);
    assert!(
        text.lines()
            .any(|l| l.split_whitespace().eq(["trace", "-", "4.000"])),
        "{text}"
    );
}

#[test]
fn figures_are_medians_and_percentiles_of_all_frames() {
    let figure = Figure::of(&[vec![1.0, 2.0, 3.0], vec![4.0, 5.0, 1005.0]]);
    assert_eq!(figure.median, 3.5);
    assert_eq!(figure.of_runs, [2.0, 5.0]);
    // Rank 0.95 * 5 = 4.75 lies three quarters of the way from 5 to 1005.
    assert_eq!(figure.p95, 755.0);
    assert_eq!(Figure::of(&[]), Figure::default());
}

/// Whatever runs measure is a figure that can have been measured; medians and percentiles elsewhere are not.
#[test]
fn medians_lie_between_those_of_runs() {
    for case in 0..2000u32 {
        let random = |k| hash::unit(hash::hash2(case, k));
        let (runs, frames) = (1 + case % 5, 1 + case / 5 % 7);
        let time = |run: u32, frame: u32| match hash::hash3(case, run, frame) % 3 {
            0 => 0.5,
            power => f64::from(random(run * 8 + frame)).powi(power as i32 * 2),
        };
        let run = |run: u32| (0..frames).map(|frame| time(run, frame)).collect();
        let figure = Figure::of(&(0..runs).map(run).collect::<Vec<Vec<f64>>>());
        assert_eq!(figure.outside_its_runs(), None, "{figure:?}");
        let most = figure.of_runs.iter().copied().fold(0.0, f64::max);
        let wrong = [
            (most + 0.1, most + 0.2, "a median"),
            (figure.median, figure.median - 0.1, "a 95th percentile"),
        ];
        for (median, p95, told) in wrong {
            let of_runs = figure.of_runs.clone();
            let other = Figure {
                median,
                p95,
                of_runs,
            };
            let found = other.outside_its_runs();
            assert!(
                found.is_some_and(|text| text.starts_with(told)),
                "{other:?}"
            );
        }
    }
}

#[test]
fn intervals_hold_what_they_should() {
    let same = Interval::of_samples(&[10.0, 11.0, 12.0], &[10.0, 11.0, 12.0]);
    let [low, high] = same.bounds.unwrap();
    assert!(low < 1.0 && 1.0 < high && (low * high - 1.0).abs() < 1e-9);
    let twice = Interval::of_samples(&[20.0, 20.2, 20.4], &[10.0, 10.1, 10.2]);
    let [low, high] = twice.bounds.unwrap();
    assert!(1.9 < low && high < 2.1 && (twice.ratio - 2.0).abs() < 1e-9);
    assert_eq!(Interval::of_samples(&[1.0], &[1.0]).bounds, None);
    // Runs of pairs that agree within each and not with each other: the interval is that of three values, not of thirty.
    let runs = [0.9, 1.0, 1.1].map(|ratio: f64| vec![(ratio, 1.0); 10]);
    let of_runs = Interval::of_paired_runs(&runs);
    let own = Interval::of_pairs([(0.9, 1.0), (1.0, 1.0), (1.1, 1.0)].into_iter());
    let close = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-12;
    let ([a, b], [c, d]) = (of_runs.bounds.unwrap(), own.bounds.unwrap());
    assert!(close(of_runs.ratio, own.ratio) && close(a, c) && close(b, d));
    let two = Interval::of_paired_runs(&runs[..2]);
    assert!(two.bounds.unwrap()[1] < b, "{two:?}");
    // Pairs that always differ by as much leave no doubt, however much they vary.
    let pairs = Interval::of_pairs([(2.0, 1.0), (20.0, 10.0), (6.0, 3.0)].into_iter());
    let [low, high] = pairs.bounds.unwrap();
    assert!((low - 2.0).abs() < 1e-9 && (high - 2.0).abs() < 1e-9);
}

/// Widths worked out apart, with the t of the tables: 2.7764 of the 4.43 degrees of freedom that Welch's sample has, 3.1824 of
/// three.
#[test]
fn intervals_are_as_wide_as_worked_out_by_hand() {
    let close = |found: Interval, ratio: f64, bounds: [f64; 2]| {
        let [low, high] = found.bounds.unwrap();
        let off = |a: f64, b: f64| (a / b - 1.0).abs() > 1e-6;
        let wrong = off(found.ratio, ratio) || off(low, bounds[0]) || off(high, bounds[1]);
        assert!(!wrong, "{found:?}");
    };
    let samples = Interval::of_samples(&[20.0, 21.0, 23.0], &[10.0, 10.5, 12.0, 11.0, 10.2]);
    close(samples, 1.987252392, [1.718746932, 2.297704215]);
    let pairs = [1.02, 1.05, 0.99, 1.1].map(|ratio| (ratio, 1.0));
    let pairs = Interval::of_pairs(pairs.into_iter());
    close(pairs, 1.039212442, [0.967601115, 1.116123661]);
}

#[test]
fn repetitions_prefix_sums_and_clears_are_one_stage() {
    for (label, stage) in [
        ("persistent/ray_trace", "ray_trace"),
        ("persistent/ray_trace_8", "ray_trace"),
        ("persistent/ray_scan_blocks", "ray_scan"),
        ("persistent/grid_scan_sums", "grid_scan"),
        ("spawn/rank_apply", "rank"),
        ("apply/lighting_apply", "lighting_apply"),
        ("filtering/drift_blocks", "drift_blocks"),
        ("clear ray_radiance", "clear"),
    ] {
        assert_eq!(stage_of(label), stage, "{label}");
    }
}

#[test]
fn what_is_slower_than_the_noise_is_told() {
    let mut old = profile(
        &[10.0, 10.1, 9.9],
        &[
            ("same", &[1.0, 1.1, 0.9]),
            ("slow", &[1.0, 1.01, 0.99]),
            ("old", &[1.0; 3]),
        ],
    );
    let mut new = profile(
        &[10.1, 10.0, 9.9],
        &[
            ("same", &[1.1, 0.95, 1.0]),
            ("slow", &[1.5, 1.51, 1.49]),
            ("new", &[1.0; 3]),
        ],
    );
    let comparison = compare(&new, &old);
    assert!(comparison.differences.is_empty());
    assert_eq!(comparison.frame.verdict, Verdict::Noise);
    let verdict = |name: &str| {
        let found = comparison.stages.iter().find(|change| change.name == name);
        found.map(|change| change.verdict)
    };
    assert_eq!(verdict("apply/same"), Some(Verdict::Noise));
    assert_eq!(verdict("apply/slow"), Some(Verdict::Slower));
    assert_eq!(verdict("apply/new"), Some(Verdict::New));
    assert_eq!(verdict("apply/old"), Some(Verdict::Gone));
    let back = compare(&old, &new);
    let faster = back
        .stages
        .iter()
        .find(|change| change.name == "apply/slow");
    assert_eq!(faster.unwrap().verdict, Verdict::Faster);
    let text = comparison_table(&comparison, [3, 3]);
    assert_eq!(text.matches("SLOWER").count(), 1, "{text}");
    assert!(!text.contains("not alike"), "{text}");

    new.size = [8, 6];
    new.seed = 7;
    new.version = "2".into();
    new.notes = vec!["1 threads".into()];
    new.view["exposure"] = 2.into();
    new.settings.insert("rays".into(), 200.into());
    let told = compare(&new, &old).differences;
    assert_eq!(
        told,
        [
            "version: 1 before, 2 now",
            "backend's notes: 2 threads before, 1 threads now",
            "size: 4x3 before, 8x6 now",
            "seed: 0 before, 7 now",
            "setting rays: 100 before, 200 now",
            "view's exposure: 1 before, 2 now"
        ]
    );
    let text = comparison_table(&compare(&new, &old), [3, 3]);
    assert!(
        text.contains("not alike: view's exposure: 1 before")
            && text.contains("may be part of every ratio"),
        "{text}"
    );
    old.scene = "\u{1b}[2J".into();
    let text = comparison_table(&compare(&new, &old), [3, 3]);
    assert!(text.contains("scene: \\u{1b}[2J before"), "{text}");
    for few in [&[1.0][..], &[1.0, 1.01]] {
        let change = compare(&profile(few, &[]), &profile(&[9.0; 3], &[])).frame;
        assert_eq!(change.verdict, Verdict::Unknown);
    }
    let change = compare(&profile(&[1.0, 4.0], &[]), &profile(&[8.0; 3], &[])).frame;
    let ratio = change.ratio.unwrap().ratio;
    assert_eq!(change.before_ms.unwrap() as f32, 8.0);
    assert_eq!((change.now_ms.unwrap() as f32, ratio as f32), (2.0, 0.25));
    // Times that are next to nothing are not judged, unless they were more.
    let tiny = |ms: f64| profile(&[1.0; 3], &[("tiny", &[ms, ms * 1.001, ms * 0.999])]);
    let of_tiny = |now: &Profile, before: &Profile| {
        let all = compare(now, before).stages;
        let change = all.iter().find(|change| change.name == "apply/tiny");
        change.unwrap().verdict
    };
    for (before, verdict) in [(0.001, Verdict::TooShort), (0.02, Verdict::Faster)] {
        assert_eq!(of_tiny(&tiny(0.009), &tiny(before)), verdict);
    }
    // Of what took nothing in a run there is no ratio, whatever the others say.
    let some = |of_runs: &[f64]| profile(&[1.0; 3], &[("tiny", of_runs)]);
    for (now, before) in [
        (some(&[5.0; 3]), some(&[0.0; 3])),
        (some(&[0.0; 3]), some(&[5.0; 3])),
        (some(&[9.0; 5]), some(&[0.0, 0.0, 0.5, 0.5, 0.5])),
    ] {
        assert_eq!(of_tiny(&now, &before), Verdict::Nothing);
    }
    let all = compare(&some(&[1.0; 3]), &some(&[0.0, 0.0, 500.0])).stages;
    let change = all
        .iter()
        .find(|change| change.name == "apply/tiny")
        .unwrap();
    assert_eq!((change.before_ms, change.ratio), (Some(0.0), None));
    // Of what a device has not timed nothing is known, however long it takes.
    let mut untimed = tiny(0.5);
    untimed.stages[0].cost.ms = None;
    for (now, before) in [(&untimed, &tiny(0.5)), (&tiny(0.001), &untimed)] {
        assert_eq!(of_tiny(now, before), Verdict::NotTimed);
    }
}

#[test]
fn a_profile_survives_its_file() {
    let path = std::env::temp_dir().join(format!("gibs-profile-{}.json", std::process::id()));
    let written = vec![profile(&[1.5, 2.5], &[("stage", &[0.1, 0.2])])];
    let file = serde_json::json!({ "gibs_profile": FORMAT, "profiles": written });
    std::fs::write(&path, file.to_string()).unwrap();
    assert_eq!(Profile::read(&path).unwrap(), written);

    let wrong = |text: &str| {
        std::fs::write(&path, text).unwrap();
        Profile::read(&path).unwrap_err().to_string()
    };
    for text in ["", "{}", "[]", "{\"gibs_profile\": 1}", "[1"] {
        let message = wrong(text);
        assert!(message.contains("gibs profile SCENE --json"), "{message}");
        assert!(message.contains(&path.display().to_string()), "{message}");
    }
    let message = wrong("{\"gibs_profile\": 99}");
    assert!(message.contains("99"), "{message}");
    std::fs::remove_file(&path).unwrap();
    let message = Profile::read(&path).unwrap_err().to_string();
    assert!(message.contains("cannot be read"), "{message}");
}

/// Slices of a track of a trace either follow each other or lie within one another, which viewers insist on.
#[test]
fn slices_of_a_trace_do_not_cross() {
    let schedule = crate::Gi::new(
        &crate::builtin::by_name("cornell").unwrap().0,
        &crate::builtin::by_name("cornell").unwrap().1,
        [16, 8],
        &Default::default(),
        gibs_passes::frame::Screen::Traced,
    );
    let schedule = schedule.unwrap().schedule().clone();
    let steps = (0..schedule.steps.len()).map(|step| StepTime {
        step,
        start: Duration::from_micros(10 * step as u64),
        time: Duration::from_micros(9),
    });
    let wall = Duration::from_micros(10 * schedule.steps.len() as u64);
    let frames: Vec<TimedFrame> = (0..2)
        .map(|frame| TimedFrame {
            start: wall * frame,
            wall,
            steps: steps.clone().collect(),
        })
        .collect();
    let text = chrome_trace(&[("cpu", &schedule, &frames), ("vulkan", &schedule, &frames)]);
    let trace: serde_json::Value = serde_json::from_str(&text).unwrap();
    let events = trace["traceEvents"].as_array().unwrap();
    let of = |process: u64, thread: u64| -> Vec<(f64, f64)> {
        let slices = events.iter().filter(|e| e["ph"] == "X");
        let own = slices.filter(|e| e["pid"] == process && e["tid"] == thread);
        own.map(|e| (e["ts"].as_f64().unwrap(), e["dur"].as_f64().unwrap()))
            .collect()
    };
    for process in [1, 2] {
        assert_eq!(of(process, 1).len(), 2, "frames");
        assert!(of(process, 2).len() >= 10, "groups");
        assert_eq!(of(process, 3).len(), 2 * schedule.steps.len(), "steps");
        for thread in [1, 2, 3] {
            let slices = of(process, thread);
            let apart = slices.windows(2).all(|w| w[0].0 + w[0].1 <= w[1].0 + 1e-6);
            assert!(apart, "track {thread}");
        }
    }
    let named = events.iter().filter(|e| e["ph"] == "M").count();
    assert_eq!(named, 8, "each process and track has a name");
}
