//! Decisions that a rounding takes, and differences that it does not explain.
use crate::common::cpu;
use crate::sabotage::{How, Sabotaged};
use gibs::check::{Case, CheckOptions, Participant, Upload, Verdict, check, undecided_cap};
use gibs::graph::{Dispatch, Graph, WgslSource, Workgroup, bytemuck, stage};
use gibs_backend_cpu::{CpuBackend, Options};

stage! {
    /// Whether numbers are above a half, and what is left of them where one is taken away: a decision and a cancellation.
    pub stage Judge {
        wgsl: WgslSource { name: "judge", text: "", modules: &[], features: &[] },
        workgroup: [64, 1, 1],
        ports: { read numbers: f32, write above: u32, write left: f32 },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(p: &Views<'_>, group: Workgroup) {
    for i in group.range(p.numbers.len() as u32) {
        p.above.set(i, u32::from(p.numbers[i] > 0.5));
        p.left.set(i, p.numbers[i] * p.numbers[i] - 1.0);
    }
}

const COUNT: u64 = 4000;

/// Runs the stage on numbers of which `close` are a rounding away from both decision and cancellation, against a backend
/// that has damaged one port.
fn judged(close: usize, port: &'static str, damage: fn(&mut [u8])) -> (Verdict, u64, u64) {
    let mut g = Graph::new("judge");
    let numbers = g.input::<f32>("numbers", COUNT);
    let above = g.transient::<u32>("above", COUNT);
    let left = g.transient::<f32>("left", COUNT);
    let inputs = Inputs {
        numbers: &numbers,
        above,
        left,
    };
    let out = g.add::<Judge>("judge", inputs, Dispatch::Elements(COUNT));
    g.output("above", &out.above);
    g.output("left", &out.left);
    g.keep_transients();
    let schedule = g.compile(None).expect("it is sound");
    let resource = schedule.resource("numbers").expect("an input");
    let values: Vec<f32> = (0..COUNT as usize)
        .map(|i| match (i < close, port) {
            (true, "above") => 0.5,
            (true, _) => 1.0,
            (false, _) => 3.0,
        })
        .collect();
    let bytes: Vec<u8> = bytemuck::cast_slice(&values).to_vec();
    let mut cases = [Case::new("judge", schedule.into(), 0..1, move |_| {
        Ok(vec![Upload {
            resource,
            offset: 0,
            bytes: bytes.clone(),
        }])
    })];
    let oracle = CpuBackend::new(Options {
        scalar: true,
        ..Options::default()
    })
    .expect("threads start");
    let other = Sabotaged {
        inner: cpu(),
        stage: "Judge",
        port,
        from: 0,
        how: How::Damage(damage),
    };
    let participants = [
        Participant::named("cpu-scalar", &oracle),
        Participant::new(&other),
    ];
    let checked = check(
        &mut cases,
        &participants,
        &CheckOptions::default(),
        |_, _, _| {},
    );
    let report = checked.expect("it runs").report;
    assert!(report.gaps(&cases, &participants).is_empty());
    let (.., pair) = report
        .pairs()
        .find(|(.., found, _)| found.port == port)
        .expect("a port");
    (pair.verdict, pair.undecided, pair.refused)
}

/// A rounding of the input decides otherwise, so the backend that did is not wrong.
#[test]
fn a_decision_at_its_threshold_is_undecided() {
    let flip: fn(&mut [u8]) = |bytes| bytes[..4].copy_from_slice(&1_u32.to_ne_bytes());
    assert_eq!(judged(1, "above", flip), (Verdict::Undecided, 1, 0));
    // Far from the threshold, it is.
    assert_eq!(
        judged(0, "above", |bytes| bytes[0] ^= 1),
        (Verdict::Differs, 0, 1)
    );
}

/// Of a thousandth of the elements at most.
#[test]
fn many_undecided_elements_are_a_difference() {
    assert_eq!(undecided_cap(COUNT), 4);
    let flip: fn(&mut [u8]) = |bytes| {
        for word in bytes.chunks_exact_mut(4).take(5) {
            word.copy_from_slice(&1_u32.to_ne_bytes());
        }
    };
    let (verdict, ..) = judged(5, "above", flip);
    assert_eq!(verdict, Verdict::Differs);
    let flip: fn(&mut [u8]) = |bytes| {
        for word in bytes.chunks_exact_mut(4).take(4) {
            word.copy_from_slice(&1_u32.to_ne_bytes());
        }
    };
    assert_eq!(judged(4, "above", flip), (Verdict::Undecided, 4, 0));
}

/// `x * x - 1` at 1 moves by two ULP of 1 per ULP of `x`; more than a few of those is no rounding.
#[test]
fn a_cancellation_is_excused_as_far_as_it_goes() {
    let near: fn(&mut [u8]) =
        |bytes| bytes[..4].copy_from_slice(&(3.0 * f32::EPSILON).to_ne_bytes());
    assert_eq!(judged(1, "left", near), (Verdict::Undecided, 1, 0));
    let far: fn(&mut [u8]) =
        |bytes| bytes[..4].copy_from_slice(&(100.0 * f32::EPSILON).to_ne_bytes());
    assert_eq!(judged(1, "left", far), (Verdict::Differs, 0, 1));
}

/// A value that is not there has no rounding that would explain it.
#[test]
fn what_is_missing_is_never_undecided() {
    let nan: fn(&mut [u8]) = |bytes| bytes[..4].copy_from_slice(&f32::NAN.to_ne_bytes());
    let (verdict, ..) = judged(1, "left", nan);
    assert_eq!(verdict, Verdict::Differs);
}

/// A number far from any that moved inputs give is no decision of a rounding.
#[test]
fn another_integer_is_no_decision() {
    let other: fn(&mut [u8]) = |bytes| bytes[..4].copy_from_slice(&1000_u32.to_ne_bytes());
    assert_eq!(judged(1, "above", other), (Verdict::Differs, 0, 1));
    // Nor is one that is near: integers have no distance.
    let near: fn(&mut [u8]) = |bytes| bytes[..4].copy_from_slice(&2_u32.to_ne_bytes());
    assert_eq!(judged(1, "above", near), (Verdict::Differs, 0, 1));
}
