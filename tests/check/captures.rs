//! Captures: what a difference leaves behind, run alone and shrunk; and where two backends part.
use crate::common::{all_backends, cpu};
use crate::sabotage::{Damage, How, Sabotaged};
use gibs::builtin;
use gibs::check::{
    Capture, CaptureError, Case, CheckOptions, Participant, Way, bisect, check, reduce, replay,
    surfels, verify,
};
use gibs::graph::bytemuck;
use gibs::passes::data::SurfelIrradiance;
use gibs::passes::frame::Settings;
use gibs::passes::stages;
use gibs_backend_cpu::{CpuBackend, Options};
use std::path::{Path, PathBuf};

fn scalar() -> CpuBackend {
    let options = Options {
        scalar: true,
        ..Options::default()
    };
    CpuBackend::new(options).expect("threads start")
}

fn case(frames: u32) -> Case<'static> {
    let settings = Settings {
        surfels: 256,
        rays: 256,
        ..Settings::default()
    };
    let scene = builtin::by_name("cornell").expect("built in");
    surfels("cornell", &scene, [48, 27], 0..frames, &settings).expect("a frame")
}

fn sabotaged(stage: &'static str, port: &'static str, from: u32, damage: Damage) -> Sabotaged {
    Sabotaged {
        inner: cpu(),
        stage,
        port,
        from,
        how: How::Damage(damage),
    }
}

/// Changes the first number that is not zero.
fn first(bytes: &mut [u8]) {
    let lit = bytes
        .chunks_exact(4)
        .position(|word| word != [0; 4] && word[3] != 0x7f);
    let at = 4 * lit.expect("not all zero");
    bytes[at + 2] ^= 0x20;
}

/// A capture of a stage in the second frame.
fn captured(stage: &'static str, port: &'static str) -> Capture {
    let (oracle, other) = (scalar(), sabotaged(stage, port, 1, first));
    let participants = [
        Participant::named("cpu-scalar", &oracle),
        Participant::new(&other),
    ];
    let options = CheckOptions {
        captures: 1,
        ..CheckOptions::default()
    };
    let checked = check(&mut [case(2)], &participants, &options, |_, _, _| {});
    let mut captures = checked.expect("it runs").captures;
    captures.pop().expect("a difference")
}

fn temporary(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

#[test]
fn a_capture_is_read_as_it_was_written() {
    let capture = captured("Integrate", "light");
    let file = temporary("capture-round-trip.npz");
    capture.write(&file).expect("written");
    assert_eq!(Capture::read(&file).expect("read"), capture);
}

/// From its inputs alone, every backend gives what the oracle gave, time after time; the sabotaged results are recognized.
#[test]
fn a_capture_replays_on_every_backend() {
    for (stage, port) in [
        ("Integrate", "light"),
        ("TraceClosest", "hits"),
        ("GridScatter", "entries"),
        ("Compose", "color"),
        ("GridOrder", "cells"),
    ] {
        let capture = captured(stage, port);
        let [oracle, damaged] = &capture.results[..] else {
            panic!("two took part");
        };
        for backend in all_backends() {
            let name = backend.name().to_owned();
            let replayed = replay(&capture, &stages::all(), backend.as_ref(), 3)
                .unwrap_or_else(|e| panic!("{stage} on {name}: {e}"));
            assert_eq!(replayed.times.len(), 3);
            let found = verify(
                &capture,
                &replayed.schedule,
                &oracle.outputs,
                &replayed.outputs,
            );
            assert!(!found.is_empty());
            for (port, found) in found {
                assert!(
                    found.refused.is_empty(),
                    "{stage} {port} on {name}: {:?}",
                    found.worst
                );
            }
            let found = verify(
                &capture,
                &replayed.schedule,
                &damaged.outputs,
                &replayed.outputs,
            );
            let found = found.iter().find(|(name, _)| name == port).expect("a port");
            assert!(!found.1.refused.is_empty(), "{stage} on {name}");
        }
    }
}

/// What is left of a capture is what the failure needs: here, one surfel with one ray.
#[test]
fn a_capture_shrinks_to_what_fails() {
    let capture = captured("Integrate", "light");
    let (oracle, other) = (scalar(), sabotaged_always());
    let stages = stages::all();
    let mut differ = |candidate: &Capture| -> Result<bool, CaptureError> {
        let expected = replay(candidate, &stages, &oracle, 1)?;
        let found = replay(candidate, &stages, &other, 1)?;
        let found = verify(
            candidate,
            &expected.schedule,
            &expected.outputs,
            &found.outputs,
        );
        Ok(found.iter().any(|(_, found)| !found.refused.is_empty()))
    };
    assert!(differ(&capture).expect("it runs"));
    let reduced = reduce(&capture, 2000, &mut differ).expect("it runs");
    println!(
        "{:?} bytes after {} candidates",
        reduced.nonzero, reduced.tried
    );
    assert!(
        differ(&reduced.capture).expect("it runs"),
        "what is left still fails"
    );
    let [before, after] = reduced.nonzero;
    assert!(after * 50 < before, "{after} of {before} bytes are left");
    // It can be written and replayed like any other.
    let file = temporary("capture-reduced.npz");
    reduced.capture.write(&file).expect("written");
    assert!(differ(&Capture::read(&file).expect("read")).expect("it runs"));
}

/// A stage that is wrong where the light is not zero.
fn sabotaged_always() -> Sabotaged {
    sabotaged("Integrate", "light", 0, |bytes| {
        if let Some(lit) = bytes.chunks_exact(4).position(|word| word != [0; 4]) {
            bytes[4 * lit + 2] ^= 0x20;
        }
    })
}

/// Damages surfels that have drawn many rays, as a bug that takes time to show would.
fn late(bytes: &mut [u8]) {
    for surfel in bytes.chunks_exact_mut(size_of::<SurfelIrradiance>()) {
        let mut state: SurfelIrradiance = bytemuck::pod_read_unaligned(surfel);
        if state.drawn > LATE {
            state.mean.y += 1.0;
            surfel.copy_from_slice(bytemuck::bytes_of(&state));
        }
    }
}

/// Rays; the surfels of the test draw so many after some frames.
const LATE: u32 = 32;

#[test]
fn bisection_finds_frame_stage_port_and_element() {
    let other = sabotaged("Integrate", "irradiance", 0, late);
    let oracle = scalar();
    let participants = [
        Participant::named("cpu-scalar", &oracle),
        Participant::new(&other),
    ];
    let parting = bisect(&mut case(16), participants, false, |_, _| {});
    let parting = parting.expect("it runs").expect("they part");
    println!("they part in frame {}", parting.frame);
    assert!(parting.frame > 0, "the bug takes time to show");
    let place = (parting.stage.as_str(), parting.port.as_str(), parting.way);
    assert_eq!(place, ("Integrate", "irradiance", Way::Stage));
    assert_eq!(parting.difference.field, ".mean.y");
    let capture = parting.capture.expect("a capture");
    assert_eq!(
        (capture.frame, capture.stage.as_str()),
        (parting.frame, "Integrate")
    );
    // The capture alone shows the same elements, and no frame before had one that was damaged.
    let found = replay(&capture, &stages::all(), &oracle, 1).expect("it runs");
    let damaged = &capture.results[1].outputs;
    let found = verify(&capture, &found.schedule, damaged, &found.outputs);
    let refused: Vec<_> = found
        .iter()
        .flat_map(|(_, found)| found.refused.clone())
        .collect();
    assert_eq!(refused.len() as u64, parting.refused);
    assert!(refused.contains(&parting.difference.element));
    let before = capture
        .buffers
        .iter()
        .find(|b| b.key == "surfel_irradiance")
        .expect("bound");
    let before: Vec<SurfelIrradiance> = bytemuck::pod_collect_to_vec(&before.bytes);
    assert!(before.iter().all(|surfel| surfel.drawn <= LATE));
}

#[test]
fn backends_that_agree_have_no_parting() {
    let (oracle, other) = (scalar(), cpu());
    let participants = [
        Participant::named("cpu-scalar", &oracle),
        Participant::new(other.as_ref()),
    ];
    assert!(
        bisect(&mut case(4), participants, true, |_, _| {})
            .expect("it runs")
            .is_none()
    );
}

/// What a backend says while it is searched is told with the case and the frame.
#[test]
fn a_backend_that_fails_is_told_with_its_case() {
    let other = Sabotaged {
        how: How::Fail,
        ..sabotaged("Compose", "color", 1, first)
    };
    let oracle = scalar();
    let participants = [
        Participant::named("cpu-scalar", &oracle),
        Participant::new(&other),
    ];
    let error = bisect(&mut case(3), participants, false, |_, _| {});
    let said = error.expect_err("it fails").to_string();
    assert!(said.starts_with("`cornell`, frame 1, "), "{said}");
}

/// Files that are no captures, or have been tampered with, are refused with the reason.
#[test]
fn broken_captures_are_refused() {
    let file = temporary("capture-broken.npz");
    let refused = |bytes: &[u8]| {
        std::fs::write(&file, bytes).expect("written");
        Capture::read(&file).expect_err("it is broken").to_string()
    };
    assert!(refused(b"").contains("no capture"));
    assert!(refused(b"PK\x03\x04 and then nothing").contains("no capture"));
    let capture = captured("Integrate", "light");
    capture.write(&file).expect("written");
    let sound = std::fs::read(&file).expect("read");
    for cut in [10, sound.len() / 2, sound.len() - 1] {
        assert!(
            refused(&sound[..cut]).contains("no capture"),
            "cut at {cut}"
        );
    }
    let missing = Capture::read(&temporary("no-such-capture.npz")).expect_err("it is not there");
    assert!(missing.to_string().contains("no-such-capture.npz"));
    let mut unknown = capture.clone();
    unknown.stage = "Nothing".into();
    let error = replay(&unknown, &stages::all(), &scalar(), 1).expect_err("no such stage");
    assert!(
        matches!(error, CaptureError::UnknownStage { .. }),
        "{error}"
    );
    let mut changed = capture;
    changed.bindings[0].port = "other".into();
    let error = replay(&changed, &stages::all(), &scalar(), 1).expect_err("no such port");
    assert!(matches!(error, CaptureError::Changed { .. }), "{error}");
}

/// A stage that writes over what it only reads shows it alone as well; one that does not, on any backend, does not.
#[test]
fn a_replay_tells_what_a_stage_scribbled_over() {
    let scribble: Damage = |bytes| bytes[0] ^= 1;
    let capture = captured("Compose", "points");
    for backend in all_backends() {
        let sound = replay(&capture, &stages::all(), backend.as_ref(), 1).expect("it runs");
        assert!(sound.scribbled.is_empty(), "{:?}", sound.scribbled);
    }
    let other = sabotaged("Compose", "points", 0, scribble);
    let found = replay(&capture, &stages::all(), &other, 1).expect("it runs");
    assert_eq!(found.scribbled, ["gbuffer_points"]);
}
