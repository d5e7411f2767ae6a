//! A sample of the mutants that `examples/mutation.rs` makes: the checks find what is wrong with a kernel.
#[path = "../common/mod.rs"]
mod common;
mod equivalent;
mod generate;
mod run;
#[allow(dead_code, reason = "the twin tests use the rest")]
#[path = "../twins/suite/mod.rs"]
mod suite;
mod twins;

use generate::Kernel;
use run::{Fate, sample, targets};
use twins::Twins;

/// Mutants of the sample, over all kernels that two scenes run; with at least two of each kernel, about 150.
const SAMPLE: usize = 60;

/// Unchanged kernels agree in the form that mutants have, and the checks find as many mutants as in the long run, but for what a
/// sample of this size varies by: of 95.7 % (docs/checking.md), three standard deviations of 160 draws are 4.8 %. The aim, 95 %,
/// is judged by the long run.
#[test]
fn mutants_are_caught() {
    let oracle = common::cpu();
    let Some(device) = common::all_backends()
        .into_iter()
        .find(|b| b.name() == "vulkan")
    else {
        println!("not run: mutants run on the vulkan backend");
        return;
    };
    let targets = targets(oracle.as_ref(), &["atrium", "cornell"]).expect("captures");
    let twins = Twins::new(oracle.as_ref()).expect("twins");
    let (mut caught, mut survived) = (0, 0);
    for &(i, index) in &sample(&targets, SAMPLE) {
        let (what, fate) = targets[i].run(index, &twins, device.as_ref());
        match fate {
            Fate::Stillborn | Fate::Equivalent => {}
            Fate::Caught | Fate::CaughtByTwins => caught += 1,
            Fate::Survived => {
                survived += 1;
                println!("survived: {}: {what}", targets[i]);
            }
            Fate::WronglyListed => panic!(
                "{}: {what}: is caught, and listed as equivalent",
                targets[i]
            ),
        }
    }
    let all = caught + survived;
    println!("{caught} of {all} caught");
    assert!(all > SAMPLE / 2, "most changes give a valid kernel");
    assert!(caught * 100 >= all * 91, "{survived} of {all} survived");
    for target in targets.iter().step_by(7) {
        let original = target.kernel.original().expect("a valid kernel");
        let same = target.differs(&original, device.as_ref());
        assert_eq!(same, Ok(()), "{target}, unchanged");
    }
}

/// Each kind of change is made, and no other thing is changed.
#[test]
fn changes_are_what_they_say() {
    let source = "@group(0) @binding(0) var<storage, read_write> data: array<u32>;
var<workgroup> shared_: array<u32, 64>;
@compute @workgroup_size(64)
fn main(@builtin(local_invocation_index) lane: u32) {
    shared_[lane] = data[lane] + 7u;
    workgroupBarrier();
    if lane < 32u {
        data[lane] = shared_[63u - lane];
    }
}
";
    let kernel = Kernel::new(source).expect("it is valid");
    let mutants: Vec<_> = (0..kernel.len())
        .filter_map(|i| kernel.mutant(i).ok())
        .collect();
    let original = kernel.original().expect("it is valid");
    for said in [
        "Add to Subtract",
        "no barrier",
        "no store",
        "Less to LessEqual",
        "the other way",
        "U32(7)",
    ] {
        let found = mutants.iter().find(|mutant| mutant.what.contains(said));
        let found = found.unwrap_or_else(|| panic!("no mutant with `{said}`"));
        assert_ne!(found.text, original, "{said}");
    }
    assert!(
        mutants.iter().all(|mutant| mutant.text != original),
        "a mutant is the original"
    );
    let without = mutants
        .iter()
        .find(|mutant| mutant.what.contains("no barrier"));
    assert!(
        !without
            .expect("there is one")
            .text
            .contains("workgroupBarrier")
    );
}
