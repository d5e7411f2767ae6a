//! What has to fail, fails.
use crate::common::cpu;
use crate::sabotage::{Damage, How, Sabotaged};
use gibs::builtin;
use gibs::check::{
    Capture, Case, CheckError, CheckOptions, Checked, Expectation, Expectations, Gap, Participant,
    Plan, Report, Verdict, check, surfels,
};
use gibs::graph::{Backend, Comparator};
use gibs::passes::frame::Settings;
use gibs_backend_cpu::{CpuBackend, Options};

fn scalar() -> CpuBackend {
    let options = Options {
        scalar: true,
        ..Options::default()
    };
    CpuBackend::new(options).expect("threads start")
}

fn case() -> Case<'static> {
    let plan = Plan::default();
    let settings = Settings {
        surfels: 256,
        rays: 256,
        ..Settings::default()
    };
    let scene = builtin::by_name("cornell").expect("built in");
    surfels("cornell", &scene, plan.size, 0..2, &settings).expect("a frame")
}

fn against(other: &dyn Backend) -> (Checked, [Case<'static>; 1]) {
    let mut cases = [case()];
    let oracle = scalar();
    let participants = [
        Participant::named("cpu-scalar", &oracle),
        Participant::new(other),
    ];
    let options = CheckOptions {
        captures: 4,
        ..CheckOptions::default()
    };
    let checked = check(&mut cases, &participants, &options, |_, _, _| {}).expect("it runs");
    (checked, cases)
}

/// What a report of [`against`] leaves out.
fn gaps(report: &Report, cases: &[Case<'_>]) -> Vec<Gap> {
    let (oracle, other) = (scalar(), cpu());
    let participants = [
        Participant::named("cpu-scalar", &oracle),
        Participant::new(other.as_ref()),
    ];
    report.gaps(cases, &participants)
}

fn sabotaged(stage: &'static str, port: &'static str, from: u32, how: How) -> Sabotaged {
    Sabotaged {
        inner: cpu(),
        stage,
        port,
        from,
        how,
    }
}

/// Nothing but the damaged port of the damaged stage differs, because all go on from the oracle's values.
fn fails_at(stage: &'static str, port: &'static str, how: How) {
    let (checked, cases) = against(&sabotaged(stage, port, 1, how));
    assert_eq!(checked.report.verdict(), Verdict::Differs);
    let differs: Vec<_> = checked
        .report
        .pairs()
        .filter(|(.., pair)| pair.verdict == Verdict::Differs)
        .collect();
    for (_, step, found, pair) in &differs {
        assert_eq!((step.stage.as_str(), found.port.as_str()), (stage, port));
        assert_eq!(pair.differs_in, Some(1), "the first frame is sound");
        assert!(pair.refused > 0);
    }
    assert_eq!(differs.len(), 1);
    assert!(gaps(&checked.report, &cases).is_empty());
    let [capture] = &checked.captures[..] else {
        panic!("{} captures", checked.captures.len());
    };
    assert_eq!((capture.stage.as_str(), capture.frame), (stage, 1));
    let name = format!("check-harness-{stage}-{port}.npz");
    let file = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    capture.write(&file).expect("written");
    assert_eq!(Capture::read(&file).expect("read"), *capture);
}

#[test]
fn a_sound_pair_passes() {
    let (checked, cases) = against(cpu().as_ref());
    assert_eq!(checked.report.verdict(), Verdict::Equal);
    assert!(gaps(&checked.report, &cases).is_empty());
    assert!(checked.captures.is_empty());
    println!("{} elements", checked.report.elements());
    assert!(checked.report.elements() > 100_000);
}

/// One bit of an integer; one high bit of a mantissa.
#[test]
fn a_flipped_bit_fails() {
    let last_byte: Damage = |bytes| {
        let middle = bytes.len() / 8 * 4;
        bytes[middle] ^= 1;
    };
    fails_at("AllocateRays", "spans", How::Damage(last_byte));
    let mantissa: Damage = |bytes| {
        let lit = bytes.chunks_exact(4).position(|word| word[3] == 0x3f);
        bytes[4 * lit.expect("some light is near 1") + 2] ^= 0x40;
    };
    fails_at("Compose", "color", How::Damage(mantissa));
}

#[test]
fn a_nan_fails() {
    let nan: Damage = |bytes| bytes[..4].copy_from_slice(&f32::NAN.to_ne_bytes());
    fails_at("Compose", "color", How::Damage(nan));
}

/// A stage that writes over what it only reads: a transient, a state, a buffer of the host's, a uniform. Each is found where it
/// happens, and does no harm to what comes after.
#[test]
fn a_stage_that_scribbles_over_what_it_reads_fails() {
    let scribble: Damage = |bytes| bytes.chunks_exact_mut(4).for_each(|word| word[0] ^= 0x7f);
    for (stage, port) in [
        ("Compose", "points"),
        ("Integrate", "poses"),
        ("GatherSurfels", "light"),
        ("ResolveHits", "triangles"),
        ("ShadeHits", "frame"),
    ] {
        fails_at(stage, port, How::Damage(scribble));
    }
}

/// A NaN on both sides is no agreement.
#[test]
fn a_nan_on_both_backends_fails() {
    let nan: Damage = |bytes| bytes[..4].copy_from_slice(&f32::NAN.to_ne_bytes());
    let with_nan = |inner: Box<dyn Backend>| Sabotaged {
        inner,
        ..sabotaged("Compose", "color", 0, How::Damage(nan))
    };
    let (a, b) = (with_nan(Box::new(scalar())), with_nan(cpu()));
    let mut cases = [case()];
    let participants = [Participant::named("cpu-scalar", &a), Participant::new(&b)];
    let checked = check(
        &mut cases,
        &participants,
        &CheckOptions::default(),
        |_, _, _| {},
    );
    let report = checked.expect("it runs").report;
    assert_eq!(report.verdict(), Verdict::Differs);
}

#[test]
fn a_missing_output_fails() {
    fails_at("Compose", "color", How::Truncate);
}

/// What neither has is as missing.
#[test]
fn an_output_that_is_missing_on_both_backends_fails() {
    let short = |inner: Box<dyn Backend>| Sabotaged {
        inner,
        ..sabotaged("Compose", "color", 0, How::Truncate)
    };
    let (a, b) = (short(Box::new(scalar())), short(cpu()));
    let participants = [Participant::named("cpu-scalar", &a), Participant::new(&b)];
    let checked = check(
        &mut [case()],
        &participants,
        &CheckOptions::default(),
        |_, _, _| {},
    );
    let report = checked.expect("it runs").report;
    assert_eq!(report.verdict(), Verdict::Differs);
}

/// What was not written differs from what was, also where the frame before had written the same.
#[test]
fn a_stage_that_does_not_run_fails() {
    let (checked, _) = against(&sabotaged("Compose", "color", 1, How::Skip));
    let differs: Vec<_> = checked
        .report
        .pairs()
        .filter(|(.., pair)| pair.verdict == Verdict::Differs)
        .map(|(_, step, port, _)| (step.stage.as_str(), port.port.as_str()))
        .collect();
    assert_eq!(differs, [("Compose", "irradiance"), ("Compose", "color")]);
}

#[test]
fn values_in_another_order_fail_where_order_counts() {
    let swapped: Damage = |bytes| {
        let places: Vec<usize> = (0..bytes.len() / 16).collect();
        let different = places
            .iter()
            .find(|i| bytes[16 * **i..][..16] != bytes[..16]);
        let at = 16 * different.expect("not one colour everywhere");
        let (front, back) = bytes.split_at_mut(at);
        front[..16].swap_with_slice(&mut back[..16]);
    };
    fails_at("Compose", "color", How::Damage(swapped));
}

/// What the comparator allows is told apart from equal bits.
#[test]
fn a_rounding_is_within() {
    let ulp: Damage = |bytes| {
        let lit = bytes.chunks_exact(4).position(|word| word[3] == 0x3f);
        let at = 4 * lit.expect("some light is near 1");
        bytes[at] ^= 1;
    };
    let (checked, _) = against(&sabotaged("Compose", "color", 0, How::Damage(ulp)));
    assert_eq!(checked.report.verdict(), Verdict::Within);
    let (.., worst) = checked
        .report
        .pairs()
        .find(|(.., p)| p.unequal > 0)
        .expect("one");
    assert_eq!((worst.unequal, worst.refused), (2, 0));
    assert!(
        worst
            .worst
            .as_ref()
            .is_some_and(|(_, worst)| worst.ulps == 1.0)
    );
}

/// Where equal bits are asked for, the same rounding is a difference.
#[test]
fn a_rounding_differs_where_bits_are_asked_for() {
    let ulp: Damage = |bytes| {
        let lit = bytes.chunks_exact(4).position(|word| word[3] == 0x3f);
        bytes[4 * lit.expect("some light is near 1")] ^= 1;
    };
    let other = sabotaged("Compose", "color", 0, How::Damage(ulp));
    let oracle = scalar();
    let participants = [
        Participant::named("cpu-scalar", &oracle),
        Participant::new(&other),
    ];
    let options = CheckOptions {
        exact: vec![("cpu".into(), "cpu-scalar".into())],
        ..CheckOptions::default()
    };
    let checked = check(&mut [case()], &participants, &options, |_, _, _| {});
    assert_eq!(checked.expect("it runs").report.verdict(), Verdict::Differs);
}

#[test]
fn a_backend_is_not_compared_with_itself() {
    let (a, b) = (cpu(), cpu());
    let compare = |participants: &[Participant<'_>]| {
        check(
            &mut [case()],
            participants,
            &CheckOptions::default(),
            |_, _, _| {},
        )
        .err()
    };
    let twice = [
        Participant::new(a.as_ref()),
        Participant::named("cpu-2", b.as_ref()),
    ];
    assert!(matches!(compare(&twice), Some(CheckError::Same { .. })));
    let swapped = [
        Participant::new(a.as_ref()),
        Participant::named("vulkan", b.as_ref()),
    ];
    assert!(matches!(
        compare(&swapped),
        Some(CheckError::Mislabelled { .. })
    ));
    assert!(matches!(
        compare(&twice[..1]),
        Some(CheckError::TooFew { found: 1 })
    ));
    assert!(matches!(
        compare(&[]),
        Some(CheckError::TooFew { found: 0 })
    ));
}

/// A report from which anything is taken, or in which a comparator was loosened, is found out.
#[test]
fn a_report_that_did_not_look_is_found_out() {
    let (checked, cases) = against(cpu().as_ref());
    let report = checked.report;
    assert!(gaps(&report, &cases).is_empty());
    let gaps = |change: fn(&mut Report)| {
        let mut changed = report.clone();
        change(&mut changed);
        gaps(&changed, &cases).len()
    };
    assert!(gaps(|r| r.cases.clear()) > 0, "no case");
    assert!(
        gaps(|r| r.cases.push(r.cases[0].clone())) > 0,
        "a case twice"
    );
    assert!(gaps(|r| drop(r.cases[0].steps.remove(7))) > 0, "no step");
    assert!(
        gaps(|r| drop(r.cases[0].steps[7].ports.remove(0))) > 0,
        "no port"
    );
    assert!(
        gaps(|r| r.cases[0].steps[7].ports[0].pairs.clear()) > 0,
        "no pair"
    );
    assert!(
        gaps(|r| r.cases[0].steps[7].ports[0].pairs[0].frames = 1) > 0,
        "a frame less"
    );
    assert!(
        gaps(|r| r.cases[0].steps[7].ports[0].pairs[0].elements = 0) > 0,
        "nothing"
    );
    assert!(
        gaps(|r| r.cases[0].steps[7].ports[0].pairs[0].elements -= 1) > 0,
        "not all elements"
    );
    assert!(gaps(|r| r.lanes.truncate(1)) > 0, "no reference");
    assert!(gaps(|r| r.lanes.swap(0, 1)) > 0, "another reference");
    assert!(
        gaps(|r| r.cases[0].steps[7].ports[0].pairs[0].refused = 1) > 0,
        "a wrong verdict"
    );
    let loosened: fn(&mut Report) = |r| {
        r.cases[0].steps[7].ports[0].comparator = Comparator::scaled(17, "looser");
    };
    assert!(gaps(loosened) > 0, "a looser comparator");
    let absolute: fn(&mut Report) = |r| {
        r.cases[0].steps[7].ports[0].comparator = Comparator::absolute(1e-9, "another kind");
    };
    assert!(gaps(absolute) > 0, "a comparator of another kind");
    let tightened: fn(&mut Report) = |r| {
        r.cases[0].steps[7].ports[0].comparator = Comparator::exact("tighter");
    };
    assert_eq!(gaps(tightened), 0, "a tighter one is as good");
}

/// A difference that is listed passes; one that is listed and does not come is an error, unless its device took no part.
#[test]
fn expected_differences_have_to_come() {
    let nan: Damage = |bytes| bytes[..4].copy_from_slice(&f32::NAN.to_ne_bytes());
    let (checked, cases) = against(&sabotaged("Compose", "color", 0, How::Damage(nan)));
    let device = cpu().device().name.clone();
    let expectation = |device: &str, stage: &str, port: Option<&str>| Expectation {
        device: device.into(),
        backend: Some("cpu".into()),
        stage: stage.into(),
        port: port.map(Into::into),
        reason: "a test".into(),
    };
    let apply = |expectation: &Expectation| {
        let list = Expectations {
            expected: vec![expectation.clone()],
        };
        let mut report = checked.report.clone();
        let unmet = list.apply(&mut report).len();
        assert!(gaps(&report, &cases).is_empty());
        (report.verdict(), unmet)
    };
    let known = expectation(&device.to_uppercase(), "Compose", Some("color"));
    assert_eq!(apply(&known), (Verdict::Expected, 0));
    assert_eq!(
        apply(&expectation(&device, "Compose", None)),
        (Verdict::Expected, 0)
    );
    let elsewhere = expectation(&device, "Integrate", None);
    assert_eq!(apply(&elsewhere), (Verdict::Differs, 1));
    let absent = expectation("a device of the future", "Integrate", None);
    assert_eq!(apply(&absent), (Verdict::Differs, 0));
}
