//! Random graphs of small stages on every backend of this machine.
use crate::graph_cases::{Recipe, recipes, record};
use crate::watch::cases;
use gibs::check::{Case, CheckOptions, Participant, Upload, Verdict, check};
use gibs::shaders::Compiler;
use gibs_backend_cpu::{CpuBackend, Options};
use gibs_graph::{Backend, Executable, Kind, Schedule};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

const FRAMES: u32 = 3;

/// The CPU's kernels in their three ways, and all other backends that the machine has.
fn backends() -> Vec<(&'static str, Box<dyn Backend>)> {
    let cpu = |scalar, checked| -> Box<dyn Backend> {
        Box::new(
            CpuBackend::new(Options {
                scalar,
                checked,
                ..Options::default()
            })
            .expect("threads start"),
        )
    };
    let mut found = vec![
        ("cpu-scalar", cpu(true, false)),
        ("cpu", cpu(false, false)),
        ("cpu-checked", cpu(false, true)),
    ];
    for backend in crate::common::all_backends() {
        match backend.name() {
            "vulkan" => found.push(("vulkan", backend)),
            "wgpu" => found.push(("wgpu", backend)),
            _ => {}
        }
    }
    found
}

fn compiled(recipe: &Recipe, compiler: &Compiler, apart: bool) -> Arc<Schedule> {
    let mut graph = record(recipe);
    if apart {
        graph.keep_transients();
    }
    Arc::new(
        graph
            .compile(Some(compiler))
            .unwrap_or_else(|e| panic!("{e}")),
    )
}

/// What the host writes before a frame: numbers of any size, of which some are small.
fn uploads(schedule: &Schedule, seed: u32, frame: u32) -> Vec<Upload> {
    let inputs = (0..)
        .zip(&schedule.resources)
        .filter(|(_, resource)| resource.kind == Kind::Input);
    inputs
        .map(|(resource, found)| {
            let word = |i: u64| {
                let mut x =
                    seed ^ frame.wrapping_mul(0x9e37_79b9) ^ (i as u32).wrapping_mul(0x85eb_ca6b);
                x = (x ^ x >> 15).wrapping_mul(0x2c1b_3c6d);
                if i.is_multiple_of(3) { x % 300 } else { x }
            };
            let bytes = (0..found.bytes / 4)
                .flat_map(|i| word(i).to_ne_bytes())
                .collect();
            Upload {
                resource,
                offset: 0,
                bytes,
            }
        })
        .collect()
}

/// In lockstep: every step of every frame gives the same bits everywhere, and nothing was left out of the comparison.
fn lockstep(recipe: &Recipe, compiler: &Compiler, participants: &[Participant<'_>]) -> u64 {
    let schedule = compiled(recipe, compiler, true);
    let fed = schedule.clone();
    let feed = |frame| Ok(uploads(&fed, recipe.seed, frame));
    let mut cases = [Case::new("fuzz", schedule.clone(), 0..FRAMES, feed)];
    let checked = check(
        &mut cases,
        participants,
        &CheckOptions::default(),
        |_, _, _| {},
    );
    let report = checked.unwrap_or_else(|e| panic!("{e}")).report;
    for (_, step, port, pair) in report.pairs() {
        assert_eq!(
            pair.verdict,
            Verdict::Equal,
            "{} {}: {pair:?}",
            step.label,
            port.port
        );
    }
    let gaps = report.gaps(&cases, participants);
    assert!(gaps.is_empty(), "{gaps:?}");
    report.elements()
}

/// What a backend has after each frame that it ran on its own.
fn frames(
    recipe: &Recipe,
    schedule: &Arc<Schedule>,
    name: &str,
    backend: &dyn Backend,
) -> Vec<BTreeMap<String, Vec<u8>>> {
    let fail = |e: gibs_graph::BackendError| -> ! { panic!("{name}: {e}") };
    let mut exec = backend
        .prepare(schedule.clone())
        .unwrap_or_else(|e| fail(e));
    let frame = |frame: u32, exec: &mut dyn Executable| -> Result<_, gibs_graph::BackendError> {
        for upload in uploads(schedule, recipe.seed, frame) {
            exec.upload(upload.resource, upload.offset, &upload.bytes)?;
        }
        exec.run()?;
        exec.wait()?;
        let read = schedule
            .outputs
            .iter()
            .map(|output| Ok((output.name.clone(), exec.read(output.resource)?)));
        read.collect()
    };
    (0..FRAMES)
        .map(|n| frame(n, exec.as_mut()).unwrap_or_else(|e| fail(e)))
        .collect()
}

/// Whole frames, in which transients share memory and only barriers keep steps apart, end alike everywhere.
fn on_their_own(recipe: &Recipe, compiler: &Compiler, backends: &[(&str, Box<dyn Backend>)]) {
    let schedule = compiled(recipe, compiler, false);
    let of = |(name, backend): &(&str, Box<dyn Backend>)| {
        frames(recipe, &schedule, name, backend.as_ref())
    };
    let expected = of(&backends[0]);
    for backend in &backends[1..] {
        for (frame, (expected, found)) in expected.iter().zip(of(backend)).enumerate() {
            for (name, bytes) in expected {
                assert_eq!(
                    bytes, &found[name],
                    "`{name}` after frame {frame} on {}",
                    backend.0
                );
            }
        }
    }
}

#[test]
fn random_graphs_agree_on_every_backend() {
    let backends = backends();
    // The kit takes the CPU's wide kernels once: as they are, or with their writes checked and in another order.
    let participants = |but: &str| -> Vec<Participant<'_>> {
        let taken = backends.iter().filter(|(name, _)| *name != but);
        taken
            .map(|(name, backend)| Participant::named(name, backend.as_ref()))
            .collect()
    };
    let ways = [participants("cpu"), participants("cpu-checked")];
    let compiler = Compiler::new();
    let elements = AtomicU64::new(0);
    let mut runner = TestRunner::new(cases(200));
    let ran = runner.run(&recipes(), |recipe| {
        elements.fetch_add(
            lockstep(&recipe, &compiler, &ways[recipe.seed as usize % 2]),
            Relaxed,
        );
        on_their_own(&recipe, &compiler, &backends);
        Ok(())
    });
    if let Err(error) = ran {
        panic!("{error}");
    }
    println!(
        "{} participants, {} elements",
        backends.len(),
        elements.into_inner()
    );
}

/// The graphs are not trivial: together they have every kind of step.
#[test]
fn random_graphs_use_every_stage_and_kind() {
    let compiler = Compiler::new();
    let mut stages = std::collections::BTreeSet::new();
    let mut kinds = std::collections::BTreeSet::new();
    let mut runner = TestRunner::deterministic();
    for _ in 0..60 {
        let recipe = recipes().new_tree(&mut runner).expect("a recipe").current();
        let schedule = compiled(&recipe, &compiler, false);
        stages.extend(schedule.dispatches().map(|(.., dispatch)| dispatch.stage));
        kinds.extend(
            schedule
                .resources
                .iter()
                .map(|resource| format!("{:?}", resource.kind)),
        );
        if schedule.shared_bytes() > 0 {
            kinds.insert("shared".into());
        }
        if schedule
            .steps
            .iter()
            .any(|step| matches!(step.action, gibs_graph::Action::Clear(_)))
        {
            kinds.insert("clear".into());
        }
    }
    assert_eq!(stages.len(), 14, "{stages:?}");
    assert_eq!(kinds.len(), 8, "{kinds:?}");
}
