//! Running captures with contents of any kind: kernels may find anything in their buffers.
use crate::captures::{captures, scalar};
use crate::edits::{ByteEdit, byte_edits, edit_bytes};
use crate::watch::{about, cases, watched};
use gibs::check::{Capture, CaptureError, CapturedBuffer, CapturedSize, replay, verify};
use gibs::graph::{Access, Backend, Layout, StageInfo};
use gibs::passes::stages;
use gibs_backend_cpu::{CpuBackend, Options};
use proptest::prelude::*;
use proptest::sample::Index;
use std::sync::OnceLock;

/// Workgroups that a test has time for. A capture may ask for up to four billion, and gets them.
const MOST_GROUPS: u64 = 1 << 12;

fn all_stages() -> &'static [StageInfo] {
    static STAGES: OnceLock<Vec<StageInfo>> = OnceLock::new();
    STAGES.get_or_init(stages::all)
}

/// The kernels of the CPU in their three ways.
fn backends() -> &'static [CpuBackend] {
    static BACKENDS: OnceLock<Vec<CpuBackend>> = OnceLock::new();
    BACKENDS.get_or_init(|| {
        let wide = CpuBackend::new(Options::default()).expect("threads start");
        let checked = Options {
            checked: true,
            ..Options::default()
        };
        vec![
            scalar(),
            wide,
            CpuBackend::new(checked).expect("threads start"),
        ]
    })
}

/// Whether a buffer says how long a kernel runs, and says another time than in any sound capture: a tree, in which a node may
/// be its own child, or a uniform with settings and sizes. Kernels trust these, on devices as well, because what makes them
/// checks them; a capture that was tampered with may run for hours, as one of four billion workgroups does.
fn sets_the_time(capture: &Capture) -> bool {
    let name = |buffer: &CapturedBuffer| match &buffer.element {
        Layout::Struct { name, .. } => name.clone(),
        _ => String::new(),
    };
    let times = |capture: &Capture, id: usize| {
        let name = name(&capture.buffers[id]);
        let mut bound = capture
            .bindings
            .iter()
            .filter(|binding| binding.buffer as usize == id);
        let uniform = bound.any(|binding| binding.access == Access::Uniform);
        (uniform && name != "DispatchArgs") || name.contains("Node")
    };
    let is_known = |id: usize| {
        let bytes = &capture.buffers[id].bytes;
        captures()
            .iter()
            .flat_map(|sound| &sound.buffers)
            .any(|sound| sound.bytes == *bytes)
    };
    (0..capture.buffers.len()).any(|id| times(capture, id) && !is_known(id))
}

/// Whether it is small enough to be run here.
fn is_short(capture: &Capture) -> bool {
    if sets_the_time(capture) {
        return false;
    }
    let groups = match capture.size {
        CapturedSize::Groups(groups) => groups,
        CapturedSize::Indirect(id) => {
            let bytes = &capture.buffers[id as usize].bytes;
            let word = |i: usize| {
                bytes
                    .get(4 * i..4 * i + 4)
                    .map_or(0, |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
            };
            [0, 1, 2].map(word)
        }
    };
    // What is refused takes no time.
    let total = groups
        .iter()
        .map(|&n| u64::from(n))
        .fold(1, u64::saturating_mul);
    total <= MOST_GROUPS || groups.iter().any(|&n| n > 65_535) || total > u64::from(u32::MAX)
}

/// Runs a capture and compares: results or errors that name the stage.
pub fn run(capture: &Capture) {
    if !is_short(capture) {
        return;
    }
    for backend in backends() {
        about(format!("{} on {:?}", capture.stage, backend.device().notes));
        match replay(capture, all_stages(), backend, 1) {
            Ok(replayed) => {
                assert_eq!(replayed.outputs.len(), capture.written().len());
                for origin in &capture.results {
                    verify(
                        capture,
                        &replayed.schedule,
                        &origin.outputs,
                        &replayed.outputs,
                    );
                }
            }
            Err(CaptureError::Backend { source, .. }) => {
                assert!(!source.to_string().is_empty(), "{}", backend.name())
            }
            Err(error) => assert!(error.to_string().contains(&capture.stage), "{error}"),
        }
    }
}

/// Damage of one buffer.
fn damage() -> impl Strategy<Value = (Index, Vec<ByteEdit>, bool)> {
    (any::<Index>(), byte_edits(), prop::bool::weighted(0.1))
}

proptest! {
    #![proptest_config(cases(3000))]

    /// Indices that lead nowhere, trees with circles, counts beyond their lists, floats that are no numbers.
    #[test]
    fn any_content_is_run_or_refused(which: Index, damages in prop::collection::vec(damage(), 1..5)) {
        let mut capture = which.get(captures()).clone();
        for (at, edits, everything) in &damages {
            let i = at.index(capture.buffers.len());
            let before = capture.clone();
            let bytes = &mut capture.buffers[i].bytes;
            let len = bytes.len();
            edit_bytes(bytes, edits);
            bytes.resize(len, 0xff);
            if *everything {
                let word = [bytes[0], bytes[len / 2], bytes[len / 3], bytes[len - 1]];
                bytes.iter_mut().zip(word.iter().cycle()).for_each(|(byte, new)| *byte = *new);
            }
            if sets_the_time(&capture) {
                capture = before;
            }
        }
        watched(|| run(&capture));
    }
}
