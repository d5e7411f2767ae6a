//! What passes: every stage on every backend, on all built-in scenes.
use crate::common::{all_backends, cpu};
use gibs::builtin;
use gibs::check::{CheckOptions, Participant, Plan, Verdict, cases, check};
use gibs::passes::stages;
use gibs_backend_cpu::{CpuBackend, Options};
use std::collections::BTreeSet;

/// Scalar, wide and checked kernels and all devices, the device under its validation layer: no difference, nothing that
/// was not looked at, and no stage that no case runs.
#[test]
fn every_stage_agrees_on_every_backend() {
    let scalar = CpuBackend::new(Options {
        scalar: true,
        ..Options::default()
    })
    .expect("threads start");
    let checked = CpuBackend::new(Options {
        checked: true,
        scalar: true,
        threads: Some(3),
    })
    .expect("threads start");
    let backends = all_backends();
    let mut participants = vec![
        Participant::named("cpu-scalar", &scalar),
        Participant::named("cpu-checked", &checked),
    ];
    participants.extend(
        backends
            .iter()
            .map(|backend| Participant::new(backend.as_ref())),
    );
    let scenes: Vec<_> = builtin::names()
        .iter()
        .map(|(name, _)| (*name, builtin::by_name(name).expect("built in")))
        .collect();
    let scenes: Vec<_> = scenes.iter().map(|(name, scene)| (*name, scene)).collect();
    let mut cases = cases(&scenes, &Plan::default(), cpu().as_ref()).expect("frames");
    let checked = check(
        &mut cases,
        &participants,
        &CheckOptions::default(),
        |_, _, _| {},
    );
    let report = checked.expect("every backend runs").report;
    let gaps = report.gaps(&cases, &participants);
    assert!(gaps.is_empty(), "{gaps:?}");
    for (case, step, port, pair) in report.pairs() {
        assert!(
            pair.verdict < Verdict::Expected,
            "{}, {} {}: {pair:?}",
            case.name,
            step.label,
            port.port
        );
        if pair.verdict != Verdict::Equal {
            println!("{}, {} {}: {pair:?}", case.name, step.label, port.port);
        }
    }
    let run: BTreeSet<&str> = report
        .cases
        .iter()
        .flat_map(|case| case.steps.iter().map(|step| step.stage.as_str()))
        .collect();
    for stage in stages::all() {
        assert!(run.contains(stage.name), "no case runs {}", stage.name);
    }
}
