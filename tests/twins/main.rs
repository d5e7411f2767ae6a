//! Every function of `shaders/modules` has a twin in Rust. Here each is run in both languages over many inputs, ordinary ones and
//! edges, on every GPU backend that the machine has, and held to the bound that it names: equality to the bit on devices that
//! round `+ - * / sqrt` correctly. `cargo run --release --example twin_ulps` makes the table of `docs/twins.md` of the same.
#![cfg(feature = "cpu")]
#[path = "../common/mod.rs"]
mod common;
#[allow(dead_code, reason = "the tables are for the example")]
mod suite;

use gibs::graph::Backend;
use std::collections::{BTreeMap, BTreeSet, HashSet};
use suite::declare::{Twin, floats};
use suite::{families, listing, run};

/// The GPU backends that the machine has, and whether their devices round correctly. Mesa's software driver does; if it no longer
/// did, equality to the bit would no longer be tested anywhere.
fn devices(oracle: &dyn Backend) -> Vec<(Box<dyn Backend>, bool)> {
    let backends = common::all_backends().into_iter();
    let gpus = backends.filter(|backend| backend.name() != "cpu");
    gpus.map(|backend| {
        let rounds = run::rounds(backend.as_ref(), oracle);
        let device = backend.device();
        assert!(
            rounds || device.kind != "software",
            "{} on {} does not round correctly",
            backend.name(),
            device.name
        );
        (backend, rounds)
    })
    .collect()
}

/// What is wrong with a twin on the devices.
fn faults(twin: &Twin, oracle: &dyn Backend, devices: &[(Box<dyn Backend>, bool)]) -> Vec<String> {
    let cases = run::cases(twin);
    let expected = run::run(twin, oracle, &cases);
    let mut faults = Vec::new();
    let results: HashSet<&[u32]> = expected.chunks(floats(&twin.out).len()).collect();
    if twin.cases > 64 && expected.len() > 4 && results.len() < 2 {
        faults.push(format!("{}: all inputs give the same result", twin.name));
    }
    for (backend, rounds) in devices {
        let got = run::run(twin, backend.as_ref(), &cases);
        let name = format!("{} on {}", twin.name, backend.name());
        let found = run::compare(twin, &cases, &expected, &got);
        if !found.fits(&twin.bound, *rounds) {
            faults.push(format!(
                "{name}: {} results differ, by up to {} ULP and in {} words: {}",
                found.differ,
                found.steps,
                found.words,
                found.example(twin)
            ));
        }
        if let Some(truth) = &twin.truth {
            for (what, error) in truth
                .what
                .iter()
                .zip(run::errors(truth, twin, &cases, &got))
            {
                if *rounds && error > truth.most {
                    faults.push(format!("{name}: {what} is off by {error:.2} ULP"));
                }
            }
        }
    }
    faults
}

fn agree(family: &str) {
    let oracle = common::cpu();
    let devices = devices(oracle.as_ref());
    let families = families();
    let (_, twins) = families
        .iter()
        .find(|(name, _)| *name == family)
        .expect("a family");
    let faults: Vec<_> = twins
        .iter()
        .flat_map(|t| faults(t, oracle.as_ref(), &devices))
        .collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

macro_rules! families_agree {
    ($($name:ident),* $(,)?) => {
        $(#[test]
        fn $name() {
            agree(stringify!($name));
        })*

        #[test]
        fn every_family_is_run() {
            let families = families();
            let names: Vec<_> = families.iter().map(|(name, _)| *name).collect();
            assert_eq!(names, [$(stringify!($name)),*]);
        }
    };
}

families_agree!(
    numbers, directions, grid, estimator, surfels, guides, gather, light, surfaces, pixels, trace,
    lanes,
);

/// The comparison finds what is wrong: a last place that differs now and then, a threshold that lies on the other side, a result
/// that is not a number; and it says for which input.
#[test]
fn what_differs_is_found() {
    let oracle = common::cpu();
    let devices = devices(oracle.as_ref());
    for twin in suite::wrong::all() {
        let faults = faults(&twin, oracle.as_ref(), &devices);
        let judged = devices
            .iter()
            .filter(|(_, rounds)| *rounds || twin.bound.elsewhere.is_some());
        assert_eq!(faults.len(), judged.count(), "{}: {faults:?}", twin.name);
        let expected = match twin.name {
            "last_place" => "by up to 1 ULP and in 0 words: of [",
            "threshold" => "by up to 0 ULP and in ",
            _ => "by up to 4294967295 ULP and in 0 words: of [",
        };
        for fault in faults {
            assert!(fault.contains(expected), "{fault}");
        }
    }
}

/// The page with the table names every function, and each part beside what stands for it.
#[test]
fn the_page_names_every_function() {
    let page = include_str!("../../docs/twins.md");
    for (part, of) in suite::listing::PARTS {
        let row = format!("| `{part}` | `{of}` |");
        assert!(page.contains(&row), "no row {row}: make the page anew");
    }
    for (_, twins) in families() {
        for name in twins.iter().flat_map(|twin| twin.of) {
            let named = format!("`{name}`");
            assert!(page.contains(&named), "no {named}: make the page anew");
        }
    }
}

#[test]
fn steps_are_counted_across_zero() {
    let steps = |a: f32, b: f32| run::steps(a.to_bits(), b.to_bits());
    let least = f32::from_bits(1);
    assert_eq!(steps(1.0, 1.0), 0);
    assert_eq!(steps(0.0, -0.0), 0);
    assert_eq!(steps(least, -least), 2);
    assert_eq!(steps(1.0, 1.0f32.next_down()), 1);
    assert_eq!(steps(f32::MAX, f32::INFINITY), 1);
    assert_eq!(steps(f32::NAN, -f32::NAN), 0);
    assert!(steps(f32::NAN, f32::INFINITY) > 1 << 31);
}

/// Every function has a twin here, or is a part of one that has.
#[test]
fn no_function_is_left_out() {
    let functions = listing::functions();
    assert!(functions.len() > 150, "{functions:?}");
    let families = families();
    let twins = families.iter().flat_map(|(_, twins)| twins);
    let tested: BTreeSet<&str> = twins.flat_map(|twin| twin.of).copied().collect();
    let parts: BTreeMap<&str, &str> = listing::PARTS.iter().copied().collect();
    for function in &functions {
        let function = function.as_str();
        assert!(
            tested.contains(function) || parts.contains_key(function),
            "{function} has no twin test: declare one in tests/twins/suite, or list it as a part in listing.rs"
        );
    }
    for name in tested.iter().chain(parts.keys()) {
        assert!(functions.contains(*name), "{name} is in no module");
    }
    for (part, through) in &parts {
        assert!(
            !tested.contains(part),
            "{part} is no mere part: it is tested"
        );
        assert!(
            tested.contains(through),
            "{part} is tested through {through}, which is not"
        );
    }
}
